/*
 * Retrieve a block from clutter, in closed loop: observe, plan, execute the first action, observe again.
 *
 * The robot here is the library's simulator; on a real one, replace execute() and observe() by your drivers.
 *
 *   cc -std=c11 -Iinclude examples_c/retrieve.c -Ltarget/release -ljostle -lm
 */
#include <jostle/jostle.h>

#include <stdio.h>

#define TRY(call)                                                                                                      \
    do {                                                                                                               \
        if ((call) != JOSTLE_OK) {                                                                                     \
            fprintf(stderr, "%s\n  %s\n", #call, jostle_last_error());                                                 \
            goto done;                                                                                                 \
        }                                                                                                              \
    } while (0)

#define BODIES 5
#define MOST_ACTIONS 15

/* The block to retrieve stands between four others: no finger fits in. Metres and radians. */
static const struct {
    const char *name, *block;
    jostle_pose2 pose;
} table[BODIES] = {
    {"target", "cube", {{0.500, 0.000}, 0.0}},
    {"left", "cube", {{0.500, 0.047}, 0.0}},
    {"right", "cube", {{0.500, -0.047}, 0.0}},
    {"front", "rect", {{0.454, 0.000}, 0.0}},
    {"back", "half_cube", {{0.535, 0.000}, 0.0}},
};

int main(void)
{
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_simulator *robot = NULL;
    jostle_plan *plan = NULL;
    jostle_body target = {0};
    int retrieved = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));

    TRY(jostle_scene_new(context, &scene));
    for (int i = 0; i < BODIES; i++) {
        jostle_body_def def = jostle_body_def_default();
        jostle_body body;
        def.shape = JOSTLE_SHAPE_BLOCK;
        def.block = table[i].block;
        def.name = table[i].name;
        def.pose = table[i].pose;
        TRY(jostle_scene_add_body(scene, &def, &body));
    }
    TRY(jostle_scene_find_body(scene, "target", &target));

    jostle_planner_options options = jostle_planner_options_default();
    options.seed = 1;
    options.max_iterations = 300; /* a limit of iterations: the same plans on every run */
    TRY(jostle_planner_new(context, &options, &planner));
    TRY(jostle_simulator_new(context, scene, target, NULL, &robot));

    for (int i = 1; i <= MOST_ACTIONS && !retrieved; i++) {
        jostle_outcome outcome;
        jostle_action action;
        jostle_effect effect;
        jostle_body_pose seen[BODIES];
        size_t count;

        TRY(jostle_planner_solve(planner, scene, target, NULL, &plan));
        TRY(jostle_plan_outcome(plan, &outcome));
        TRY(jostle_plan_action_count(plan, &count));
        if (count == 0) {
            printf("%2d  nothing to do: %s\n", i, jostle_outcome_name(outcome));
            break;
        }
        TRY(jostle_plan_action(plan, 0, &action)); /* only the first: the world will differ a little */
        TRY(jostle_simulator_execute(robot, &action, &effect));
        if (action.kind == JOSTLE_ACTION_PUSH) {
            printf("%2d  push  (%.3f, %+.3f) to (%.3f, %+.3f)  %s; plan of %u, %s\n", i, action.push.start.x,
                   action.push.start.y, action.push.end.x, action.push.end.y, jostle_effect_name(effect),
                   (unsigned)count, jostle_outcome_name(outcome));
        } else {
            printf("%2d  grasp (%.3f, %+.3f) at %.0f degrees  %s\n", i, action.grasp.position.x,
                   action.grasp.position.y, action.grasp.angle * 57.29578, jostle_effect_name(effect));
        }
        retrieved = effect == JOSTLE_EFFECT_GRASPED && JOSTLE_BODY_EQ(action.body, target);

        if (effect == JOSTLE_EFFECT_PUSHED || effect == JOSTLE_EFFECT_TOPPLED || retrieved) {
            TRY(jostle_planner_advance(planner, &action, NULL)); /* keep what was found for this case */
        } else {
            TRY(jostle_planner_failed(planner, &action)); /* do not offer it again */
        }
        jostle_plan_free(plan);
        plan = NULL;
        TRY(jostle_simulator_observe(robot, seen, BODIES, &count));
        TRY(jostle_scene_update(scene, seen, count));
    }
    puts(retrieved ? "retrieved" : "not retrieved");

done: /* in any order; null is fine */
    jostle_plan_free(plan);
    jostle_simulator_free(robot);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return retrieved ? 0 : 1;
}
