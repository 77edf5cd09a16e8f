/*
 * Retrieve a block from clutter with a search that a network guides: MORE, with the push prediction network that is part
 * of the library. Before each action the program says why it was chosen: the best first actions that were considered,
 * with what the network expected of them (prior), what the search found (value, visits), and where it expects the target.
 *
 * Networks are run by ONNX Runtime, which is found when it is needed (docs/networks.md says where). Without it the
 * program says what was tried, and ends.
 *
 *   cc -std=c11 -Iinclude examples_c/learned_retrieve.c -Ltarget/release -ljostle -lm
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

#define BODIES 9
#define MOST_ACTIONS 15
#define TOP 3

/* The block to retrieve is the middle one of a pack: no finger fits in, and few pushes free it. Metres and radians. */
static const struct {
    const char *name, *block;
    jostle_pose2 pose;
} table[BODIES] = {
    {"target", "cube", {{0.500, 0.000}, 0.0}},       {"left", "cube", {{0.500, 0.047}, 0.0}},
    {"right", "cube", {{0.500, -0.047}, 0.0}},       {"front", "rect", {{0.454, 0.023}, 0.0}},
    {"back", "rect", {{0.546, -0.023}, 0.0}},        {"left corner", "cube", {{0.546, 0.047}, 0.0}},
    {"right corner", "cube", {{0.454, -0.047}, 0.0}}, {"far left", "rect", {{0.500, 0.093}, 1.570796}},
    {"far right", "rect", {{0.500, -0.093}, 1.570796}},
};

/* The first actions of a plan that were considered, the best first, each with the state expected after it. */
static jostle_status explain(const jostle_plan *plan, jostle_body target, jostle_vec2 now)
{
    jostle_ranked_action ranked[64];
    jostle_body_pose after[BODIES];
    size_t count, bodies;
    jostle_status status = jostle_plan_considered(plan, ranked, sizeof ranked / sizeof *ranked, &count);
    for (size_t i = 0; status == JOSTLE_OK && i < count && i < TOP; i++) {
        const jostle_ranked_action *r = &ranked[i];
        const jostle_push *push = &r->action.push;
        status = jostle_plan_explain(plan, i, NULL, NULL, after, BODIES, &bodies);
        if (status != JOSTLE_OK) {
            break;
        }
        double moved = 0;
        for (size_t k = 0; k < bodies; k++) {
            if (JOSTLE_BODY_EQ(after[k].body, target)) {
                moved = hypot(after[k].pose.p.x - now.x, after[k].pose.p.y - now.y);
            }
        }
        printf("    %u. (%.3f, %+.3f) to (%.3f, %+.3f)  prior %.2f, value %.2f, %u visits, target moves %.0f mm; ",
               (unsigned)i + 1, push->start.x, push->start.y, push->end.x, push->end.y, r->prior, r->value,
               (unsigned)r->visits, moved * 1e3);
        if (r->solution_actions == JOSTLE_NO_SOLUTION) {
            puts("no plan known");
        } else {
            printf("free after %u\n", (unsigned)r->solution_actions);
        }
    }
    return status;
}

/* Prints what follows `"key":` in a JSON text, up to the end of that text. */
static void print_text(const char *json, const char *key)
{
    char quoted[32];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(json, quoted);
    at = at ? strchr(at + strlen(quoted), '"') : NULL;
    printf(" %s %.*s", key, at ? (int)strcspn(at + 1, "\"") : 1, at ? at + 1 : "?");
}

int main(void)
{
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_model *network = NULL;
    jostle_planner *planner = NULL;
    jostle_simulator *robot = NULL;
    jostle_plan *plan = NULL;
    jostle_body target = {0};
    char runtime[1024], info[16384];
    size_t length;
    int retrieved = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));

    jostle_status status = jostle_runtime_info(runtime, sizeof runtime, &length);
    if (status == JOSTLE_ERROR_MODEL_RUNTIME) {
        printf("nothing runs networks here: %s\n", jostle_last_error());
        jostle_context_free(context);
        return 0;
    }
    TRY(status);
    status = jostle_model_load(context, "ppn", "ppn", NULL, &network); /* or the path of a file of your own */
    if (status == JOSTLE_ERROR_NOT_FOUND) {
        printf("this build has no network: %s\n", jostle_last_error());
        jostle_context_free(context);
        return 0;
    }
    TRY(status);
    TRY(jostle_model_info(network, info, sizeof info, &length));
    printf("# runtime:"); /* differs between machines */
    print_text(runtime, "backend");
    print_text(runtime, "version");
    printf("\n# network:");
    print_text(info, "file");
    print_text(info, "kind");
    print_text(info, "sha256");
    putchar('\n');

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
    options.planner = "more";
    options.prior_model = network; /* without it the built-in network would be taken as well */
    options.max_iterations = 20;   /* the published search without the network takes 50 */
    options.seed = 1;
    TRY(jostle_planner_new(context, &options, &planner));
    TRY(jostle_simulator_new(context, scene, target, NULL, &robot));

    jostle_vec2 now = table[0].pose.p;
    for (int i = 1; i <= MOST_ACTIONS && !retrieved; i++) {
        jostle_outcome outcome;
        jostle_action action;
        jostle_effect effect;
        jostle_body_pose seen[BODIES];
        size_t count;
        jostle_plan_statistics took = jostle_plan_statistics_default();

        TRY(jostle_planner_solve(planner, scene, target, NULL, &plan));
        TRY(jostle_plan_outcome(plan, &outcome));
        TRY(jostle_plan_action_count(plan, &count));
        if (count == 0) {
            printf("%2d  nothing to do: %s\n", i, jostle_outcome_name(outcome));
            break;
        }
        TRY(jostle_plan_get_statistics(plan, &took));
        TRY(jostle_plan_action(plan, 0, &action)); /* only the first: the world will differ a little */
        if (action.kind == JOSTLE_ACTION_PUSH) {
            printf("%2d  push  (%.3f, %+.3f) to (%.3f, %+.3f), after %u simulated pushes, because\n", i,
                   action.push.start.x, action.push.start.y, action.push.end.x, action.push.end.y,
                   (unsigned)took.simulations);
            TRY(explain(plan, target, now));
        } else {
            printf("%2d  grasp (%.3f, %+.3f) at %.0f degrees\n", i, action.grasp.position.x, action.grasp.position.y,
                   action.grasp.angle * 57.29578);
        }
        TRY(jostle_simulator_execute(robot, &action, &effect));
        printf("    %s\n", jostle_effect_name(effect));
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
        for (size_t k = 0; k < count; k++) {
            now = JOSTLE_BODY_EQ(seen[k].body, target) ? seen[k].pose.p : now;
        }
    }
    puts(retrieved ? "retrieved" : "not retrieved");

done: /* in any order; null is fine */
    jostle_plan_free(plan);
    jostle_simulator_free(robot);
    jostle_planner_free(planner);
    jostle_model_free(network);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return retrieved ? 0 : 1;
}
