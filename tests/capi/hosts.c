/* Situations that hosts put the library into. The first argument names one; each prints "NAME: as promised". */
#define _GNU_SOURCE
#include <jostle/jostle.h>

#include <dlfcn.h>
#include <errno.h>
#include <fenv.h>
#include <limits.h>
#include <locale.h>
#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static int failures;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s (last error: %s)\n", __func__, __LINE__, #condition, jostle_last_error());               \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)
#define MUST(call) CHECK((call) == JOSTLE_OK)

/* Of a decision. */
static uint64_t iterations = 8;

static const char *const engines[] = {"planar", "prism", "rapier", "bullet"};
#define ENGINES (sizeof engines / sizeof *engines)

static int has_engine(const char *engine)
{
    return strcmp(engine, "bullet") || jostle_feature(JOSTLE_FEATURE_BULLET);
}

static jostle_body add(jostle_scene *scene, double x, double y)
{
    static const jostle_vec2 box[4] = {{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}};
    jostle_body body = {0};
    jostle_body_def def = jostle_body_def_default();
    def.points = box;
    def.point_count = 4;
    def.pose.p.x = x;
    def.pose.p.y = y;
    MUST(jostle_scene_add_body(scene, &def, &body));
    return body;
}

/* Three in a row, and two that stand in the way along it. */
static jostle_scene *row(jostle_context *context, jostle_body *target)
{
    jostle_scene *scene = NULL;
    MUST(jostle_scene_new(context, &scene));
    *target = add(scene, 0.5, 0);
    add(scene, 0.5, 0.042);
    add(scene, 0.5, -0.042);
    add(scene, 0.458, 0);
    add(scene, 0.542, 0);
    return scene;
}

static jostle_planner *planner_of(jostle_context *context, const char *engine, uint32_t threads)
{
    jostle_planner *planner = NULL;
    jostle_planner_options options = jostle_planner_options_default();
    options.engine = engine;
    options.confirm = "none";
    options.threads = threads;
    options.lanes = 8;
    options.max_iterations = iterations;
    MUST(jostle_planner_new(context, &options, &planner));
    return planner;
}

/* The hash of a plan, everything made and freed on the way. */
static uint64_t planned(const char *engine, uint32_t threads)
{
    jostle_context *context = NULL;
    jostle_plan *plan = NULL;
    jostle_body target;
    uint64_t hash = 0;
    MUST(jostle_context_new(NULL, &context));
    jostle_scene *scene = row(context, &target);
    jostle_planner *planner = planner_of(context, engine, threads);
    MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
    MUST(jostle_plan_hash(plan, &hash));
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return hash;
}

/* --- the floating-point state -------------------------------------------------------------------------------------- */

#if defined __x86_64__
static uint32_t float_state(void)
{
    uint32_t state;
    __asm__ volatile("stmxcsr %0" : "=m"(state));
    return state;
}

static void set_float_state(uint32_t state)
{
    __asm__ volatile("ldmxcsr %0" : : "m"(state));
}

static uint16_t x87_control(void)
{
    uint16_t control;
    __asm__ volatile("fnstcw %0" : "=m"(control));
    return control;
}

static void set_x87_control(uint16_t control)
{
    __asm__ volatile("fldcw %0" : : "m"(control));
}

/* The default; up, down, towards zero; results and inputs flushed; traps on all but inexact; all flags raised. */
static const uint32_t states[] = {0x1f80, 0x5f80, 0x3f80, 0x7f80, 0x9fc0, 0x1fc0, 0x1000, 0x1fbf};
/* Extended precision to nearest; single precision; double precision upwards. */
static const uint16_t controls[] = {0x037f, 0x007f, 0x0a7f};

static void floats(void)
{
    for (size_t e = 0; e < ENGINES; e++) {
        if (!has_engine(engines[e])) continue;
        const uint64_t wanted = planned(engines[e], 0);
        /* Bullet takes long: up, and with everything flushed. */
        const size_t first = strcmp(engines[e], "bullet") ? 0 : 1, last = first ? 5 : sizeof states / sizeof *states;
        for (size_t s = first; s < last; s += first ? 3 : 1) {
            for (uint32_t threads = 0; threads < 4; threads += 3) {
                set_float_state(states[s]);
                const uint64_t hash = planned(engines[e], threads);
                const uint32_t after = float_state();
                set_float_state(0x1f80);
                CHECK(hash == wanted);
                CHECK(after == states[s]);
            }
        }
        for (size_t c = 0; c < sizeof controls / sizeof *controls; c++) {
            set_x87_control(controls[c]);
            const uint64_t hash = planned(engines[e], 0);
            const uint16_t after = x87_control();
            set_x87_control(0x037f);
            CHECK(hash == wanted);
            CHECK(after == controls[c]);
        }
    }
}

/* The first session of the process, and a second; `argument` is the state. */
static void first_session(const char *argument, const char *path)
{
    const uint32_t state = (uint32_t)strtoul(argument, NULL, 16);
    jostle_context *context = NULL;
    jostle_model *models[2] = {NULL, NULL};
    MUST(jostle_context_new(NULL, &context));
    for (int i = 0; i < 2; i++) {
        set_float_state(state);
        const jostle_status status = jostle_model_load(context, path, NULL, NULL, &models[i]);
        const uint32_t after = float_state();
        set_float_state(0x1f80);
        CHECK(status == JOSTLE_OK);
        CHECK(after == state);
        jostle_model_free(models[i]);
    }
    jostle_context_free(context);
}
#else
static void floats(void)
{
    const uint64_t wanted = planned("planar", 0);
    static const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST};
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m++) {
        CHECK(fesetround(modes[m]) == 0);
        const uint64_t hash = planned("planar", 3);
        const int after = fegetround();
        fesetround(FE_TONEAREST);
        CHECK(hash == wanted && after == modes[m]);
    }
}

static void first_session(const char *argument, const char *path)
{
    (void)argument, (void)path;
}
#endif

/* --- a runtime that cannot be used ----------------------------------------------------------------------------------- */

/* Asked for again and again before anything else; then once more where there is one (`library` may be empty). */
static void no_runtime(const char *says, const char *library)
{
    char text[4096];
    size_t length;
    void *systems = dlopen("libonnxruntime.so.1", RTLD_LAZY | RTLD_LOCAL);
    if (systems) {
        printf("the system has a runtime, which is taken instead\n");
        dlclose(systems);
        return;
    }
    for (int i = 0; i < 3; i++) {
        CHECK(jostle_runtime_info(text, sizeof text, &length) == JOSTLE_ERROR_MODEL_RUNTIME);
        CHECK(strstr(jostle_last_error(), says) != NULL);
    }
    if (*library) {
        CHECK(setenv("ORT_DYLIB_PATH", library, 1) == 0);
        MUST(jostle_runtime_info(text, sizeof text, &length));
    }
}

/* --- a fork ---------------------------------------------------------------------------------------------------------- */

static int in_child(void (*work)(void))
{
    int status = 0;
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        /* A child that hangs is ended by its alarm. */
        alarm(60);
        failures = 0;
        work();
        fflush(stdout);
        _exit(failures ? 1 : 0);
    }
    return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static jostle_context *parents_context;
static jostle_planner *parents_planner;
static jostle_planner *parents_deciding;
static jostle_scene *parents_scene;
static jostle_body parents_target;
static jostle_job *parents_job;

static void use_parents(void)
{
    jostle_plan *plan = NULL;
    jostle_job_state state = 0;
    CHECK(jostle_planner_solve(parents_planner, parents_scene, parents_target, NULL, &plan) == JOSTLE_ERROR_STATE);
    CHECK(strstr(jostle_last_error(), "fork") != NULL && plan == NULL);
    CHECK(jostle_job_wait(parents_job, 1e9, &state) == JOSTLE_ERROR_STATE);
    CHECK(jostle_job_poll(parents_job, &state, NULL) == JOSTLE_ERROR_STATE);
    /* One of the child's own works, and all can be freed. */
    CHECK(planned("planar", 3) == planned("planar", 0));
    jostle_job_free(parents_job);
    jostle_planner_free(parents_planner);
    jostle_planner_free(parents_deciding);
    jostle_scene_free(parents_scene);
    jostle_context_free(parents_context);
    CHECK(jostle_handle_count() == 0);
}

static void forks(void)
{
    jostle_plan *plan = NULL;
    MUST(jostle_context_new(NULL, &parents_context));
    parents_scene = row(parents_context, &parents_target);
    parents_planner = planner_of(parents_context, "planar", 3);
    MUST(jostle_planner_solve(parents_planner, parents_scene, parents_target, NULL, &plan));
    jostle_plan_free(plan);
    jostle_planner_options options = jostle_planner_options_default();
    options.max_seconds = 1000;
    MUST(jostle_planner_new(parents_context, &options, &parents_deciding));
    MUST(jostle_planner_job_start(parents_deciding, parents_scene, parents_target, NULL, &parents_job));
    CHECK(in_child(use_parents));
    /* The parent goes on. */
    jostle_job_free(parents_job);
    MUST(jostle_planner_solve(parents_planner, parents_scene, parents_target, NULL, &plan));
    jostle_plan_free(plan);
    jostle_planner_free(parents_planner);
    jostle_planner_free(parents_deciding);
    jostle_scene_free(parents_scene);
    jostle_context_free(parents_context);
}

/* --- memory that the system does not give ---------------------------------------------------------------------------- */

static void memory(void)
{
    enum { SIDE = 16384 };
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_seen_body seen[4];
    size_t count = 0;
    struct rlimit limit;
    char line[64];
    unsigned long pages = 0;
    /* Untouched pages take no memory. */
    uint8_t *labels = mmap(NULL, (size_t)SIDE * SIDE, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    CHECK(labels != MAP_FAILED);
    MUST(jostle_context_new(NULL, &context));
    MUST(jostle_scene_new(context, &scene));
    jostle_camera_image image = jostle_camera_image_default();
    image.rows = image.cols = SIDE;
    image.labels = labels;
    image.label_stride = SIDE;
    const jostle_image_frame frame = {{{0.5, 0.0}, 0.0}, 1e-4, SIDE, SIDE};
    MUST(jostle_image_frame_map(&frame, &image.map));

    FILE *statm = fopen("/proc/self/statm", "r");
    CHECK(statm && fgets(line, sizeof line, statm) && sscanf(line, "%lu", &pages) == 1);
    if (statm) fclose(statm);
    limit.rlim_cur = limit.rlim_max = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)64 << 20);
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
    for (int i = 0; i < 3; i++) {
        CHECK(jostle_scene_add_image(scene, &image, NULL, seen, 4, &count) == JOSTLE_ERROR_MEMORY);
        CHECK(strstr(jostle_last_error(), "image") != NULL);
    }
    jostle_scene_free(scene);
    jostle_context_free(context);
    /* Nothing was spoilt by it. */
    CHECK(planned("planar", 0) != 0);
}

/* A search that would go on for ever: with fingers so bulky something is always in their way. */
static void memory_of_a_search(void)
{
    jostle_context *context = NULL;
    jostle_planner *planner = NULL;
    jostle_plan *plan = NULL;
    jostle_body target;
    jostle_outcome outcome = 0;
    char line[64], reason[512] = "";
    unsigned long pages = 0;
    size_t count = 0;
    uint64_t bytes = 0;
    struct rlimit limit;
    MUST(jostle_context_new(NULL, &context));
    jostle_scene *scene = row(context, &target);
    jostle_gripper gripper = jostle_gripper_default();
    gripper.finger_width = gripper.finger_thickness = 2.0;
    MUST(jostle_scene_set_gripper(scene, &gripper));
    jostle_planner_options options = jostle_planner_options_default();
    options.planner = "pmbs";
    options.engine = "planar";
    options.confirm = "none";
    options.threads = 1;
    options.max_seconds = 500.0;
    options.max_iterations = JOSTLE_NO_LIMIT;
    MUST(jostle_planner_new(context, &options, &planner));
    FILE *statm = fopen("/proc/self/statm", "r");
    CHECK(statm && fgets(line, sizeof line, statm) && sscanf(line, "%lu", &pages) == 1);
    if (statm) fclose(statm);
    limit.rlim_cur = limit.rlim_max = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)48 << 20);
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
    MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
    MUST(jostle_plan_outcome(plan, &outcome));
    CHECK(outcome == JOSTLE_OUTCOME_BUDGET);
    MUST(jostle_plan_action_count(plan, &count));
    CHECK(count > 0);
    MUST(jostle_plan_reason(plan, 0, reason, sizeof reason, &count));
    CHECK(strstr(reason, "memory") != NULL);
    MUST(jostle_planner_memory(planner, &bytes));
    CHECK(bytes > 1 << 20 && bytes < 48 << 20);
    jostle_plan_free(plan);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
}

/* --- a small stack --------------------------------------------------------------------------------------------------- */

/* With one engine, or with each. */
static void *plan_all(void *engine)
{
    const char *only = engine;
    for (size_t e = 0; e < ENGINES; e++)
        if (has_engine(engines[e]) && (!*only || !strcmp(only, engines[e]))) planned(engines[e], 0);
    return NULL;
}

static void stack(const char *argument, char *engine)
{
    pthread_attr_t attributes;
    pthread_t thread;
    /* Enough for every engine to be called from the deepest of the search. */
    iterations = 24;
    CHECK(pthread_attr_init(&attributes) == 0);
    CHECK(pthread_attr_setstacksize(&attributes, strtoul(argument, NULL, 10)) == 0);
    CHECK(pthread_create(&thread, &attributes, plan_all, engine) == 0);
    CHECK(pthread_join(thread, NULL) == 0);
    pthread_attr_destroy(&attributes);
}

/* --- what was fine, and stays so ------------------------------------------------------------------------------------- */

static void locale(const char *name)
{
    const uint64_t before = planned("planar", 0);
    char text[8];
    CHECK(setlocale(LC_ALL, name) != NULL);
    snprintf(text, sizeof text, "%.1f", 0.5);
    CHECK(!strcmp(text, "0,5"));
    CHECK(planned("planar", 0) == before);
    snprintf(text, sizeof text, "%.1f", 0.5);
    CHECK(!strcmp(text, "0,5"));
}

static void fifo(void)
{
    const uint64_t before = planned("planar", 3);
    const struct sched_param first = {.sched_priority = 1};
    if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &first) != 0) {
        printf("this process may not be scheduled so\n");
        return;
    }
    CHECK(planned("planar", 3) == before);
}

/* The library by itself: its functions are looked up, none is linked. */
static uint64_t hash_by(void *library)
{
    jostle_status (*context_new)(const jostle_context_options *, jostle_context **);
    void (*context_free)(jostle_context *);
    jostle_status (*scene_new)(const jostle_context *, jostle_scene **);
    void (*scene_free)(jostle_scene *);
    jostle_status (*scene_hash)(const jostle_scene *, uint64_t *);
    uint64_t (*handle_count)(void);
    uint64_t hash = 0;
#define FIND(pointer, name) *(void **)&pointer = dlsym(library, name)
    FIND(context_new, "jostle_context_new");
    FIND(context_free, "jostle_context_free");
    FIND(scene_new, "jostle_scene_new");
    FIND(scene_free, "jostle_scene_free");
    FIND(scene_hash, "jostle_scene_hash");
    FIND(handle_count, "jostle_handle_count");
    CHECK(context_new && context_free && scene_new && scene_free && scene_hash && handle_count);
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    CHECK(context_new(NULL, &context) == JOSTLE_OK);
    CHECK(scene_new(context, &scene) == JOSTLE_OK);
    CHECK(handle_count() == 2);
    CHECK(scene_hash(scene, &hash) == JOSTLE_OK);
    scene_free(scene);
    context_free(context);
    CHECK(handle_count() == 0);
    return hash;
}

/* Opened and closed again and again, and two copies side by side. */
static void copies(const char *one, const char *other)
{
    uint64_t hash = 0;
    for (int i = 0; i < 4; i++) {
        void *a = dlopen(one, RTLD_NOW | RTLD_LOCAL), *b = dlopen(other, RTLD_NOW | RTLD_LOCAL);
        CHECK(a && b && a != b);
        if (!a || !b) return;
        const uint64_t first = hash_by(a);
        CHECK(first == hash_by(b));
        CHECK(i == 0 || first == hash);
        hash = first;
        CHECK(dlclose(a) == 0);
        CHECK(hash_by(b) == hash);
        CHECK(dlclose(b) == 0);
    }
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    const char *first = argc > 2 ? argv[2] : "", *second = argc > 3 ? argv[3] : "";
    if (!strcmp(name, "floats")) floats();
    else if (!strcmp(name, "first-session")) first_session(first, second);
    else if (!strcmp(name, "no-runtime")) no_runtime(first, second);
    else if (!strcmp(name, "forks")) forks();
    else if (!strcmp(name, "memory")) memory();
    else if (!strcmp(name, "memory-of-a-search")) memory_of_a_search();
    else if (!strcmp(name, "stack")) stack(first, argc > 3 ? argv[3] : argv[argc - 1] + strlen(argv[argc - 1]));
    else if (!strcmp(name, "locale")) locale(first);
    else if (!strcmp(name, "fifo")) fifo();
    else if (!strcmp(name, "copies")) copies(first, second);
    else failures++;
    CHECK(jostle_handle_count() == 0);
    if (failures) return 1;
    printf("%s: as promised\n", name);
    return 0;
}
