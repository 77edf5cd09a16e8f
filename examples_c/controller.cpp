// A robot controller in C++17: a state machine that is called at a fixed rate and never waits for the planner.
//
//   c++ -std=c++17 -Iinclude examples_c/controller.cpp -Ltarget/release -ljostle -lm
#include <jostle/jostle.hpp>

#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

namespace {

/// What the controller needs of a robot.
class robot {
public:
    virtual ~robot() = default;
    virtual std::vector<jostle::body_pose> observe() = 0;
    /// Whether the target is in the gripper afterwards.
    virtual bool execute(const jostle::action &action) = 0;
};

class simulated_robot final : public robot {
public:
    simulated_robot(const jostle::context &context, const jostle::problem &problem, const jostle_simulator_options &options)
        : world_(context, problem.world, problem.target, options) {}

    std::vector<jostle::body_pose> observe() override { return world_.observe(); }
    bool execute(const jostle::action &action) override { return world_.execute(action) == JOSTLE_EFFECT_GRASPED; }

private:
    jostle::simulator world_;
};

class controller {
public:
    enum class state { observing, planning, executing, done, failed };

    controller(const jostle::context &context, jostle::problem problem, robot &robot, int most_actions)
        : problem_(std::move(problem)), planner_(context, planner_options()), stop_(context), robot_(robot),
          left_(most_actions) {}

    /// One cycle; returns at once but for the robot's own moves.
    state tick() {
        switch (state_) {
        case state::observing:
            problem_.world.update(robot_.observe());
            start();
            state_ = state::planning;
            break;
        case state::planning:
            if (job_->done()) state_ = decide();
            break;
        case state::executing:
            state_ = move();
            break;
        case state::done:
        case state::failed:
            break;
        }
        return state_;
    }

    /// From any thread: the decision in progress ends without an action.
    void emergency_stop() const noexcept { stop_.trigger(); }

private:
    static jostle_planner_options planner_options() {
        jostle_planner_options options = jostle_planner_options_default();
        options.seed = 1;
        options.max_iterations = 300;
        return options;
    }

    void start() {
        jostle_solve_options options = jostle_solve_options_default();
        options.cancel = stop_.get();
        job_ = std::make_unique<jostle::job>(planner_.start(problem_.world, problem_.target, options));
    }

    state decide() {
        const jostle::plan plan = job_->take();
        job_.reset();
        if (plan.outcome() == JOSTLE_OUTCOME_CANCELLED || plan.empty() || left_-- == 0) {
            std::printf("stopped: %s\n", plan.outcome_name());
            return state::failed;
        }
        next_ = plan.at(0);
        return state::executing;
    }

    state move() {
        const bool held = robot_.execute(next_);
        if (next_.kind == JOSTLE_ACTION_PUSH) {
            std::printf("push to (%.3f, %+.3f)\n", next_.push.end.x, next_.push.end.y);
        } else {
            std::printf("grasp of %s: %s\n", problem_.world.name(next_.body).c_str(), held ? "held" : "missed");
        }
        if (held || next_.kind == JOSTLE_ACTION_PUSH) {
            planner_.advance(next_);
        } else {
            planner_.failed(next_);
        }
        return held ? state::done : state::observing;
    }

    jostle::problem problem_;
    jostle::planner planner_;
    jostle::cancel stop_;
    robot &robot_;
    int left_;
    std::unique_ptr<jostle::job> job_;
    jostle::action next_{};
    state state_ = state::observing;
};

} // namespace

int main() {
    try {
        jostle::check_abi();
        std::printf("%s\n", jostle_build_info());
        const jostle::context context;
        jostle::problem problem = jostle::scene::generate(context, 3, 0, 6);

        // The world is not the planner's model: other friction, noisy eyes.
        jostle_simulator_options world = jostle_simulator_options_default();
        world.seed = 5;
        world.friction_spread = 0.2;
        world.position_noise = 0.0005;
        world.angle_noise = 0.005;
        simulated_robot robot(context, problem, world);
        controller control(context, std::move(problem), robot, 15);

        for (;;) {
            const controller::state state = control.tick();
            if (state == controller::state::done) {
                std::puts("done");
                return 0;
            }
            if (state == controller::state::failed) return 1;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    } catch (const jostle::error &error) {
        std::fprintf(stderr, "%s: %s\n", jostle_status_name(error.status()), error.what());
        return 2;
    }
}
