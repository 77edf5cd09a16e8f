/*
 * Plan with one engine, check the plan with another: how far can the quick model be trusted here?
 *
 * The plan is made with the engine of the program's first argument ("rapier" without one) and executed whole,
 * without looking in between, in each of the others. An engine that the library was built without says how to get it.
 *
 *   cc -std=c11 -Iinclude examples_c/crosscheck.c -Ltarget/release -ljostle -lm
 */
#include <jostle/jostle.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TRY(call)                                                                                                      \
    do {                                                                                                               \
        if ((call) != JOSTLE_OK) {                                                                                     \
            fprintf(stderr, "%s\n  %s\n", #call, jostle_last_error());                                                 \
            goto done;                                                                                                 \
        }                                                                                                              \
    } while (0)

#define BODIES 5

/* The cube in the middle is shut in by four blocks. Metres and radians. */
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

/* Executes every action of the plan in a world of `engine`. Returns -1 on errors, 1 if the target was grasped. */
static int execute(const jostle_context *context, const jostle_scene *scene, jostle_body target,
                   const jostle_plan *plan, const char *engine)
{
    jostle_simulator *world = NULL;
    jostle_simulator_options options = jostle_simulator_options_default();
    jostle_effect effect = 0;
    size_t count;
    double worst = 0.0;
    int result = -1;

    options.engine = engine; /* with the preset that suits judging */
    jostle_status status = jostle_simulator_new(context, scene, target, &options, &world);
    if (status == JOSTLE_ERROR_UNSUPPORTED) {
        printf("%-8s not in this build\n# %s\n", engine, jostle_last_error());
        return 0;
    }
    TRY(status);
    TRY(jostle_plan_action_count(plan, &count));
    for (size_t i = 0; i < count; i++) {
        jostle_action action;
        jostle_body_pose predicted[BODIES], really[BODIES];
        size_t bodies;
        TRY(jostle_plan_action(plan, i, &action));
        TRY(jostle_simulator_execute(world, &action, &effect));
        TRY(jostle_plan_predicted(plan, i, predicted, BODIES, &bodies));
        TRY(jostle_simulator_poses(world, really, BODIES, &bodies));
        for (size_t k = 0; k < bodies; k++) {
            double apart = hypot(predicted[k].pose.p.x - really[k].pose.p.x, predicted[k].pose.p.y - really[k].pose.p.y);
            worst = apart > worst ? apart : worst;
        }
    }
    result = effect == JOSTLE_EFFECT_GRASPED;
    printf("%-8s %s; the farthest body is within %.0f mm of where it was predicted\n", engine,
           result ? "target grasped" : "target not grasped", ceil(worst * 1e3));
done:
    jostle_simulator_free(world);
    return result;
}

int main(int argc, char **argv)
{
    static const char *const engines[] = {"rapier", "planar", "prism", "bullet"};
    const char *model = argc > 1 ? argv[1] : "rapier";
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_plan *plan = NULL;
    jostle_body target = {0};
    size_t count;
    int failed = 1, grasped = 0;

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
    options.engine = model;
    options.seed = 1;
    options.max_iterations = 300;
    TRY(jostle_planner_new(context, &options, &planner));
    TRY(jostle_planner_solve(planner, scene, target, NULL, &plan));
    TRY(jostle_plan_action_count(plan, &count));
    printf("planned with %s: %u actions\n", model, (unsigned)count);

    for (size_t i = 0; i < sizeof engines / sizeof *engines; i++) {
        int result = execute(context, scene, target, plan, engines[i]);
        if (result < 0) goto done;
        grasped += result;
    }
    failed = grasped == 0;
done:
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return failed;
}
