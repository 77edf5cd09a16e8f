/*
 * Clear a table, in closed loop: observe, plan, execute the first action, until nothing is left. A body that can be
 * grasped is taken; where none can, a push makes room.
 *
 * The robot here is the library's simulator; on a real one, replace execute() and observe() by your drivers. A scene
 * file with a table to clear ("clear": true) may be given instead of the one below.
 *
 *   cc -std=c11 -Iinclude examples_c/clear_table.c -Ltarget/release -ljostle -lm
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

#define BODIES 9
#define MOST_BODIES 64
#define NOISE_M 0.001
#define NOISE_RAD 0.0175

int main(int argc, char **argv)
{
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_simulator *robot = NULL;
    jostle_plan *plan = NULL;
    jostle_body everything = {0}; /* no target: all of them */
    jostle_body_pose seen[MOST_BODIES];
    size_t bodies, actions = 0, taken = 0, failed = 0;
    int cleared = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));

    if (argc > 1) {
        jostle_body target;
        TRY(jostle_scene_read(context, argv[1], &scene, &target));
    } else { /* three by three cubes, 1 mm apart: no finger fits in anywhere but at the corners */
        TRY(jostle_scene_new(context, &scene));
        for (int i = 0; i < BODIES; i++) {
            jostle_body_def def = jostle_body_def_default();
            jostle_body body;
            def.shape = JOSTLE_SHAPE_BLOCK;
            def.block = "cube";
            def.pose.p.x = 0.5 + 0.046 * (i % 3 - 1);
            def.pose.p.y = 0.046 * (i / 3 - 1);
            TRY(jostle_scene_add_body(scene, &def, &body));
        }
    }

    jostle_planner_options options = jostle_planner_options_default();
    options.planner = "greedy";
    options.seed = 1;
    TRY(jostle_planner_new(context, &options, &planner));
    jostle_simulator_options world = jostle_simulator_options_default();
    world.seed = 1;
    world.friction_spread = 0.2;
    world.position_noise = NOISE_M;
    world.angle_noise = NOISE_RAD;
    TRY(jostle_simulator_new(context, scene, everything, &world, &robot));
    TRY(jostle_simulator_observe(robot, seen, MOST_BODIES, &bodies));

    while (actions < 3 * bodies) { /* the cap of the published evaluation */
        jostle_outcome outcome;
        jostle_action action;
        jostle_effect effect;
        size_t count;
        uint32_t left;

        TRY(jostle_simulator_observe(robot, seen, MOST_BODIES, &bodies));
        TRY(jostle_scene_update(scene, seen, bodies));
        TRY(jostle_planner_solve(planner, scene, everything, NULL, &plan));
        TRY(jostle_plan_outcome(plan, &outcome));
        TRY(jostle_plan_action_count(plan, &count));
        if (count == 0) {
            cleared = outcome == JOSTLE_OUTCOME_SOLVED; /* nothing is left to be taken */
            break;
        }
        TRY(jostle_plan_action(plan, 0, &action)); /* only the first: the world will differ a little */
        TRY(jostle_simulator_execute(robot, &action, &effect));
        actions++;
        if (action.kind == JOSTLE_ACTION_PUSH) {
            printf("%2u  push  (%.3f, %+.3f) to (%.3f, %+.3f)  %s\n", (unsigned)actions, action.push.start.x,
                   action.push.start.y, action.push.end.x, action.push.end.y, jostle_effect_name(effect));
        } else {
            char name[32];
            TRY(jostle_scene_body_name(scene, action.body, name, sizeof name, &count));
            printf("%2u  grasp %s at (%.3f, %+.3f)  %s\n", (unsigned)actions, name, action.grasp.position.x,
                   action.grasp.position.y, jostle_effect_name(effect));
        }
        if (effect == JOSTLE_EFFECT_PUSHED || effect == JOSTLE_EFFECT_TOPPLED || effect == JOSTLE_EFFECT_GRASPED) {
            taken += effect == JOSTLE_EFFECT_GRASPED;
            TRY(jostle_planner_advance(planner, &action, NULL));
        } else {
            failed++;
            TRY(jostle_planner_failed(planner, &action)); /* do not offer it again */
        }
        TRY(jostle_simulator_target_left(robot, &left)); /* without a target: any body */
        if (left) {
            puts("a body fell off the table");
            break;
        }
        jostle_plan_free(plan);
        plan = NULL;
    }
    printf("%s: %u bodies by %u actions, %u of which failed\n", cleared ? "cleared" : "not cleared", (unsigned)taken,
           (unsigned)actions, (unsigned)failed);

done: /* in any order; null is fine */
    jostle_plan_free(plan);
    jostle_simulator_free(robot);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return cleared ? 0 : 1;
}
