/* Grasps through the C API: the best few of a body, and given ones examined. The arguments are scene files with a target;
 * in each a plan is made, and its last grasp has to be the first of the list where the plan expects the bodies to be. */
#include <jostle/jostle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s (last error: %s)\n", __func__, __LINE__, #condition, jostle_last_error());               \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)
#define MUST(call) CHECK((call) == JOSTLE_OK)

#define MOST 12

static const jostle_vec2 box[4] = {{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}};

static jostle_body add(jostle_scene *scene, const char *name, double x, double y)
{
    jostle_body body = {0};
    jostle_body_def def = jostle_body_def_default();
    def.points = box;
    def.point_count = 4;
    def.name = name;
    def.pose.p.x = x;
    def.pose.p.y = y;
    MUST(jostle_scene_add_body(scene, &def, &body));
    return body;
}

static int same_place(const jostle_grasp *a, const jostle_grasp *b)
{
    return memcmp(&a->position, &b->position, sizeof a->position) == 0 && a->angle == b->angle &&
           a->opening == b->opening;
}

/* Angle between two closing directions; a direction and its reverse are the same. */
static double turned(double a, double b)
{
    double turn = fabs(remainder(a - b, acos(-1.0)));
    return turn;
}

/* The list of a body: sorted, apart, and to the bit what examinations say. Gives the number of grasps. */
static size_t list(const jostle_scene *scene, jostle_body body, jostle_grasp_report *reports)
{
    size_t count = 99, asked = 99;
    jostle_grasp best;
    uint32_t found = 9;

    MUST(jostle_scene_best_grasps(scene, body, MOST, NULL, 0, &asked));
    MUST(jostle_scene_best_grasps(scene, body, MOST, reports, MOST, &count));
    MUST(jostle_scene_best_grasp(scene, body, &best, &found));
    CHECK(asked == count && count <= MOST && found == (count > 0));
    if (count > 0) CHECK(same_place(&best, &reports[0].grasp));
    for (size_t i = 0; i < count; i++) {
        const jostle_grasp *grasp = &reports[i].grasp;
        jostle_grasp_report again;
        memset(&again, 0xee, sizeof again);
        MUST(jostle_scene_examine_grasp(scene, body, grasp, &again));
        CHECK(memcmp(&again, &reports[i], sizeof again) == 0);
        CHECK(reports[i].allowed == 1 && grasp->margin >= 0 && JOSTLE_BODY_EQ(reports[i].body, body));
        for (size_t j = 0; j < i; j++) {
            const jostle_grasp *before = &reports[j].grasp;
            double off = hypot(grasp->position.x - before->position.x, grasp->position.y - before->position.y);
            CHECK(off >= JOSTLE_GRASPS_APART || turned(grasp->angle, before->angle) >= JOSTLE_GRASPS_TURNED);
            CHECK(before->score >= grasp->score - 1e-6);
        }
    }
    return count;
}

static void lists(jostle_context *context)
{
    jostle_grasp_report reports[MOST], few[2], untouched;
    jostle_scene *scene = NULL;
    jostle_gripper kept = jostle_gripper_default();
    size_t count, all;

    MUST(jostle_scene_new(context, &scene));
    jostle_body target = add(scene, "target", 0.5, 0), other = add(scene, "beside", 0.5, 0.06);
    all = list(scene, target, reports);
    CHECK(all > 3);
    /* By shape a grasp has no chance. */
    CHECK(isnan(reports[0].chance) && isnan(reports[0].features.depth) && reports[0].features.width > 0.039);
    CHECK(fabs(reports[0].features.width - reports[0].grasp.width) < 1e-12 && reports[0].features.mass == 0.1);

    MUST(jostle_scene_best_grasps(scene, target, 2, few, 2, &count));
    CHECK(count == 2 && memcmp(few, reports, sizeof few) == 0);
    memset(&untouched, 0xee, sizeof untouched);
    few[0] = few[1] = untouched;
    count = 99;
    CHECK(jostle_scene_best_grasps(scene, target, MOST, few, 1, &count) == JOSTLE_ERROR_BUFFER && count == all);
    CHECK(memcmp(&few[0], &untouched, sizeof untouched) == 0);
    MUST(jostle_scene_best_grasps(scene, target, (size_t)-1, NULL, 0, &count));
    CHECK(count >= all);

    MUST(jostle_gripper_by_name("robotiq_2f85_kept", &kept));
    MUST(jostle_scene_set_gripper(scene, &kept));
    CHECK(list(scene, target, reports) > 1);
    CHECK(reports[0].chance == reports[0].grasp.score && reports[0].chance > 0.5 && reports[0].features.depth > 0);

    /* A body that may not be grasped, and one hemmed in, have none. */
    (void)other;
    for (int i = 0; i < 4; i++) {
        static const double places[4][2] = {{0.7, 0.041}, {0.7, -0.041}, {0.659, 0}, {0.741, 0}};
        (void)add(scene, NULL, places[i][0], places[i][1]);
    }
    jostle_body hidden = add(scene, "hidden", 0.7, 0);
    MUST(jostle_scene_best_grasps(scene, hidden, MOST, reports, MOST, &count));
    CHECK(count == 0);
    jostle_scene_free(scene);
}

static void examined(jostle_context *context)
{
    jostle_scene *scene = NULL;
    jostle_grasp grasp;
    jostle_grasp_report report;
    char text[256], small[8];
    size_t length = 0;

    MUST(jostle_scene_new(context, &scene));
    jostle_body target = add(scene, "target", 0.5, 0), beside = add(scene, "beside", 0.5, 0.06);
    memset(&grasp, 0, sizeof grasp);
    /* What is not read may be anything. */
    grasp.width = grasp.margin = grasp.score = NAN;
    grasp.position.x = 0.5;
    MUST(jostle_scene_examine_grasp(scene, target, &grasp, &report));
    CHECK(report.allowed == 1 && report.grasp.opening == 0.0807 && report.grasp.score > 0.5 && isnan(report.chance));
    CHECK(report.fit_spare > 0 && report.cover_spare > 0 && report.finger_spare > 0 && report.between_spare > 0);
    CHECK(report.opening_spare == 0 && report.wedge_spare > 0.6 && report.wedge < 1e-9);
    CHECK(JOSTLE_BODY_EQ(report.finger_body, beside) && JOSTLE_BODY_EQ(report.between_body, beside));
    MUST(jostle_scene_explain_grasp(scene, target, &grasp, text, sizeof text, &length));
    CHECK(strlen(text) + 1 == length && strncmp(text, "it is allowed; the least spare room is ", 39) == 0);

    /* Across the neighbour a finger comes down on it. */
    grasp.angle = acos(0.0);
    MUST(jostle_scene_examine_grasp(scene, target, &grasp, &report));
    CHECK(report.allowed == 0 && report.limit == JOSTLE_LIMIT_FINGER && JOSTLE_BODY_EQ(report.limit_body, beside));
    CHECK(report.grasp.score == 0 && report.grasp.margin < 0 && report.finger_spare == report.grasp.margin);
    CHECK(strcmp(jostle_grasp_limit_name(report.limit), "finger") == 0);
    CHECK(jostle_scene_explain_grasp(scene, target, &grasp, small, sizeof small, &length) == JOSTLE_ERROR_BUFFER);
    MUST(jostle_scene_explain_grasp(scene, target, &grasp, text, sizeof text, &length));
    CHECK(strstr(text, "mm too near to `beside`; move the grasp, or push that body away"));

    grasp.position.x = 0.9;
    MUST(jostle_scene_examine_grasp(scene, target, &grasp, &report));
    CHECK(report.limit == JOSTLE_LIMIT_NOTHING_BETWEEN && report.allowed == 0 && isinf(report.grasp.margin));
    CHECK(isnan(report.fit_spare) && isnan(report.features.width) && report.limit_body.id == 0);
    grasp.position.x = 0.5;
    grasp.angle = 0;
    grasp.opening = 0.041;
    MUST(jostle_scene_examine_grasp(scene, target, &grasp, &report));
    CHECK(report.limit == JOSTLE_LIMIT_WIDTH && report.allowed == 0);
    grasp.opening = 0.1;
    MUST(jostle_scene_examine_grasp(scene, target, &grasp, &report));
    CHECK(report.limit == JOSTLE_LIMIT_OPENING && report.opening_spare < 0);
    CHECK(strcmp(jostle_grasp_limit_name(99), "unknown limit") == 0);
    jostle_scene_free(scene);
}

/* The plan's last grasp is the first of the list where its pushes are expected to leave the bodies. */
static void planned(jostle_context *context, const char *path)
{
    jostle_planner_options options = jostle_planner_options_default();
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_plan *plan = NULL;
    jostle_body target;
    jostle_body_pose poses[64];
    jostle_grasp_report first;
    jostle_action action;
    size_t actions = 0, count = 0;

    MUST(jostle_scene_read(context, path, &scene, &target));
    options.planner = "pmbs";
    options.max_iterations = 2000;
    MUST(jostle_planner_new(context, &options, &planner));
    MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
    MUST(jostle_plan_action_count(plan, &actions));
    CHECK(actions > 1);
    if (actions > 1) {
        MUST(jostle_plan_action(plan, actions - 1, &action));
        CHECK(action.kind == JOSTLE_ACTION_GRASP);
        MUST(jostle_plan_predicted(plan, actions - 2, poses, 64, &count));
        MUST(jostle_scene_update(scene, poses, count));
        MUST(jostle_scene_best_grasps(scene, target, 1, &first, 1, &count));
        CHECK(count == 1 && same_place(&first.grasp, &action.grasp));
        CHECK(fabs(first.grasp.score - action.grasp.score) < 1e-6);
    }
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
}

int main(int argc, char **argv)
{
    jostle_context *context = NULL;
    MUST(jostle_context_new(NULL, &context));
    lists(context);
    examined(context);
    for (int i = 1; i < argc; i++) planned(context, argv[i]);
    jostle_context_free(context);
    CHECK(jostle_handle_count() == 0);
    puts(failures ? "grasps: failed" : "grasps: as promised");
    return failures ? 1 : 0;
}
