/*
 * Rearrange a table, in closed loop: plan, execute the first move, observe, plan again.
 *
 * Two cubes change places, which needs a third place for a while, and a tray that is too large for the gripper is
 * dragged along the table between them. The robot here does exactly what it is told; on a real one, replace the call
 * that sets the pose by your drivers.
 *
 *   cc -std=c11 -Iinclude examples_c/rearrange.c -Ltarget/release -ljostle -lm
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

#define BODIES 3
#define MOST_MOVES 12
#define MOST_WAYPOINTS 64

static const jostle_vec2 cube[4] = {{-.0225, -.0225}, {.0225, -.0225}, {.0225, .0225}, {-.0225, .0225}};
static const jostle_vec2 tray[4] = {{-.08, -.05}, {.08, -.05}, {.08, .05}, {-.08, .05}};

/* Metres and radians. */
static const struct {
    const char *name;
    const jostle_vec2 *corners;
    uint32_t pickable, symmetry;
    jostle_pose2 start, goal;
} table[BODIES] = {
    {"red", cube, 1, 4, {{0.20, 0.20}, 0.0}, {{0.32, 0.20}, 0.0}},
    {"blue", cube, 1, 4, {{0.32, 0.20}, 0.0}, {{0.20, 0.20}, 0.0}},
    {"tray", tray, 0, 2, {{0.25, 0.40}, 0.0}, {{0.60, 0.15}, 1.5}},
};

int main(void)
{
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_plan *plan = NULL;
    jostle_body bodies[BODIES], nobody = {0};
    int arranged = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));

    TRY(jostle_scene_new(context, &scene));
    jostle_workspace workspace = jostle_workspace_default();
    workspace.min.x = 0.0, workspace.min.y = 0.0;
    workspace.max.x = 0.78, workspace.max.y = 0.52;
    workspace.leave_rule = JOSTLE_LEAVE_FOOTPRINT;
    TRY(jostle_scene_set_workspace(scene, &workspace));
    for (int i = 0; i < BODIES; i++) {
        jostle_body_def def = jostle_body_def_default();
        def.points = table[i].corners;
        def.point_count = 4;
        def.name = table[i].name;
        def.pickable = table[i].pickable;
        def.pose = table[i].start;
        TRY(jostle_scene_add_body(scene, &def, &bodies[i]));
        jostle_goal goal = jostle_goal_default();
        goal.pose = table[i].goal;
        goal.symmetry = table[i].symmetry;
        TRY(jostle_scene_set_goal(scene, bodies[i], &goal));
    }

    jostle_planner_options options = jostle_planner_options_default();
    options.planner = "untangle";
    options.seed = 1;
    options.max_iterations = 200; /* a limit of iterations: the same plans on every run */
    TRY(jostle_planner_new(context, &options, &planner));

    for (int i = 1; i <= MOST_MOVES && !arranged; i++) {
        jostle_outcome outcome;
        jostle_action move;
        jostle_pose2 way[MOST_WAYPOINTS];
        char name[16];
        size_t count, waypoints;
        uint32_t kept;

        /* A rearrangement has goals in place of a target. */
        TRY(jostle_planner_solve(planner, scene, nobody, NULL, &plan));
        TRY(jostle_plan_outcome(plan, &outcome));
        TRY(jostle_plan_action_count(plan, &count));
        if (count == 0) {
            arranged = outcome == JOSTLE_OUTCOME_SOLVED; /* nothing is left to do */
            break;
        }
        TRY(jostle_plan_action(plan, 0, &move));
        TRY(jostle_plan_waypoints(plan, 0, way, MOST_WAYPOINTS, &waypoints));
        TRY(jostle_scene_body_name(scene, move.body, name, sizeof name, &count));
        printf("%2d  %s  %s to (%.3f, %.3f)\n", i, move.kind == JOSTLE_ACTION_DRAG ? "drag" : "pick", name,
               way[waypoints - 1].p.x, way[waypoints - 1].p.y);

        TRY(jostle_scene_set_pose(scene, move.body, &way[waypoints - 1]));
        TRY(jostle_planner_advance(planner, &move, &kept)); /* the rest of the plan is where the next one begins */
        jostle_plan_free(plan);
        plan = NULL;
    }
    puts(arranged ? "arranged" : "not arranged");

done: /* in any order; null is fine */
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return arranged ? 0 : 1;
}
