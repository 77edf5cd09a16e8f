/* What the C API promises beside refusing bad input. Each test prints nothing unless it fails. */
#include <jostle/jostle.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int failures;

/* Under valgrind a simulated push takes a hundred times as long. */
#ifdef LIGHT
#define ITERATIONS 2
#define PACKED 6
#else
#define ITERATIONS 60
#define PACKED 12
#endif

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s (last error: %s)\n", __func__, __LINE__, #condition, jostle_last_error());               \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)
#define MUST(call) CHECK((call) == JOSTLE_OK)

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

/* Three in a row: the one in the middle cannot be grasped along the row. */
static jostle_scene *row(jostle_context *context, jostle_body *target)
{
    jostle_scene *scene = NULL;
    MUST(jostle_scene_new(context, &scene));
    *target = add(scene, "target", 0.5, 0);
    add(scene, "left", 0.5, 0.042);
    add(scene, "right", 0.5, -0.042);
    add(scene, "front", 0.458, 0);
    add(scene, "back", 0.542, 0);
    return scene;
}

static uint64_t hash_of(const jostle_scene *scene)
{
    uint64_t hash = 0;
    MUST(jostle_scene_hash(scene, &hash));
    return hash;
}

static void scenes(jostle_context *context)
{
    jostle_body target, found = {0}, gone;
    jostle_scene *scene = row(context, &target), *copy = NULL;
    size_t count = 0;
    char name[16];
    jostle_pose2 pose = {{0.3, 0.1}, 0.5}, got;
    uint32_t present = 9;

    MUST(jostle_scene_body_count(scene, &count));
    CHECK(count == 5);
    MUST(jostle_scene_find_body(scene, "left", &found));
    MUST(jostle_scene_body_name(scene, found, name, sizeof name, &count));
    CHECK(count == 5 && strcmp(name, "left") == 0);

    /* Bodies have the same ids in a clone, and the two live on their own. */
    MUST(jostle_scene_clone(scene, &copy));
    CHECK(hash_of(scene) == hash_of(copy));
    MUST(jostle_scene_set_pose(copy, target, &pose));
    CHECK(hash_of(scene) != hash_of(copy));
    MUST(jostle_scene_get_pose(copy, target, &got));
    CHECK(memcmp(&got, &pose, sizeof pose) == 0);
    MUST(jostle_scene_get_pose(scene, target, &got));
    CHECK(got.p.x == 0.5);

    /* A removed body's id is not given out again. */
    MUST(jostle_scene_remove_body(scene, found));
    gone = found;
    found = add(scene, "left", 0.5, 0.042);
    CHECK(!JOSTLE_BODY_EQ(gone, found));
    CHECK(jostle_scene_get_pose(scene, gone, &got) == JOSTLE_ERROR_NOT_FOUND);
    MUST(jostle_scene_get_pose(copy, gone, &got));

    /* Another scene's bodies are unknown, whatever their number. */
    jostle_body foreign;
    jostle_scene *other = row(context, &foreign);
    CHECK(jostle_scene_get_pose(scene, foreign, &got) == JOSTLE_ERROR_NOT_FOUND);
    jostle_scene_free(other);

    /* One observation of several; those not listed stay. */
    jostle_body_pose seen[2] = {{target, {{0.5, 0.001}, 0}, 1, 0}, {found, {{0.5, 0.05}, 0}, 0, 0}}, all[8];
    MUST(jostle_scene_update(scene, seen, 2));
    MUST(jostle_scene_get_present(scene, found, &present));
    CHECK(present == 0);
    MUST(jostle_scene_poses(scene, all, 8, &count));
    CHECK(count == 5 && JOSTLE_BODY_EQ(all[0].body, target) && all[0].pose.p.y == 0.001);
    MUST(jostle_scene_set_present(scene, found, 1));
    MUST(jostle_scene_update(scene, NULL, 0));

    /* Settings come back. */
    jostle_gripper gripper = jostle_gripper_default(), same;
    jostle_workspace workspace = jostle_workspace_default();
    double ground, tip;
    MUST(jostle_gripper_by_name("robotiq_2f85_kept", &gripper));
    MUST(jostle_scene_set_gripper(scene, &gripper));
    same = jostle_gripper_default();
    MUST(jostle_scene_get_gripper(scene, &same));
    CHECK(memcmp(&same, &gripper, sizeof same) == 0 && same.grasp_score == JOSTLE_SCORE_KEPT);
    /* A robot's path of the tip: by name, of one's own, none. */
    MUST(jostle_gripper_by_name("robotiq_2f85_ur5e", &gripper));
    CHECK(gripper.tip_path == JOSTLE_TIP_UR5E && gripper.grasp_score == JOSTLE_SCORE_KEPT);
    MUST(jostle_scene_set_gripper(scene, &gripper));
    jostle_vec2 sink[] = {{0, 0.02}, {0.05, 0.01}}, rise[] = {{0, 0}, {1, 0.05}};
    jostle_tip_path path = jostle_tip_path_default();
    path.sink = sink, path.sink_count = 2, path.rise = rise, path.rise_count = 2;
    path.shortfall_along = path.shortfall_across = 0.02;
    MUST(jostle_scene_set_tip_path(scene, &path));
    sink[0].y = 0.5;
    same = jostle_gripper_default();
    MUST(jostle_scene_get_gripper(scene, &same));
    CHECK(same.tip_path == JOSTLE_TIP_OWN && same.opening == gripper.opening);
    same.opening = 0.06;
    MUST(jostle_scene_set_gripper(scene, &same));
    MUST(jostle_scene_get_gripper(scene, &same));
    CHECK(same.tip_path == JOSTLE_TIP_OWN && same.opening == 0.06);
    MUST(jostle_scene_set_tip_path(scene, NULL));
    MUST(jostle_scene_get_gripper(scene, &same));
    CHECK(same.tip_path == JOSTLE_TIP_STRAIGHT);
    MUST(jostle_gripper_by_name("dissertation_mask", &gripper));
    MUST(jostle_scene_set_gripper(scene, &gripper));
    same = jostle_gripper_default();
    MUST(jostle_scene_get_gripper(scene, &same));
    CHECK(memcmp(&same, &gripper, sizeof same) == 0 && same.opening == 0.07);
    workspace.leave_rule = JOSTLE_LEAVE_FOOTPRINT;
    workspace.leave_scope = JOSTLE_SCOPE_TARGET_ONLY;
    MUST(jostle_scene_set_workspace(scene, &workspace));
    workspace = jostle_workspace_default();
    MUST(jostle_scene_get_workspace(scene, &workspace));
    CHECK(workspace.leave_rule == JOSTLE_LEAVE_FOOTPRINT && workspace.leave_scope == JOSTLE_SCOPE_TARGET_ONLY);
    MUST(jostle_scene_set_friction(scene, 1.0, 0.8));
    MUST(jostle_scene_get_friction(scene, &ground, &tip));
    CHECK(ground == 1.0 && tip == 0.8);
    MUST(jostle_scene_set_overlap_tolerance(scene, 0.004));

    /* Shapes of every kind. */
    jostle_body_def def = jostle_body_def_default();
    jostle_shape_part parts[2] = {{JOSTLE_SHAPE_DISC, 0, {{0, 0}, 0}, NULL, 0, 0.02},
                                  {JOSTLE_SHAPE_POLYGON, 0, {{0.02, 0}, 0.3}, box, 4, 0}};
    def.pose.p.x = 0.35;
    def.shape = JOSTLE_SHAPE_COMPOUND, def.parts = parts, def.part_count = 2;
    MUST(jostle_scene_add_body(scene, &def, &found));
    def = jostle_body_def_default();
    def.pose.p.y = 0.15, def.pose.p.x = 0.5;
    def.shape = JOSTLE_SHAPE_DISC, def.radius = 0.02;
    MUST(jostle_scene_add_body(scene, &def, &found));
    def.shape = JOSTLE_SHAPE_BLOCK, def.block = "concave", def.pose.p.y = -0.15, def.pose.theta = 7.0;
    MUST(jostle_scene_add_body(scene, &def, &found));
    MUST(jostle_scene_check(scene));

    /* A file holds all of it. */
    jostle_scene *read = NULL;
    jostle_body goal = {0};
    MUST(jostle_scene_write(scene, target, "behaviour_scene.json"));
    MUST(jostle_scene_read(context, "behaviour_scene.json", &read, &goal));
    MUST(jostle_scene_body_name(read, goal, name, sizeof name, &count));
    CHECK(strcmp(name, "target") == 0);
    MUST(jostle_scene_body_count(read, &count));
    CHECK(count == 8);
    CHECK(hash_of(read) == hash_of(scene));
    jostle_scene_free(read);

    /* The generator is a function of its numbers. */
    jostle_scene *a = NULL, *b = NULL;
    MUST(jostle_scene_generate(context, 5, 2, 7, &a, &goal));
    MUST(jostle_scene_generate(context, 5, 2, 7, &b, &goal));
    CHECK(hash_of(a) == hash_of(b));
    jostle_scene_free(a);
    jostle_scene_free(b);
    jostle_scene_free(copy);
    jostle_scene_free(scene);
}

static jostle_planner *planner_of(jostle_context *context, uint32_t threads, uint64_t iterations)
{
    jostle_planner *planner = NULL;
    jostle_planner_options options = jostle_planner_options_default();
    options.threads = threads;
    options.max_iterations = iterations;
    options.lanes = 4;
    options.seed = 3;
    MUST(jostle_planner_new(context, &options, &planner));
    return planner;
}

static void plans(jostle_context *context)
{
    jostle_body target;
    jostle_scene *scene = row(context, &target);
    uint64_t hashes[3] = {0};
    for (uint32_t threads = 0; threads < 3; threads++) {
        jostle_planner *planner = planner_of(context, threads, ITERATIONS);
        jostle_plan *plan = NULL;
        MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
        MUST(jostle_plan_hash(plan, &hashes[threads]));
        if (threads == 0) {
            jostle_outcome outcome = 0;
            jostle_action actions[64], first;
            jostle_ranked_action considered[64];
            jostle_body_pose predicted[8];
            jostle_plan_statistics statistics = jostle_plan_statistics_default();
            size_t count = 0, needed = 0;
            double value;
            MUST(jostle_plan_outcome(plan, &outcome));
            CHECK(strcmp(jostle_outcome_name(outcome), "unknown outcome") != 0);
            MUST(jostle_plan_actions(plan, actions, 64, &count));
            MUST(jostle_plan_action_count(plan, &needed));
            CHECK(count == needed);
            for (size_t i = 0; i < count; i++) {
                MUST(jostle_plan_action(plan, i, &first));
                CHECK(memcmp(&first, &actions[i], sizeof first) == 0);
                MUST(jostle_plan_value(plan, i, &value));
                MUST(jostle_plan_predicted(plan, i, predicted, 8, &needed));
                CHECK(needed == 5 && JOSTLE_BODY_EQ(predicted[0].body, target));
            }
            MUST(jostle_plan_considered(plan, considered, 64, &needed));
            for (size_t i = 0; i < needed; i++) {
                double chance = -1, expected = -1;
                size_t bodies = 0;
                MUST(jostle_plan_explain(plan, i, &chance, &expected, predicted, 8, &bodies));
                CHECK(bodies == 5 && chance >= 0 && chance <= 1 && (expected == 0 || expected >= 2));
                MUST(jostle_plan_explain(plan, i, NULL, NULL, NULL, 0, &bodies));
            }
            CHECK(jostle_plan_explain(plan, needed, NULL, NULL, NULL, 0, &count) == JOSTLE_ERROR_NOT_FOUND);
            MUST(jostle_plan_get_statistics(plan, &statistics));
            CHECK(statistics.proved_shortest <= 1 && statistics.success_chance <= 1);
            CHECK(statistics.seed == 3 && statistics.struct_size == sizeof statistics);
            size_t reasons = 9;
            MUST(jostle_plan_reason_count(plan, &reasons));
            CHECK((reasons == 0) == (outcome == JOSTLE_OUTCOME_SOLVED));
            for (size_t i = 0; i < reasons; i++) {
                char sentence[512];
                MUST(jostle_plan_reason(plan, i, sentence, sizeof sentence, &needed));
                CHECK(strlen(sentence) + 1 == needed && strstr(sentence, "; "));
                CHECK(jostle_plan_reason(plan, i, sentence, needed - 1, &needed) == JOSTLE_ERROR_BUFFER);
            }
            CHECK(jostle_plan_reason(plan, reasons, NULL, 0, &needed) == JOSTLE_ERROR_NOT_FOUND);
            /* The same question has the same answer, whether a step went on in between or not. */
            for (int stepped = 0; stepped < 2; stepped++) {
                jostle_plan *again = NULL;
                uint64_t hash = 0;
                if (stepped) {
                    MUST(jostle_planner_step(planner, scene, target, 8, NULL, &again));
                    jostle_plan_free(again);
                }
                MUST(jostle_planner_solve(planner, scene, target, NULL, &again));
                MUST(jostle_plan_hash(again, &hash));
                CHECK(hash == hashes[0]);
                jostle_plan_free(again);
            }
            MUST(jostle_plan_json(plan, NULL, 0, &needed));
            char *text = malloc(needed);
            MUST(jostle_plan_json(plan, text, needed, &needed));
            CHECK(strlen(text) + 1 == needed && strstr(text, "\"planner\":\"hedge\"") && strstr(text, "\"reasons\":["));
            free(text);
            uint32_t kept = 9;
            if (count) MUST(jostle_planner_advance(planner, &actions[0], &kept));
            uint64_t bytes;
            MUST(jostle_planner_memory(planner, &bytes));
            MUST(jostle_planner_reset(planner));
        }
        /* The plan outlives the planner and the scene's changes. */
        jostle_planner_free(planner);
        size_t count;
        MUST(jostle_plan_action_count(plan, &count));
        jostle_plan_free(plan);
    }
    CHECK(hashes[0] == hashes[1] && hashes[1] == hashes[2]);
    jostle_scene_free(scene);
}

struct reentry {
    jostle_planner *planner;
    jostle_scene *scene;
    jostle_body target;
    int calls, wrong, stop_after;
};

static int32_t on_progress(const jostle_progress *progress, void *user)
{
    struct reentry *r = user;
    jostle_plan *plan = (void *)1;
    jostle_progress now = jostle_progress_default();
    r->calls++;
    if (progress->struct_size != sizeof *progress) r->wrong++;
    /* The planner is in use, and says so; what may be called at any time may be called here. */
    if (jostle_planner_solve(r->planner, r->scene, r->target, NULL, &plan) != JOSTLE_ERROR_BUSY || plan) r->wrong++;
    if (jostle_planner_reset(r->planner) != JOSTLE_ERROR_BUSY) r->wrong++;
    if (jostle_planner_progress(r->planner, &now) != JOSTLE_OK) r->wrong++;
    /* The scene is free: the planner has its own copy. */
    jostle_pose2 pose = {{0.5, 0.0}, 0};
    if (jostle_scene_set_pose(r->scene, r->target, &pose) != JOSTLE_OK) r->wrong++;
    return r->calls >= r->stop_after;
}

/* Much to search, and never content. */
static jostle_scene *packed(jostle_context *context, jostle_body *target)
{
    jostle_scene *scene = NULL;
    MUST(jostle_scene_generate(context, 7, 0, PACKED, &scene, target));
    return scene;
}

static void callbacks(jostle_context *context)
{
    jostle_body target;
    jostle_scene *scene = packed(context, &target);
    jostle_planner_options options = jostle_planner_options_default();
    options.max_iterations = 100000;
    options.execute_score = options.solved_score = 1;
    options.lanes = 4, options.max_depth = 2; /* short iterations */
    jostle_planner *planner = NULL;
    MUST(jostle_planner_new(context, &options, &planner));
    struct reentry r = {planner, scene, target, 0, 0, 3};
    jostle_solve_options solve = jostle_solve_options_default();
    solve.progress = on_progress;
    solve.user = &r;
    solve.progress_seconds = 0;
    jostle_plan *plan = NULL;
    MUST(jostle_planner_solve(planner, scene, target, &solve, &plan));
    jostle_outcome outcome = 0;
    size_t count = 9;
    CHECK(r.wrong == 0 && r.calls == 3);
    MUST(jostle_plan_outcome(plan, &outcome));
    MUST(jostle_plan_action_count(plan, &count));
    CHECK(outcome == JOSTLE_OUTCOME_CANCELLED && count == 0);
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void *trigger_later(void *cancel)
{
    struct timespec t = {0, 50000000};
    nanosleep(&t, NULL);
    return jostle_cancel_trigger(cancel) == JOSTLE_OK ? cancel : NULL;
}

static void jobs(jostle_context *context)
{
    jostle_body target;
    jostle_scene *scene = row(context, &target);
    jostle_planner *planner = planner_of(context, 0, ITERATIONS);
    jostle_job *job = NULL;
    jostle_plan *plan = NULL, *direct = NULL;
    jostle_job_state state = 0;
    uint64_t a = 0, b = 1;

    /* A job makes the plan that solve makes. */
    MUST(jostle_planner_job_start(planner, scene, target, NULL, &job));
    MUST(jostle_job_wait(job, HUGE_VAL, &state));
    CHECK(state == JOSTLE_JOB_DONE);
    MUST(jostle_job_take_plan(job, &plan));
    MUST(jostle_plan_hash(plan, &a));
    jostle_job_free(job);
    jostle_planner_free(planner);
    planner = planner_of(context, 0, ITERATIONS);
    MUST(jostle_planner_solve(planner, scene, target, NULL, &direct));
    MUST(jostle_plan_hash(direct, &b));
    CHECK(a == b);
    jostle_plan_free(plan);
    jostle_plan_free(direct);
    jostle_planner_free(planner);
    jostle_scene_free(scene);

    /* A cancel from another thread ends a long decision soon. The flag may be freed before. */
    jostle_planner_options options = jostle_planner_options_default();
    options.max_seconds = 60;
    options.execute_score = options.solved_score = 1;
    options.lanes = 4, options.max_depth = 2; /* short iterations */
    options.engine = "rapier", options.preset = "fine"; /* slow enough that the search does not come to its end before */
    scene = packed(context, &target);
    MUST(jostle_planner_new(context, &options, &planner));
    jostle_cancel *cancel = NULL, *copy = NULL;
    uint32_t triggered = 9;
    MUST(jostle_cancel_new(context, &cancel));
    MUST(jostle_cancel_clone(cancel, &copy));
    jostle_solve_options solve = jostle_solve_options_default();
    solve.cancel = cancel;
    MUST(jostle_planner_job_start(planner, scene, target, &solve, &job));
    jostle_cancel_free(cancel);
    MUST(jostle_job_poll(job, &state, NULL));
    CHECK(state == JOSTLE_JOB_RUNNING);
    plan = NULL;
    CHECK(jostle_job_take_plan(job, &plan) == JOSTLE_ERROR_STATE && !plan);
    CHECK(jostle_planner_solve(planner, scene, target, NULL, &plan) == JOSTLE_ERROR_BUSY && !plan);
    MUST(jostle_job_wait(job, 0.001, &state));
    CHECK(state == JOSTLE_JOB_RUNNING);
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, trigger_later, copy) == 0);
    void *good = NULL;
    CHECK(pthread_join(thread, &good) == 0 && good);
    double begin = now();
    MUST(jostle_job_wait(job, 10, &state));
    CHECK(state == JOSTLE_JOB_DONE && now() - begin < 2);
    MUST(jostle_cancel_triggered(copy, &triggered));
    CHECK(triggered == 1);
    MUST(jostle_cancel_reset(copy));
    MUST(jostle_cancel_triggered(copy, &triggered));
    CHECK(triggered == 0);
    jostle_outcome outcome = 0;
    size_t count = 9;
    MUST(jostle_job_take_plan(job, &plan));
    MUST(jostle_plan_outcome(plan, &outcome));
    MUST(jostle_plan_action_count(plan, &count));
    CHECK(outcome == JOSTLE_OUTCOME_CANCELLED && count == 0);
    jostle_plan_free(plan);
    jostle_cancel_free(copy);
    jostle_job_free(job);

    /* So does a limit of time. */
    options.max_seconds = 0.05;
    jostle_planner *quick = NULL;
    MUST(jostle_planner_new(context, &options, &quick));
    begin = now();
    MUST(jostle_planner_solve(quick, scene, target, NULL, &plan));
    CHECK(now() - begin < 2);
    MUST(jostle_plan_outcome(plan, &outcome));
    CHECK(outcome == JOSTLE_OUTCOME_BUDGET);
    jostle_plan_free(plan);
    jostle_planner_free(quick);

    /* Freeing a running job cancels it and waits; parents may go first. */
    MUST(jostle_planner_job_start(planner, scene, target, NULL, &job));
    jostle_planner_free(planner);
    begin = now();
    jostle_job_free(job);
    CHECK(now() - begin < 2);
    jostle_scene_free(scene);
}

struct told {
    int errors, others;
    char text[256], function[64];
};

static void on_log(const jostle_log_message *message, void *user)
{
    struct told *told = user;
    if (message->level == JOSTLE_LOG_ERROR) {
        told->errors++;
        snprintf(told->text, sizeof told->text, "%s", message->text);
        snprintf(told->function, sizeof told->function, "%s", message->function);
    } else {
        told->others++;
    }
}

static void logs(void)
{
    struct told told = {0};
    jostle_context_options options = jostle_context_options_default();
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_body target, nobody = {0};
    options.log_callback = on_log;
    options.log_user = &told;
    options.log_mask = JOSTLE_LOG_ALL;
    MUST(jostle_context_new(&options, &context));
    scene = row(context, &target);
    CHECK(jostle_scene_remove_body(scene, nobody) == JOSTLE_ERROR_ARGUMENT);
    CHECK(told.errors == 1 && strcmp(told.function, "jostle_scene_remove_body") == 0);
    CHECK(strcmp(told.text, "body: is zero, which is no body") == 0);
    CHECK(strcmp(jostle_last_error(), told.text) == 0);
    jostle_planner *planner = planner_of(context, 0, 2);
    jostle_plan *plan = NULL;
    MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
    CHECK(told.others == 1);
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
}

/* Structs of clients that were compiled with older and newer headers. */
static void sizes(jostle_context *context)
{
    struct {
        jostle_planner_options options;
        uint64_t appended, neighbour;
    } newer = {jostle_planner_options_default(), 0, 77};
    jostle_planner *planner = NULL;
    newer.options.struct_size = (uint32_t)(sizeof newer.options + sizeof newer.appended);
    MUST(jostle_planner_new(context, &newer.options, &planner));
    jostle_planner_free(planner);
    newer.appended = 1;
    planner = NULL;
    CHECK(jostle_planner_new(context, &newer.options, &planner) == JOSTLE_ERROR_ABI && !planner);
    MUST(jostle_planner_options_init(&newer.options, sizeof newer.options + sizeof newer.appended));
    CHECK(newer.appended == 0 && newer.neighbour == 77);
    CHECK(newer.options.struct_size == sizeof newer.options + sizeof newer.appended);
}

static void *hammer(void *user)
{
    /* Dead, busy or fine, but never a crash. */
    jostle_scene *scene = *(jostle_scene **)user;
    for (int i = 0; i < 2000; i++) {
        jostle_body body;
        size_t count;
        uint64_t hash;
        jostle_status status = i % 3 == 0   ? jostle_scene_body_count(scene, &count)
                               : i % 3 == 1 ? jostle_scene_find_body(scene, "left", &body)
                                            : jostle_scene_hash(scene, &hash);
        if (status != JOSTLE_OK && status != JOSTLE_ERROR_BUSY && status != JOSTLE_ERROR_HANDLE) return user;
    }
    return NULL;
}

static void threads(jostle_context *context)
{
    jostle_body target;
    jostle_scene *scene = row(context, &target);
    pthread_t thread[3];
    for (int i = 0; i < 3; i++) CHECK(pthread_create(&thread[i], NULL, hammer, &scene) == 0);
    for (int i = 0; i < 500; i++) {
        jostle_pose2 pose = {{0.5, 0.0}, 0.001 * i};
        jostle_status status = jostle_scene_set_pose(scene, target, &pose);
        CHECK(status == JOSTLE_OK || status == JOSTLE_ERROR_BUSY);
    }
    jostle_scene_free(scene); /* while others use it */
    for (int i = 0; i < 3; i++) {
        void *bad = NULL;
        CHECK(pthread_join(thread[i], &bad) == 0 && !bad);
    }
}

/* Every look makes a scene of its own: what failed on the last one is not offered on the next. */
static void remembered_failures(jostle_context *context)
{
    jostle_planner *planner = planner_of(context, 1, 200);
    double angle = 0;
    for (int look = 0; look < 3; ++look) {
        jostle_scene *scene = NULL;
        jostle_plan *plan = NULL;
        jostle_action action;
        MUST(jostle_scene_new(context, &scene));
        jostle_body target = add(scene, NULL, 0.5 + 0.0003 * look, 0);
        add(scene, NULL, 0.5, 0.15);
        MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
        MUST(jostle_plan_action(plan, 0, &action));
        if (look == 0) {
            CHECK(action.kind == JOSTLE_ACTION_GRASP);
            angle = action.grasp.angle;
            MUST(jostle_planner_failed(planner, &action));
        } else {
            /* From another side, if at all. */
            CHECK(action.kind == JOSTLE_ACTION_PUSH || fabs(sin(action.grasp.angle - angle)) > 0.2);
        }
        jostle_plan_free(plan);
        jostle_scene_free(scene);
    }
    jostle_planner_free(planner);
}

/* A tall thin plate falls over: the push is executed, and its effect says that the outline is no longer true. */
static void toppling(jostle_context *context)
{
    static const jostle_vec2 plate[4] = {{-0.004, -0.03}, {0.004, -0.03}, {0.004, 0.03}, {-0.004, 0.03}};
    jostle_scene *scene = NULL;
    jostle_simulator *world = NULL;
    jostle_body body;
    jostle_body_def def = jostle_body_def_default();
    jostle_body_pose after;
    jostle_action push;
    jostle_effect effect = 0;
    size_t count = 0;
    MUST(jostle_scene_new(context, &scene));
    def.points = plate;
    def.point_count = 4;
    def.height = 0.15;
    def.pose.p.x = 0.5;
    MUST(jostle_scene_add_body(scene, &def, &body));
    jostle_simulator_options options = jostle_simulator_options_default();
    options.engine = "prism";
    MUST(jostle_simulator_new(context, scene, body, &options, &world));
    memset(&push, 0, sizeof push);
    push.kind = JOSTLE_ACTION_PUSH;
    push.push.start.x = 0.45, push.push.end.x = 0.53;
    MUST(jostle_simulator_execute(world, &push, &effect));
    CHECK(effect == JOSTLE_EFFECT_TOPPLED && strcmp(jostle_effect_name(effect), "toppled") == 0);
    MUST(jostle_simulator_poses(world, &after, 1, &count));
    CHECK(count == 1 && after.pose.p.x > 0.5);
    jostle_simulator_free(world);
    jostle_scene_free(scene);
}

static void simulators(jostle_context *context)
{
    jostle_body target;
    jostle_scene *scene = row(context, &target);
    jostle_simulator *world = NULL, *noisy = NULL;
    jostle_body_pose before[8], after[8], seen[8];
    size_t count = 0;
    jostle_effect effect = 0;
    uint32_t left = 9;
    MUST(jostle_simulator_new(context, scene, target, NULL, &world));
    MUST(jostle_simulator_poses(world, before, 8, &count));
    CHECK(count == 5);
    jostle_action push;
    memset(&push, 0, sizeof push);
    push.kind = JOSTLE_ACTION_PUSH;
    push.push.start.x = 0.58, push.push.end.x = 0.53;

    /* A limit that is over at once, and a cancel that came before: nothing is done, and the world is as it was. */
    jostle_execute_options within = jostle_execute_options_default();
    jostle_cancel *stop = NULL;
    within.max_seconds = 1e-9;
    MUST(jostle_simulator_execute_within(world, &push, &within, &effect));
    CHECK(effect == JOSTLE_EFFECT_INTERRUPTED && strcmp(jostle_effect_name(effect), "interrupted") == 0);
    within = jostle_execute_options_default();
    MUST(jostle_cancel_new(context, &stop));
    MUST(jostle_cancel_trigger(stop));
    within.cancel = stop;
    MUST(jostle_simulator_execute_within(world, &push, &within, &effect));
    CHECK(effect == JOSTLE_EFFECT_INTERRUPTED);
    MUST(jostle_simulator_poses(world, after, 8, &count));
    CHECK(memcmp(before, after, count * sizeof before[0]) == 0);
    for (int bad = 0; bad < 2; ++bad) {
        within.max_seconds = bad ? -1.0 : (double)NAN;
        CHECK(jostle_simulator_execute_within(world, &push, &within, &effect) == JOSTLE_ERROR_ARGUMENT);
    }
    within.max_seconds = 3600.0;
    MUST(jostle_cancel_reset(stop));
    MUST(jostle_simulator_execute_within(world, &push, &within, &effect));
    jostle_cancel_free(stop);
    CHECK(effect == JOSTLE_EFFECT_PUSHED);
    MUST(jostle_simulator_poses(world, after, 8, &count));
    CHECK(after[4].pose.p.x < before[4].pose.p.x - 0.02);
    MUST(jostle_simulator_observe(world, seen, 8, &count));
    CHECK(memcmp(seen, after, count * sizeof seen[0]) == 0);
    MUST(jostle_scene_update(scene, seen, count));
    push.push.start.x = 0.5, push.push.end.x = 0.6;
    MUST(jostle_simulator_execute(world, &push, &effect));
    CHECK(effect == JOSTLE_EFFECT_BLOCKED);
    MUST(jostle_simulator_target_left(world, &left));
    CHECK(left == 0);

    jostle_simulator_options options = jostle_simulator_options_default();
    options.position_noise = 0.0005;
    options.friction_spread = 0.2;
    MUST(jostle_simulator_new(context, scene, target, &options, &noisy));
    MUST(jostle_simulator_observe(noisy, seen, 8, &count));
    MUST(jostle_simulator_poses(noisy, after, 8, &count));
    CHECK(memcmp(seen, after, count * sizeof seen[0]) != 0);

    /* A body that stands free can be grasped, and the grasp holds. */
    jostle_scene *free_scene = NULL;
    jostle_action grasp;
    uint32_t found = 9;
    MUST(jostle_scene_new(context, &free_scene));
    jostle_body lone = add(free_scene, NULL, 0.5, 0);
    memset(&grasp, 0, sizeof grasp);
    grasp.kind = JOSTLE_ACTION_GRASP;
    grasp.body = lone;
    MUST(jostle_scene_best_grasp(free_scene, lone, &grasp.grasp, &found));
    CHECK(found == 1);
    jostle_simulator_free(world);
    MUST(jostle_simulator_new(context, free_scene, lone, NULL, &world));
    MUST(jostle_simulator_execute(world, &grasp, &effect));
    CHECK(effect == JOSTLE_EFFECT_GRASPED && strcmp(jostle_effect_name(effect), "grasped") == 0);
    MUST(jostle_simulator_poses(world, after, 8, &count));
    CHECK(count == 1 && after[0].present == 0);
    /* The recorded robot keeps what it grasps in some worlds. */
    jostle_simulator_options robot = jostle_simulator_options_default();
    robot.executor = JOSTLE_EXECUTOR_ROBOT;
    uint32_t kept = 0, lost = 0;
    for (robot.seed = 0; robot.seed < 200; robot.seed++) {
        jostle_simulator_free(world);
        MUST(jostle_simulator_new(context, free_scene, lone, &robot, &world));
        MUST(jostle_simulator_execute(world, &grasp, &effect));
        CHECK(effect == JOSTLE_EFFECT_GRASPED || effect == JOSTLE_EFFECT_MISSED);
        kept += effect == JOSTLE_EFFECT_GRASPED, lost += effect == JOSTLE_EFFECT_MISSED;
    }
    CHECK(kept > 100 && lost > 0);
    jostle_simulator_free(world);
    jostle_simulator_free(noisy);
    jostle_scene_free(free_scene);
    jostle_scene_free(scene);
}

int main(void)
{
    jostle_context *context = NULL;
    MUST(jostle_abi_check(JOSTLE_ABI_VERSION));
    MUST(jostle_context_new(NULL, &context));
    CHECK(jostle_feature(JOSTLE_FEATURE_RAPIER) == 1);
    scenes(context);
    plans(context);
    callbacks(context);
    jobs(context);
    logs();
    sizes(context);
    threads(context);
    simulators(context);
    toppling(context);
    remembered_failures(context);
    jostle_context_free(context);
    CHECK(jostle_handle_count() == 0);
    puts(failures ? "behaviour: failed" : "behaviour: as promised");
    return failures ? 1 : 0;
}
