/* Networks through the C API. The arguments are FILE STATUS TEXT, three for each file that has to be refused, then `good`
 * and the files of a `gc` and of a `dipn` network, with which a plan is made. */
#include <jostle/jostle.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%d: %s (last error: %s)\n", __LINE__, #condition, jostle_last_error());                            \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)
#define MUST(call) CHECK((call) == JOSTLE_OK)

static jostle_model *load(jostle_context *context, const char *path, const char *kind)
{
    jostle_model *model = NULL;
    jostle_model_options options = jostle_model_options_default();
    options.gripper = "robotiq_2f85";
    MUST(jostle_model_load(context, path, kind, &options, &model));
    return model;
}

/* What is known of a network, and of what runs it. */
static void look(const jostle_model *model)
{
    char text[8192], small[8];
    size_t length = 0;
    CHECK(jostle_model_info(model, small, sizeof small, &length) == JOSTLE_ERROR_BUFFER && length > sizeof small);
    MUST(jostle_model_info(model, text, sizeof text, &length));
    CHECK(strlen(text) + 1 == length);
    CHECK(strstr(text, "\"kind\":\"gc\"") && strstr(text, "\"backend\":"));
    MUST(jostle_runtime_info(text, sizeof text, &length));
    CHECK(strstr(text, "\"version\":"));
}

/* A plan with a learned engine and a learned scorer; the networks may be freed before the planner. */
static void plan(jostle_context *context, jostle_model *gc, jostle_model *dipn)
{
    const jostle_vec2 square[4] = {{-.0225, -.0225}, {.0225, -.0225}, {.0225, .0225}, {-.0225, .0225}};
    const double places[3][2] = {{0.5, 0}, {0.55, 0}, {0.5, 0.05}};
    jostle_scene *scene;
    jostle_planner *planner;
    jostle_plan *made;
    jostle_body bodies[3];
    jostle_planner_options options = jostle_planner_options_default();

    MUST(jostle_scene_new(context, &scene));
    for (int i = 0; i < 3; i++) {
        jostle_body_def def = jostle_body_def_default();
        def.points = square;
        def.point_count = 4;
        def.pose.p.x = places[i][0];
        def.pose.p.y = places[i][1];
        MUST(jostle_scene_add_body(scene, &def, &bodies[i]));
    }
    options.engine = "dipn";
    options.engine_model = dipn;
    options.scorer = "gc";
    options.scorer_model = gc;
    options.confirm = "none";
    options.max_iterations = 20;
    /* A network of another kind. */
    options.scorer_model = dipn;
    CHECK(jostle_planner_new(context, &options, &planner) == JOSTLE_ERROR_MODEL_KIND && !planner);
    options.scorer_model = gc;

    /* Another gripper: refused when the planner is made where the options name it, else by the first call with a scene. */
    jostle_gripper mask = jostle_gripper_default(), own = jostle_gripper_default(), found = jostle_gripper_default();
    jostle_job *job = (jostle_job *)&failures;
    MUST(jostle_gripper_by_name("dissertation_mask", &mask));
    options.gripper = &mask;
    CHECK(jostle_planner_new(context, &options, &planner) == JOSTLE_ERROR_ARGUMENT && !planner);
    CHECK(strstr(jostle_last_error(), "options.gripper: is `dissertation_mask` (opening 70.00 mm, fingers 22.00 x 27.50"));
    CHECK(strstr(jostle_last_error(), "made for `robotiq_2f85` (opening 80.70 mm, fingers 22.00 x 15.00 mm"));
    own.opening += 0.0002;
    options.gripper = &own;
    MUST(jostle_planner_new(context, &options, &planner));
    jostle_planner_free(planner);
    options.gripper = NULL;
    MUST(jostle_planner_new(context, &options, &planner));
    MUST(jostle_scene_set_gripper(scene, &mask));
    CHECK(jostle_planner_solve(planner, scene, bodies[0], NULL, &made) == JOSTLE_ERROR_ARGUMENT && !made);
    CHECK(strstr(jostle_last_error(), "scene.gripper: is `dissertation_mask` ("));
    CHECK(jostle_planner_step(planner, scene, bodies[0], 5, NULL, &made) == JOSTLE_ERROR_ARGUMENT && !made);
    CHECK(jostle_planner_job_start(planner, scene, bodies[0], NULL, &job) == JOSTLE_ERROR_ARGUMENT && !job);
    CHECK(strstr(jostle_last_error(), "scene.gripper: is `dissertation_mask` ("));
    MUST(jostle_scene_get_gripper(scene, &found));
    CHECK(memcmp(&found, &mask, sizeof mask) == 0);
    MUST(jostle_scene_set_gripper(scene, &own));
    jostle_model_free(gc);
    jostle_model_free(dipn);
    MUST(jostle_planner_solve(planner, scene, bodies[0], NULL, &made));
    jostle_plan_free(made);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
}

int main(int argc, char **argv)
{
    jostle_context *context;
    int at = 1, refused = 0;

    MUST(jostle_context_new(NULL, &context));
    for (; at + 2 < argc && strcmp(argv[at], "good"); at += 3, refused++) {
        jostle_model *model = (jostle_model *)&failures;
        jostle_status status = jostle_model_load(context, argv[at], NULL, NULL, &model);
        const char *name = jostle_status_name(status);
        if (strcmp(name, argv[at + 1]) || !strstr(jostle_last_error(), argv[at + 2])) {
            printf("%s: %s, %s\n", argv[at], name, jostle_last_error());
            failures++;
        }
        CHECK(model == NULL);
    }
    if (at + 2 < argc) {
        jostle_model *gc = load(context, argv[at + 1], "gc"), *dipn = load(context, argv[at + 2], "dipn");
        look(gc);
        plan(context, gc, dipn);
    }
    jostle_context_free(context);
    CHECK(jostle_handle_count() == 0);
    if (failures) return 1;
    printf("models: %d files refused, %s\n", refused, at < argc ? "two used" : "none used");
    return 0;
}
