/*
 * jostle for C++17: owners, exceptions and containers over jostle.h. It adds no behaviour: everything that matters is
 * documented there.
 *
 * A failing call throws jostle::error. Where exceptions are off (-fno-exceptions) it calls jostle::on_error instead,
 * which a program may replace; by default it ends the program with std::abort, since there is no way to go on.
 * Objects are move-only and free themselves, in any order. The C functions take jostle::x::get().
 */
#ifndef JOSTLE_JOSTLE_HPP
#define JOSTLE_JOSTLE_HPP

#include <jostle/jostle.h>

#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#if defined(__cpp_exceptions) || defined(__EXCEPTIONS) || defined(_CPPUNWIND)
#define JOSTLE_HAS_EXCEPTIONS 1
#include <exception>
#include <stdexcept>
#else
#define JOSTLE_HAS_EXCEPTIONS 0
#endif

inline bool operator==(jostle_body a, jostle_body b) noexcept { return a.id == b.id; }
inline bool operator!=(jostle_body a, jostle_body b) noexcept { return a.id != b.id; }

namespace jostle {

using action = jostle_action;
using body = jostle_body;
using body_def = jostle_body_def;
using body_pose = jostle_body_pose;
using goal = jostle_goal;
using grasp = jostle_grasp;
using grasp_report = jostle_grasp_report;
using image_frame = jostle_image_frame;
using seen_body = jostle_seen_body;
using pose2 = jostle_pose2;
using progress = jostle_progress;
using ranked_action = jostle_ranked_action;
using statistics = jostle_plan_statistics;
using vec2 = jostle_vec2;

#if JOSTLE_HAS_EXCEPTIONS
/// A call that failed: its status and what jostle_last_error() said.
class error : public std::runtime_error {
public:
    error(jostle_status status, const char *message) : std::runtime_error(message), status_(status) {}
    jostle_status status() const noexcept { return status_; }

private:
    jostle_status status_;
};
#else
/// What a failing call does where exceptions are off. It must not return.
using error_handler = void (*)(jostle_status status, const char *message);
inline error_handler on_error = [](jostle_status, const char *) { std::abort(); };
#endif

/// Throws if `status` is a failure.
inline void check(jostle_status status) {
    if (status == JOSTLE_OK) return;
#if JOSTLE_HAS_EXCEPTIONS
    throw error(status, jostle_last_error());
#else
    on_error(status, jostle_last_error());
    std::abort();
#endif
}

/// Refuses a library that does not fit this header. Call it first.
inline void check_abi() { check(jostle_abi_check(JOSTLE_ABI_VERSION)); }

/// A borrowed run of values: a vector, an array, a list in braces.
template <class T>
class view {
public:
    constexpr view() noexcept = default;
    constexpr view(const T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    view(const std::vector<T> &values) noexcept : data_(values.data()), size_(values.size()) {}
    template <std::size_t N>
    constexpr view(const T (&values)[N]) noexcept : data_(values), size_(N) {}

    constexpr const T *data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }

private:
    const T *data_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {

template <class Handle, void (*Free)(Handle *)>
struct deleter {
    void operator()(Handle *handle) const noexcept { Free(handle); }
};

/// A handle that frees itself.
template <class Handle, void (*Free)(Handle *)>
class owner {
public:
    /// For calls of the C API.
    Handle *get() const noexcept { return handle_.get(); }
    explicit operator bool() const noexcept { return static_cast<bool>(handle_); }
    Handle *release() noexcept { return handle_.release(); }

protected:
    explicit owner(Handle *handle) noexcept : handle_(handle) {}

private:
    std::unique_ptr<Handle, deleter<Handle, Free>> handle_;
};

/// Asks for the count, then for the values.
template <class T, class Call>
std::vector<T> array(Call call) {
    std::size_t count = 0;
    check(call(nullptr, 0, &count));
    std::vector<T> values(count);
    if (count) check(call(values.data(), count, &count));
    return values;
}

template <class Call>
std::string text(Call call) {
    std::size_t length = 0;
    check(call(nullptr, 0, &length));
    std::string value(length, '\0');
    check(call(&value[0], length, &length));
    value.resize(length - 1);
    return value;
}

template <class Handle, class Call>
Handle *made(Call call) {
    Handle *handle = nullptr;
    check(call(&handle));
    return handle;
}

} // namespace detail

/// What all other objects are made from.
class context : public detail::owner<jostle_context, jostle_context_free> {
public:
    context() : context(jostle_context_options_default()) {}
    explicit context(const jostle_context_options &options)
        : owner(detail::made<jostle_context>([&](jostle_context **out) { return jostle_context_new(&options, out); })) {}
};

/// Asks decisions to end. Copies share one flag.
class cancel : public detail::owner<jostle_cancel, jostle_cancel_free> {
public:
    explicit cancel(const context &from)
        : owner(detail::made<jostle_cancel>([&](jostle_cancel **out) { return jostle_cancel_new(from.get(), out); })) {}
    cancel(const cancel &other)
        : owner(detail::made<jostle_cancel>([&](jostle_cancel **out) { return jostle_cancel_clone(other.get(), out); })) {}
    cancel(cancel &&) noexcept = default;
    cancel &operator=(cancel &&) noexcept = default;
    cancel &operator=(const cancel &other) { return *this = cancel(other); }
    ~cancel() = default;

    /// From any thread, at any time; a real-time thread may. A moved-from object does nothing.
    void trigger() const noexcept { (void)jostle_cancel_trigger(get()); }
    void reset() const noexcept { (void)jostle_cancel_reset(get()); }
    bool triggered() const {
        std::uint32_t value = 0;
        check(jostle_cancel_triggered(get(), &value));
        return value != 0;
    }
};

/// A polygon's definition; its corners are borrowed until the body is added.
inline body_def polygon(view<vec2> corners, pose2 at = {}) noexcept {
    body_def def = jostle_body_def_default();
    def.points = corners.data();
    def.point_count = corners.size();
    def.pose = at;
    return def;
}

inline body_def disc(double radius, pose2 at = {}) noexcept {
    body_def def = jostle_body_def_default();
    def.shape = JOSTLE_SHAPE_DISC;
    def.radius = radius;
    def.pose = at;
    return def;
}

/// A block of the library; the name is borrowed until the body is added.
inline body_def block(const char *name, pose2 at = {}) noexcept {
    body_def def = jostle_body_def_default();
    def.shape = JOSTLE_SHAPE_BLOCK;
    def.block = name;
    def.pose = at;
    return def;
}

class problem;

/// What a robot knows of its table.
class scene : public detail::owner<jostle_scene, jostle_scene_free> {
public:
    explicit scene(const context &from)
        : owner(detail::made<jostle_scene>([&](jostle_scene **out) { return jostle_scene_new(from.get(), out); })) {}
    explicit scene(jostle_scene *own) noexcept : owner(own) {}

    scene clone() const {
        return scene(detail::made<jostle_scene>([&](jostle_scene **out) { return jostle_scene_clone(get(), out); }));
    }
    body add(const body_def &def) {
        body added{};
        check(jostle_scene_add_body(get(), &def, &added));
        return added;
    }
    void remove(body which) { check(jostle_scene_remove_body(get(), which)); }
    body find(const std::string &name) const {
        body found{};
        check(jostle_scene_find_body(get(), name.c_str(), &found));
        return found;
    }
    std::size_t size() const {
        std::size_t count = 0;
        check(jostle_scene_body_count(get(), &count));
        return count;
    }
    std::string name(body which) const {
        return detail::text([&](char *to, std::size_t room, std::size_t *length) {
            return jostle_scene_body_name(get(), which, to, room, length);
        });
    }
    /// What was made of a body's shape.
    jostle_body_info info(body which) const {
        jostle_body_info made{};
        check(jostle_scene_body_info(get(), which, &made));
        return made;
    }
    pose2 pose(body which) const {
        pose2 at{};
        check(jostle_scene_get_pose(get(), which, &at));
        return at;
    }
    void set_pose(body which, const pose2 &at) { check(jostle_scene_set_pose(get(), which, &at)); }
    bool present(body which) const {
        std::uint32_t there = 0;
        check(jostle_scene_get_present(get(), which, &there));
        return there != 0;
    }
    void set_present(body which, bool there) { check(jostle_scene_set_present(get(), which, there ? 1 : 0)); }
    /// All of an observation or, if it throws, none of it.
    void update(view<body_pose> observed) { check(jostle_scene_update(get(), observed.data(), observed.size())); }
    std::vector<body_pose> poses() const {
        return detail::array<body_pose>([&](body_pose *to, std::size_t room, std::size_t *count) {
            return jostle_scene_poses(get(), to, room, count);
        });
    }
    /// Where a body is wanted, for planners of rearrangements.
    void set_goal(body which, const jostle::goal &wanted) { check(jostle_scene_set_goal(get(), which, &wanted)); }
    /// With the default tolerances.
    void set_goal(body which, const pose2 &at) {
        jostle::goal wanted = jostle_goal_default();
        wanted.pose = at;
        set_goal(which, wanted);
    }
    void clear_goal(body which) { check(jostle_scene_set_goal(get(), which, nullptr)); }
    /// Throws where the body has none.
    jostle::goal get_goal(body which) const {
        jostle::goal wanted = jostle_goal_default();
        check(jostle_scene_get_goal(get(), which, &wanted));
        return wanted;
    }
    void validate() const { check(jostle_scene_check(get())); }
    std::uint64_t hash() const {
        std::uint64_t value = 0;
        check(jostle_scene_hash(get(), &value));
        return value;
    }
    void set_gripper(const jostle_gripper &gripper) { check(jostle_scene_set_gripper(get(), &gripper)); }
    void set_gripper(const char *name) {
        jostle_gripper gripper = jostle_gripper_default();
        check(jostle_gripper_by_name(name, &gripper));
        set_gripper(gripper);
    }
    jostle_gripper gripper() const {
        jostle_gripper value = jostle_gripper_default();
        check(jostle_scene_get_gripper(get(), &value));
        return value;
    }
    void set_workspace(const jostle_workspace &workspace) { check(jostle_scene_set_workspace(get(), &workspace)); }
    jostle_workspace workspace() const {
        jostle_workspace value = jostle_workspace_default();
        check(jostle_scene_get_workspace(get(), &value));
        return value;
    }
    void set_friction(double ground, double tip) { check(jostle_scene_set_friction(get(), ground, tip)); }
    void set_overlap_tolerance(double metres) { check(jostle_scene_set_overlap_tolerance(get(), metres)); }
    /// Nothing if the body cannot be grasped where all bodies are now.
    std::optional<jostle_grasp> best_grasp(body which) const {
        jostle_grasp best{};
        std::uint32_t found = 0;
        check(jostle_scene_best_grasp(get(), which, &best, &found));
        if (found) return best;
        return std::nullopt;
    }
    /// At most so many of a body's grasps, best first, no two alike.
    std::vector<grasp_report> best_grasps(body which, std::size_t most) const {
        return detail::array<grasp_report>([&](grasp_report *to, std::size_t room, std::size_t *count) {
            return jostle_scene_best_grasps(get(), which, most, to, room, count);
        });
    }
    /// All that is known of a grasp: of `given` position, angle and opening are read.
    grasp_report examine(body which, const grasp &given) const {
        grasp_report found{};
        check(jostle_scene_examine_grasp(get(), which, &given, &found));
        return found;
    }
    /// Why a grasp is not allowed and what to change, or what leaves it the least room: a sentence.
    std::string explain(body which, const grasp &given) const {
        return detail::text([&](char *to, std::size_t room, std::size_t *length) {
            return jostle_scene_explain_grasp(get(), which, &given, to, room, length);
        });
    }
    /// A square image about a body's centre.
    image_frame frame_around(body which, double heading, double pixel, std::size_t side) const {
        image_frame frame{};
        check(jostle_scene_frame_around(get(), which, heading, pixel, side, &frame));
        return frame;
    }
    /// Images without gaps between the rows.
    std::vector<std::uint8_t> label_image(const image_frame &frame) const {
        std::vector<std::uint8_t> pixels(frame.rows * frame.cols);
        check(jostle_scene_label_image(get(), &frame, pixels.data(), frame.cols));
        return pixels;
    }
    std::vector<float> height_image(const image_frame &frame) const {
        std::vector<float> pixels(frame.rows * frame.cols);
        check(jostle_scene_height_image(get(), &frame, pixels.data(), frame.cols * sizeof(float)));
        return pixels;
    }
    std::vector<std::uint8_t> mask_image(body which, const image_frame &frame) const {
        std::vector<std::uint8_t> pixels(frame.rows * frame.cols);
        check(jostle_scene_mask_image(get(), which, &frame, pixels.data(), frame.cols));
        return pixels;
    }
    /// Adds the bodies that an image shows.
    std::vector<seen_body> add_image(const jostle_camera_image &image,
                                     const jostle_image_options &options = jostle_image_options_default()) {
        std::vector<seen_body> seen(255);
        std::size_t count = 0;
        check(jostle_scene_add_image(get(), &image, &options, seen.data(), seen.size(), &count));
        seen.resize(count);
        return seen;
    }
    /// Finds the scene's bodies in an image; for update().
    std::vector<seen_body> match_image(const jostle_camera_image &image,
                                       const jostle_image_options &options = jostle_image_options_default()) const {
        std::vector<seen_body> seen(size());
        std::size_t count = 0;
        check(jostle_scene_match_image(get(), &image, &options, seen.data(), seen.size(), &count));
        seen.resize(count);
        return seen;
    }
    void write(body target, const std::string &path) const { check(jostle_scene_write(get(), target, path.c_str())); }

    static problem read(const context &from, const std::string &path);
    static problem generate(const context &from, std::uint64_t seed, std::uint64_t index, std::size_t bodies);
};

/// A scene and the body to retrieve.
class problem {
public:
    scene world;
    body target;
};

inline problem scene::read(const context &from, const std::string &path) {
    jostle_scene *made = nullptr;
    body target{};
    check(jostle_scene_read(from.get(), path.c_str(), &made, &target));
    return problem{scene(made), target};
}

inline problem scene::generate(const context &from, std::uint64_t seed, std::uint64_t index, std::size_t bodies) {
    jostle_scene *made = nullptr;
    body target{};
    check(jostle_scene_generate(from.get(), seed, index, bodies, &made, &target));
    return problem{scene(made), target};
}

/// What a considered first action came to: chance of success and mean number of actions in perturbed worlds (0 where it
/// was not weighed in such), and where the bodies are expected after it.
struct explanation {
    double success_chance;
    double expected_actions;
    std::vector<body_pose> predicted;
};

/// The answer of a planner.
class plan : public detail::owner<jostle_plan, jostle_plan_free> {
public:
    explicit plan(jostle_plan *own) noexcept : owner(own) {}

    jostle_outcome outcome() const {
        jostle_outcome value = 0;
        check(jostle_plan_outcome(get(), &value));
        return value;
    }
    const char *outcome_name() const { return jostle_outcome_name(outcome()); }
    /// Why the plan is not solved, a sentence each.
    std::vector<std::string> reasons() const {
        std::size_t count = 0;
        check(jostle_plan_reason_count(get(), &count));
        std::vector<std::string> texts(count);
        for (std::size_t i = 0; i < count; i++)
            texts[i] = detail::text([&](char *to, std::size_t room, std::size_t *length) {
                return jostle_plan_reason(get(), i, to, room, length);
            });
        return texts;
    }
    std::size_t size() const {
        std::size_t count = 0;
        check(jostle_plan_action_count(get(), &count));
        return count;
    }
    bool empty() const { return size() == 0; }
    action at(std::size_t index) const {
        action value{};
        check(jostle_plan_action(get(), index, &value));
        return value;
    }
    double value(std::size_t index) const {
        double number = 0;
        check(jostle_plan_value(get(), index, &number));
        return number;
    }
    std::vector<action> actions() const {
        return detail::array<action>([&](action *to, std::size_t room, std::size_t *count) {
            return jostle_plan_actions(get(), to, room, count);
        });
    }
    /// The poses of a move of a rearrangement: pick and place, or the waypoints of a drag.
    std::vector<pose2> waypoints(std::size_t index) const {
        return detail::array<pose2>([&](pose2 *to, std::size_t room, std::size_t *count) {
            return jostle_plan_waypoints(get(), index, to, room, count);
        });
    }
    /// Robot time of a rearrangement, seconds.
    double robot_seconds() const {
        double seconds = 0;
        check(jostle_plan_cost(get(), nullptr, &seconds));
        return seconds;
    }
    /// Where the planner expects all bodies after action `index`.
    std::vector<body_pose> predicted(std::size_t index) const {
        return detail::array<body_pose>([&](body_pose *to, std::size_t room, std::size_t *count) {
            return jostle_plan_predicted(get(), index, to, room, count);
        });
    }
    std::vector<ranked_action> considered() const {
        return detail::array<ranked_action>([&](ranked_action *to, std::size_t room, std::size_t *count) {
            return jostle_plan_considered(get(), to, room, count);
        });
    }
    /// What the considered action `index` came to; see jostle_plan_explain().
    explanation explain(std::size_t index) const {
        explanation found{};
        found.predicted = detail::array<body_pose>([&](body_pose *to, std::size_t room, std::size_t *count) {
            return jostle_plan_explain(get(), index, &found.success_chance, &found.expected_actions, to, room, count);
        });
        return found;
    }
    jostle::statistics statistics() const {
        jostle::statistics value = jostle_plan_statistics_default();
        check(jostle_plan_get_statistics(get(), &value));
        return value;
    }
    std::uint64_t hash() const {
        std::uint64_t value = 0;
        check(jostle_plan_hash(get(), &value));
        return value;
    }
    std::string json() const {
        return detail::text([&](char *to, std::size_t room, std::size_t *length) {
            return jostle_plan_json(get(), to, room, length);
        });
    }
};

/// A decision that runs in the background.
class job : public detail::owner<jostle_job, jostle_job_free> {
public:
    explicit job(jostle_job *own) noexcept : owner(own) {}

    bool done() const {
        jostle_job_state state = 0;
        check(jostle_job_poll(get(), &state, nullptr));
        return state == JOSTLE_JOB_DONE;
    }
    jostle::progress progress() const {
        jostle::progress now = jostle_progress_default();
        check(jostle_job_poll(get(), nullptr, &now));
        return now;
    }
    /// Whether the job ended within the time.
    bool wait(double seconds = std::numeric_limits<double>::infinity()) const {
        jostle_job_state state = 0;
        check(jostle_job_wait(get(), seconds, &state));
        return state == JOSTLE_JOB_DONE;
    }
    void cancel() const noexcept { (void)jostle_job_cancel(get()); }
    /// Throws what failed in the job.
    plan take() {
        return plan(detail::made<jostle_plan>([&](jostle_plan **out) { return jostle_job_take_plan(get(), out); }));
    }
};

/// A network: a built-in one by its name, or an ONNX file.
class model : public detail::owner<jostle_model, jostle_model_free> {
public:
    model(const context &from, const std::string &name, const char *kind = nullptr)
        : model(from, name, kind, jostle_model_options_default()) {}
    model(const context &from, const std::string &name, const char *kind, const jostle_model_options &options)
        : owner(detail::made<jostle_model>([&](jostle_model **out) {
              return jostle_model_load(from.get(), name.c_str(), kind, &options, out);
          })) {}

    /// What is known of it, as JSON.
    std::string info() const {
        return detail::text([&](char *to, std::size_t room, std::size_t *length) {
            return jostle_model_info(get(), to, room, length);
        });
    }
};

/// What runs the networks of this process, as JSON.
inline std::string runtime_info() {
    return detail::text(
        [](char *to, std::size_t room, std::size_t *length) { return jostle_runtime_info(to, room, length); });
}

/// Decides what a robot does next.
class planner : public detail::owner<jostle_planner, jostle_planner_free> {
public:
    planner(const context &from, const jostle_planner_options &options)
        : owner(detail::made<jostle_planner>(
              [&](jostle_planner **out) { return jostle_planner_new(from.get(), &options, out); })) {}

    plan solve(const scene &world, body target) { return solve(world, target, jostle_solve_options_default()); }
    plan solve(const scene &world, body target, const cancel &stop) {
        jostle_solve_options options = jostle_solve_options_default();
        options.cancel = stop.get();
        return solve(world, target, options);
    }
    plan solve(const scene &world, body target, const jostle_solve_options &options) {
        return plan(detail::made<jostle_plan>(
            [&](jostle_plan **out) { return jostle_planner_solve(get(), world.get(), target, &options, out); }));
    }
    /// As solve; `listener(const progress &)` returns whether to go on. What it throws cancels the decision and is
    /// thrown again from here.
    template <class Listener>
    plan solve_with(const scene &world, body target, Listener &&listener, double seconds = 0.1) {
        struct caller {
            Listener &listener;
#if JOSTLE_HAS_EXCEPTIONS
            std::exception_ptr thrown;
#endif
            static std::int32_t call(const jostle_progress *now, void *user) {
                caller &self = *static_cast<caller *>(user);
#if JOSTLE_HAS_EXCEPTIONS
                try {
                    return self.listener(*now) ? 0 : 1;
                } catch (...) {
                    self.thrown = std::current_exception();
                    return 1;
                }
#else
                return self.listener(*now) ? 0 : 1;
#endif
            }
        };
#if JOSTLE_HAS_EXCEPTIONS
        caller me{listener, nullptr};
#else
        caller me{listener};
#endif
        jostle_solve_options options = jostle_solve_options_default();
        options.progress = &caller::call;
        options.user = &me;
        options.progress_seconds = seconds;
        plan made = solve(world, target, options);
#if JOSTLE_HAS_EXCEPTIONS
        if (me.thrown) std::rethrow_exception(me.thrown);
#endif
        return made;
    }
    plan step(const scene &world, body target, std::uint64_t iterations) {
        return plan(detail::made<jostle_plan>([&](jostle_plan **out) {
            return jostle_planner_step(get(), world.get(), target, iterations, nullptr, out);
        }));
    }
    job start(const scene &world, body target) { return start(world, target, jostle_solve_options_default()); }
    job start(const scene &world, body target, const jostle_solve_options &options) {
        return job(detail::made<jostle_job>(
            [&](jostle_job **out) { return jostle_planner_job_start(get(), world.get(), target, &options, out); }));
    }
    /// Whether a part of the search tree was kept.
    bool advance(const action &executed) {
        std::uint32_t kept = 0;
        check(jostle_planner_advance(get(), &executed, &kept));
        return kept != 0;
    }
    /// The first action of the last plan was tried and failed.
    void failed(const action &tried) { check(jostle_planner_failed(get(), &tried)); }
    void reset() { check(jostle_planner_reset(get())); }
    std::uint64_t memory() {
        std::uint64_t bytes = 0;
        check(jostle_planner_memory(get(), &bytes));
        return bytes;
    }
    jostle::progress progress() const {
        jostle::progress now = jostle_progress_default();
        check(jostle_planner_progress(get(), &now));
        return now;
    }
};

/// A world to try plans in.
class simulator : public detail::owner<jostle_simulator, jostle_simulator_free> {
public:
    simulator(const context &from, const scene &world, body target)
        : simulator(from, world, target, jostle_simulator_options_default()) {}
    simulator(const context &from, const scene &world, body target, const jostle_simulator_options &options)
        : owner(detail::made<jostle_simulator>([&](jostle_simulator **out) {
              return jostle_simulator_new(from.get(), world.get(), target, &options, out);
          })) {}

    jostle_effect execute(const action &what) {
        jostle_effect effect = 0;
        check(jostle_simulator_execute(get(), &what, &effect));
        return effect;
    }
    /// JOSTLE_EFFECT_INTERRUPTED where a limit or a cancel came first: nothing changed then.
    jostle_effect execute(const action &what, const jostle_execute_options &options) {
        jostle_effect effect = 0;
        check(jostle_simulator_execute_within(get(), &what, &options, &effect));
        return effect;
    }
    /// What a camera reports now.
    std::vector<body_pose> observe() {
        return detail::array<body_pose>([&](body_pose *to, std::size_t room, std::size_t *count) {
            return jostle_simulator_observe(get(), to, room, count);
        });
    }
    /// Where all bodies really are.
    std::vector<body_pose> poses() {
        return detail::array<body_pose>([&](body_pose *to, std::size_t room, std::size_t *count) {
            return jostle_simulator_poses(get(), to, room, count);
        });
    }
    bool target_left() {
        std::uint32_t left = 0;
        check(jostle_simulator_target_left(get(), &left));
        return left != 0;
    }
};

} // namespace jostle

#endif /* JOSTLE_JOSTLE_HPP */
