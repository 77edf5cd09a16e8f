// jostle.hpp: owners move and free themselves, failures throw, containers come out.
#include <jostle/jostle.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <type_traits>

static int failures = 0;
#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            std::printf("%d: %s\n", __LINE__, #condition);                                                             \
            ++failures;                                                                                                \
        }                                                                                                              \
    } while (0)

static_assert(!std::is_copy_constructible_v<jostle::scene> && std::is_nothrow_move_constructible_v<jostle::scene>);
static_assert(std::is_copy_constructible_v<jostle::cancel>);
static_assert(sizeof(jostle::plan) == sizeof(void *));

static void all() {
    using namespace jostle;
    const context from;
    const vec2 corners[] = {{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}};
    scene world(from);
    body_def def = polygon(corners, {{0.5, 0}, 0});
    def.name = "target";
    const body target = world.add(def);
    const body other = world.add(disc(0.02, {{0.56, 0}, 0}));
    const body third = world.add(block("cube", {{0.4, 0.1}, 0.5}));
    CHECK(world.size() == 3 && world.find("target") == target && world.name(other) == "body 1");
    CHECK(target != other && world.pose(third).theta == 0.5);

    try {
        def.mass = -1;
        def.name = nullptr;
        (void)world.add(def);
        CHECK(false);
    } catch (const error &e) {
        CHECK(e.status() == JOSTLE_ERROR_ARGUMENT && std::strstr(e.what(), "def.mass: is -1"));
    }
    CHECK(world.size() == 3);

    scene copy = world.clone();
    CHECK(copy.hash() == world.hash());
    std::vector<body_pose> seen = world.poses();
    seen[1].pose.p.x = 0.57;
    copy.update(seen);
    CHECK(copy.hash() != world.hash() && copy.pose(other).p.x == 0.57);
    copy.set_present(third, false);
    CHECK(!copy.present(third));
    copy.remove(third);
    CHECK(copy.size() == 2);
    copy.validate();
    copy.set_gripper("dissertation_mask");
    CHECK(copy.gripper().opening == 0.07);
    jostle_workspace workspace = copy.workspace();
    workspace.leave_scope = JOSTLE_SCOPE_TARGET_ONLY;
    copy.set_workspace(workspace);
    copy.set_friction(1, 1);
    copy.set_overlap_tolerance(0.001);
    scene moved = std::move(copy);
    CHECK(!copy && moved);

    const auto grasps = world.best_grasps(third, 4);
    CHECK(grasps.size() > 1 && grasps.size() <= 4 && grasps[0].allowed == 1);
    CHECK(std::memcmp(&grasps[0].grasp.position, &world.best_grasp(third)->position, sizeof(vec2)) == 0);
    const grasp_report second = world.examine(third, grasps[1].grasp);
    CHECK(std::memcmp(&second, &grasps[1], sizeof second) == 0);
    CHECK(world.explain(third, grasps[1].grasp).find("it is allowed") == 0);

    jostle_planner_options options = jostle_planner_options_default();
    options.max_iterations = 4;
    planner decide(from, options);
    plan made = decide.solve(world, target);
    CHECK(made.actions().size() == made.size() && std::strlen(made.outcome_name()) > 3);
    CHECK(made.reasons().empty() == (made.outcome() == JOSTLE_OUTCOME_SOLVED));
    CHECK(made.json().find("\"outcome\"") != std::string::npos && made.json().back() == '}');
    CHECK(made.considered().size() <= 64 && made.statistics().seed == 0);
    if (!made.considered().empty()) {
        const auto why = made.explain(0);
        CHECK(!why.predicted.empty() && why.success_chance >= 0 && why.success_chance <= 1);
    }
    for (std::size_t i = 0; i < made.size(); ++i) CHECK(made.predicted(i).size() == 3);

    // What a camera sees of it makes the same scene again, and finds its bodies.
    const image_frame frame{{{0.5, 0.05}, 0}, 0.002, 180, 200};
    const std::vector<std::uint8_t> labels = world.label_image(frame);
    const std::vector<float> heights = world.height_image(frame);
    CHECK(world.mask_image(target, world.frame_around(target, 0.3, 0.002, 5)) == std::vector<std::uint8_t>(25, 1));
    jostle_camera_image image = jostle_camera_image_default();
    image.rows = frame.rows, image.cols = frame.cols;
    image.labels = labels.data(), image.label_stride = frame.cols;
    image.heights = heights.data(), image.height_stride = frame.cols * sizeof(float);
    check(jostle_image_frame_map(&frame, &image.map));
    scene again(from);
    const std::vector<seen_body> added = again.add_image(image);
    CHECK(added.size() == 3 && again.size() == 3 && again.name(added[2].body) == "label 3");
    again.validate();
    const std::vector<seen_body> matched = world.match_image(image);
    CHECK(matched.size() == 3);
    for (const seen_body &seen : matched) {
        CHECK(seen.seen == JOSTLE_SEEN_BODY && world.find(world.name(seen.body)) == seen.body);
        const vec2 there = world.pose(seen.body).p;
        CHECK(std::fabs(seen.pose.p.x - there.x) < 1e-3 && std::fabs(seen.pose.p.y - there.y) < 1e-3);
    }

    // The same from masks, one for each body.
    std::vector<std::uint8_t> masks;
    for (const body_pose &at : world.poses()) {
        const std::vector<std::uint8_t> mask = world.mask_image(at.body, frame);
        masks.insert(masks.end(), mask.begin(), mask.end());
    }
    image.labels = nullptr;
    image.masks = masks.data(), image.mask_count = 3;
    image.mask_stride = frame.cols, image.mask_plane_stride = frame.rows * frame.cols;
    scene masked(from);
    CHECK(masked.add_image(image).size() == 3 && masked.hash() == again.hash());
    CHECK(world.match_image(image)[1].pose.p.x == matched[1].pose.p.x);

    cancel stop(from);
    const cancel twin = stop;
    twin.trigger();
    CHECK(stop.triggered());
    CHECK(decide.solve(world, target, stop).size() <= 64);
    stop.reset();
    job background = decide.start(world, target);
    CHECK(background.wait() && background.done());
    // The same decision again: what was kept of the tree may make it better, never unlike in kind.
    (void)background.take();
    try {
        (void)background.take();
        CHECK(false);
    } catch (const error &e) {
        CHECK(e.status() == JOSTLE_ERROR_STATE);
    }
    decide.reset();
    (void)decide.memory();
    (void)decide.progress();
    (void)decide.step(world, target, 2);

    // An exception in the listener comes out here, not through the library.
    int calls = 0;
    try {
        jostle_planner_options long_ones = jostle_planner_options_default();
        long_ones.max_iterations = 100000;
        long_ones.execute_score = long_ones.solved_score = 1;
        planner slow(from, long_ones);
        (void)slow.solve_with(world, target, [&](const progress &) -> bool { ++calls; throw 7; }, 0);
        CHECK(calls == 0);
    } catch (int thrown) {
        CHECK(thrown == 7 && calls == 1);
    }

    try {
        (void)model(from, "never.onnx", "gc");
        CHECK(false);
    } catch (const error &e) {
        CHECK(e.status() == JOSTLE_ERROR_NOT_FOUND && std::strstr(e.what(), "never.onnx: there is no such file"));
    }

    simulator robot(from, world, target);
    CHECK(robot.observe().size() == 3 && robot.poses().size() == 3 && !robot.target_left());
    action push{};
    push.kind = JOSTLE_ACTION_PUSH;
    push.push = {{0.62, 0}, {0.58, 0}};
    CHECK(robot.execute(push) == JOSTLE_EFFECT_PUSHED);

    problem random = scene::generate(from, 1, 2, 6);
    CHECK(random.world.size() == 6);
    random.world.write(random.target, "wrapper_scene.json");
    const problem read = scene::read(from, "wrapper_scene.json");
    CHECK(read.world.size() == 6 && read.world.name(read.target) == random.world.name(random.target));
}

int main() {
    jostle::check_abi();
    all();
    CHECK(jostle_handle_count() == 0);
    std::puts(failures ? "wrapper: failed" : "wrapper: as promised");
    return failures ? 1 : 0;
}
