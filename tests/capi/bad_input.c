/*
 * Values that cannot be used, and what each function says of them. bad_input_calls.h is generated from the header by
 * tests/bad_input.rs: every pointer null, every handle dead, foreign or of another type.
 */
#include <jostle/jostle.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static jostle_scene *scene;
static uint64_t scene_hash;
static unsigned long failures;

/* New handles go here; a failing call leaves them null. */
static jostle_context *new_context;
static jostle_scene *new_scene;
static jostle_planner *new_planner;
static jostle_job *new_job;
static jostle_plan *new_plan;
static jostle_cancel *new_cancel;
static jostle_simulator *new_simulator;
static jostle_model *new_model;

static void check(int line, const char *call, jostle_status got, jostle_status want, const char *message)
{
    uint64_t hash = 0;
    const char *said = jostle_last_error();
    if (got != want || strncmp(said, message, strlen(message)) != 0) {
        printf("%d: %s\n  gave %s, wanted %s\n  said \"%s\", wanted \"%s...\"\n", line, call, jostle_status_name(got),
               jostle_status_name(want), said, message);
        failures++;
    }
    if (new_context || new_scene || new_planner || new_job || new_plan || new_cancel || new_simulator ||
        new_model) {
        printf("%d: %s\n  left a handle\n", line, call);
        exit(1);
    }
    if (jostle_scene_hash(scene, &hash) != JOSTLE_OK || hash != scene_hash) {
        printf("%d: %s\n  changed the scene\n", line, call);
        failures++;
    }
}

/* Handles are set to something else first: a failing call has to make them null. */
#define GARBAGE(handle) (handle) = (void *)&failures
#define BAD(call, want, message)                                                                                       \
    do {                                                                                                               \
        GARBAGE(new_context), GARBAGE(new_scene), GARBAGE(new_planner), GARBAGE(new_job), GARBAGE(new_plan);           \
        GARBAGE(new_cancel), GARBAGE(new_simulator), GARBAGE(new_model);                                                                   \
        jostle_status status_ = (call);                                                                                \
        if ((void *)new_context == (void *)&failures) new_context = NULL;                                              \
        if ((void *)new_scene == (void *)&failures) new_scene = NULL;                                                  \
        if ((void *)new_planner == (void *)&failures) new_planner = NULL;                                              \
        if ((void *)new_job == (void *)&failures) new_job = NULL;                                                      \
        if ((void *)new_plan == (void *)&failures) new_plan = NULL;                                                    \
        if ((void *)new_cancel == (void *)&failures) new_cancel = NULL;                                                \
        if ((void *)new_simulator == (void *)&failures) new_simulator = NULL;                                          \
        if ((void *)new_model == (void *)&failures) new_model = NULL;                                                  \
        check(__LINE__, #call, status_, (want), (message));                                                            \
    } while (0)

#define MUST(call)                                                                                                     \
    do {                                                                                                               \
        if ((call) != JOSTLE_OK) {                                                                                     \
            printf("%d: %s: %s\n", __LINE__, #call, jostle_last_error());                                              \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

#define NOT_A_NUMBER (HUGE_VAL - HUGE_VAL)
#define ARGUMENT JOSTLE_ERROR_ARGUMENT
#define NOT_FOUND JOSTLE_ERROR_NOT_FOUND

static const jostle_vec2 box[4] = {{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}};

static jostle_body_def square(double x, double y)
{
    jostle_body_def def = jostle_body_def_default();
    def.points = box;
    def.point_count = 4;
    def.pose.p.x = x;
    def.pose.p.y = y;
    return def;
}

static void write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    if (!file || fputs(text, file) < 0 || fclose(file)) exit(1);
}

static void bad_bodies(void)
{
    jostle_body body = {0};
    jostle_body_def def;
    const jostle_vec2 bow_tie[4] = {{0, 0}, {0.05, 0.05}, {0.05, 0}, {0, 0.05}};
    const jostle_vec2 bay[4] = {{0, 0}, {0.08, 0}, {0.02, 0.02}, {0, 0.08}};
    const jostle_vec2 hole[3] = {{0, 0}, {0.05, NOT_A_NUMBER}, {0, 0.05}};
    const jostle_vec2 twice[4] = {{0, 0}, {0.05, 0}, {0.05, 0}, {0, 0.05}};
    const jostle_vec2 line[3] = {{0, 0}, {0.05, 0}, {0.1, 0}};
    jostle_shape_part parts[2] = {{JOSTLE_SHAPE_DISC, 0, {{0, 0}, 0}, NULL, 0, 0.02},
                                  {JOSTLE_SHAPE_DISC, 0, {{0.02, 0}, 0}, NULL, 0, 0.02}};

#define DEF(change, want, message)                                                                                     \
    def = square(0.5, 0.15);                                                                                           \
    change;                                                                                                            \
    BAD(jostle_scene_add_body(scene, &def, &body), want, message)

    DEF(def.struct_size = 0, ARGUMENT, "def.struct_size: is 0: the struct is not initialised");
    DEF(def.struct_size = 8, ARGUMENT, "def.struct_size: is 8; no version");
    DEF(def.struct_size = 0xdeadbeef, ARGUMENT, "def.struct_size");
    DEF(def.shape = 0, ARGUMENT, "def.shape: is 0");
    DEF(def.shape = 77, ARGUMENT, "def.shape: is 77");
    DEF(def.points = NULL, ARGUMENT, "def.points: is null, but its count is 4");
    DEF(def.point_count = 2, ARGUMENT, "def.points: has 2 corners");
    DEF(def.point_count = (size_t)-1, ARGUMENT, "def.points: has 18446744073709551615 corners");
    DEF(def.points = bow_tie, ARGUMENT, "def.points: edge 0 from (0, 0) to (0.05, 0.05) crosses edge 2 from ");
    DEF((def.points = bay, def.shape = JOSTLE_SHAPE_CONVEX_POLYGON), ARGUMENT, "def.points: is not convex");
    DEF((def.points = hole, def.point_count = 3), ARGUMENT, "def.points[1]: is ");
    DEF((def.points = twice, def.point_count = 3), ARGUMENT, "def.points: has 2 corners at places of their own");
    DEF((def.points = line, def.point_count = 3), ARGUMENT, "def.points: ");
    DEF(def.shape = JOSTLE_SHAPE_DISC, ARGUMENT, "def.radius: is 0");
    DEF((def.shape = JOSTLE_SHAPE_DISC, def.radius = NOT_A_NUMBER), ARGUMENT, "def.radius: is ");
    DEF(def.shape = JOSTLE_SHAPE_COMPOUND, ARGUMENT, "def.parts: has 0 parts");
    DEF((def.shape = JOSTLE_SHAPE_COMPOUND, def.part_count = 2), ARGUMENT, "def.parts: is null");
    DEF((def.shape = JOSTLE_SHAPE_COMPOUND, def.parts = parts, def.part_count = 2, parts[1].radius = -1), ARGUMENT,
        "def.parts[1].radius: is -1");
    DEF((def.shape = JOSTLE_SHAPE_COMPOUND, def.parts = parts, def.part_count = 2, parts[1].shape = 4), ARGUMENT,
        "def.parts[1].shape: is 4");
    DEF((def.shape = JOSTLE_SHAPE_COMPOUND, def.parts = parts, def.part_count = 2, parts[1].shape = JOSTLE_SHAPE_DISC,
         parts[0].pose.theta = HUGE_VAL),
        ARGUMENT, "def.parts[0].pose.theta: is inf");
    DEF(def.shape = JOSTLE_SHAPE_BLOCK, ARGUMENT, "def.block: is null");
    DEF((def.shape = JOSTLE_SHAPE_BLOCK, def.block = "brick"), NOT_FOUND, "def.block: no block is named `brick`");
    DEF((def.shape = JOSTLE_SHAPE_BLOCK, def.block = "cube", def.mass = 1), ARGUMENT, "def.mass: is set");
    DEF(def.pose.p.x = NOT_A_NUMBER, ARGUMENT, "def.pose.p.x: is ");
    DEF(def.pose.theta = HUGE_VAL, ARGUMENT, "def.pose.theta: is inf");
    DEF(def.pose.p.y = 1e300, ARGUMENT, "def.pose.p.y: is 1e300; it must lie in -100 to 100 m");
    DEF(def.height = 0, ARGUMENT, "def.height: is 0");
    DEF(def.mass = -0.1, ARGUMENT, "def.mass: is -0.1");
    DEF(def.mass = NOT_A_NUMBER, ARGUMENT, "def.mass: ");
    DEF(def.friction = -1, ARGUMENT, "def.friction: is -1");
    DEF(def.friction = NOT_A_NUMBER, ARGUMENT, "def.friction: ");
    DEF(def.inertia = -1, ARGUMENT, "def.inertia: is -1");
    DEF(def.outline_tolerance = 0.02, ARGUMENT, "def.outline_tolerance: is 0.02");
    DEF(def.outline_tolerance = NOT_A_NUMBER, ARGUMENT, "def.outline_tolerance: ");
    DEF((def.has_centre_of_mass = 1, def.centre_of_mass.x = NOT_A_NUMBER), ARGUMENT, "def.centre_of_mass: ");
    DEF(def.has_centre_of_mass = 2, ARGUMENT, "def.has_centre_of_mass: is 2");
    DEF(def.pickable = 2, ARGUMENT, "def.pickable: is 2");
    DEF(def.pushable = 2, ARGUMENT, "def.pushable: is 2");
    DEF(def.present = 2, ARGUMENT, "def.present: is 2");
    DEF(def.name = "target", ARGUMENT, "def.name: `target` is taken");
    DEF(def.name = "\xff", ARGUMENT, "def.name: is not UTF-8");
    if (body.id != 0) exit(1);
}

static void bad_images(jostle_body target)
{
    jostle_body nobody = {0};
    jostle_body foreign = {target.id + (UINT64_C(1) << 32)};
    jostle_image_frame frame, good = {{{0.5, 0}, 0}, 0.002, 8, 8};
    jostle_pixel_map map;
    jostle_camera_image image;
    jostle_image_options options = jostle_image_options_default();
    jostle_seen_body seen[4];
    size_t count = 99;
    static uint8_t labels[64];
    static float heights[64];

#define FRAME(change, message)                                                                                         \
    frame = good;                                                                                                      \
    change;                                                                                                            \
    BAD(jostle_scene_label_image(scene, &frame, labels, 8), ARGUMENT, message);                                        \
    BAD(jostle_scene_height_image(scene, &frame, heights, 32), ARGUMENT, message);                                     \
    BAD(jostle_scene_mask_image(scene, target, &frame, labels, 8), ARGUMENT, message);                                 \
    BAD(jostle_image_frame_map(&frame, &map), ARGUMENT, message)

    FRAME(frame.pixel = 0, "frame.pixel: is 0");
    FRAME(frame.pixel = NOT_A_NUMBER, "frame.pixel: is ");
    FRAME(frame.rows = 0, "frame.rows: is 0");
    FRAME(frame.cols = 16385, "frame.cols: is 16385");
    FRAME(frame.pose.theta = HUGE_VAL, "frame.pose.theta: is inf");
    BAD(jostle_scene_label_image(scene, &good, labels, 7), ARGUMENT, "pixels: row_stride is 7 bytes; a row has 8 pixels");
    BAD(jostle_scene_height_image(scene, &good, heights, 31), ARGUMENT, "pixels: pixels and row_stride must be aligned");
    BAD(jostle_scene_height_image(scene, &good, heights, 28), ARGUMENT, "pixels: row_stride is 28 bytes");
    BAD(jostle_scene_label_image(scene, &good, labels, (size_t)-1), ARGUMENT, "pixels: row_stride is 18446744073709551615");
    BAD(jostle_scene_mask_image(scene, foreign, &good, labels, 8), NOT_FOUND, "body: ");
    BAD(jostle_scene_mask_image(scene, nobody, &good, labels, 8), ARGUMENT, "body: is zero");
    BAD(jostle_scene_frame_around(scene, foreign, 0, 0.002, 8, &frame), NOT_FOUND, "body: ");
    BAD(jostle_scene_frame_around(scene, target, NOT_A_NUMBER, 0.002, 8, &frame), ARGUMENT, "heading: ");
    BAD(jostle_scene_frame_around(scene, target, 0, -1, 8, &frame), ARGUMENT, "pixel: is -1");
    BAD(jostle_scene_frame_around(scene, target, 0, 0.002, 0, &frame), ARGUMENT, "side: is 0");
    BAD(jostle_camera_image_init(&image, 3), ARGUMENT, "size: is 3");
    BAD(jostle_image_options_init(&options, 3), ARGUMENT, "size: is 3");

#define IMAGE(change, want, message)                                                                                   \
    image = jostle_camera_image_default();                                                                             \
    image.rows = image.cols = image.label_stride = 8;                                                                  \
    image.labels = labels, image.heights = heights, image.height_stride = 32;                                          \
    options = jostle_image_options_default();                                                                          \
    change;                                                                                                            \
    BAD(jostle_scene_add_image(scene, &image, &options, seen, 4, &count), want, message);                              \
    BAD(jostle_scene_match_image(scene, &image, &options, seen, 4, &count), want, message)

    IMAGE(image.struct_size = 0, ARGUMENT, "image.struct_size: is 0");
    IMAGE(image.rows = 0, ARGUMENT, "image.rows: is 0");
    IMAGE(image.cols = (size_t)-1, ARGUMENT, "image.cols: is 18446744073709551615");
    IMAGE(image.labels = NULL, ARGUMENT, "image.labels: is null");
    IMAGE(image.masks = labels, ARGUMENT, "image.masks: are given beside labels");
    IMAGE((image.masks = labels, image.labels = NULL), ARGUMENT, "image.mask_count: is 0");
    IMAGE((image.masks = labels, image.labels = NULL, image.mask_count = 1), ARGUMENT, "image.masks: row_stride is 0");
    IMAGE((image.masks = labels, image.labels = NULL, image.mask_count = 1, image.mask_stride = 8,
           image.mask_plane_stride = 63),
          ARGUMENT, "image.mask_plane_stride: is 63 bytes; a mask has 64");
    IMAGE(image.label_stride = 7, ARGUMENT, "image.labels: row_stride is 7");
    IMAGE(image.height_stride = 30, ARGUMENT, "image.heights: pixels and row_stride");
    IMAGE(image.map.column.x = 0, ARGUMENT, "image.map: its columns and rows");
    IMAGE(image.map.origin.y = NOT_A_NUMBER, ARGUMENT, "image.map: is not finite");
    IMAGE(options.struct_size = 0, ARGUMENT, "options.struct_size: is 0");
    IMAGE(options.at_border = 9, ARGUMENT, "options.at_border: is 9");
    IMAGE(options.tolerance = 0, ARGUMENT, "options.tolerance: is 0");
    IMAGE(options.min_area = NOT_A_NUMBER, ARGUMENT, "options.min_area: is ");
    IMAGE(options.height_quantile = 0, ARGUMENT, "options.height_quantile: is 0");
    IMAGE(options.height = -1, ARGUMENT, "options.height: is -1");
    IMAGE(options.mass = 0, ARGUMENT, "options.mass: is 0");
    IMAGE(options.friction = -1, ARGUMENT, "options.friction: is -1");
    IMAGE(options.greatest_cost = -1, ARGUMENT, "options.greatest_cost: is -1");
    IMAGE(options.discs = 3, ARGUMENT, "options.discs: is 3");
    memset(labels, 1, sizeof labels);
    image = jostle_camera_image_default();
    image.rows = image.cols = image.label_stride = 8;
    image.labels = labels;
    options = jostle_image_options_default();
    options.at_border = JOSTLE_BORDER_REFUSE;
    BAD(jostle_scene_add_image(scene, &image, &options, seen, 4, &count), ARGUMENT, "image.labels[1]: reaches");
    options.at_border = JOSTLE_BORDER_KEEP;
    BAD(jostle_scene_add_image(scene, &image, &options, seen, 0, &count), JOSTLE_ERROR_BUFFER, "capacity: is 0; 1 are");
    BAD(jostle_scene_add_image(scene, &image, &options, NULL, 4, &count), ARGUMENT, "buffer: is null, but capacity is 4");
    BAD(jostle_scene_match_image(scene, &image, NULL, seen, 1, &count), JOSTLE_ERROR_BUFFER, "capacity: is 1; 2 are");
    MUST(jostle_scene_add_image(scene, &image, &options, NULL, 0, &count)); /* asks for the count alone */
    if (count != 1) exit(1);
}

static void bad_grasps(jostle_body target, jostle_body foreign)
{
    jostle_grasp good = {{0.5, 0}, 0, 0, 0, 0, 0}, grasp;
    jostle_grasp_report report;
    char text[64];
    size_t count = 0;

#define GRASP(change, want, message)                                                                                   \
    grasp = good;                                                                                                      \
    change;                                                                                                            \
    BAD(jostle_scene_examine_grasp(scene, target, &grasp, &report), want, message);                                    \
    BAD(jostle_scene_explain_grasp(scene, target, &grasp, text, sizeof text, &count), want, message)

    GRASP(grasp.position.x = NOT_A_NUMBER, ARGUMENT, "grasp.position.x: is ");
    GRASP(grasp.position.y = 1e9, ARGUMENT, "grasp.position.y: is 1e9");
    GRASP(grasp.angle = HUGE_VAL, ARGUMENT, "grasp.angle: is inf");
    GRASP(grasp.opening = -0.01, ARGUMENT, "grasp.opening: is -0.01");
    GRASP(grasp.opening = NOT_A_NUMBER, ARGUMENT, "grasp.opening: is ");
#undef GRASP
    BAD(jostle_scene_examine_grasp(scene, foreign, &good, &report), NOT_FOUND, "body: ");
    BAD(jostle_scene_examine_grasp(scene, (jostle_body){0}, &good, &report), ARGUMENT, "body: is zero");
    BAD(jostle_scene_explain_grasp(scene, foreign, &good, text, sizeof text, &count), NOT_FOUND, "body: ");
    BAD(jostle_scene_explain_grasp(scene, target, &good, NULL, 3, &count), ARGUMENT, "buffer: is null");
    BAD(jostle_scene_best_grasps(scene, foreign, 3, &report, 1, &count), NOT_FOUND, "body: ");
    BAD(jostle_scene_best_grasps(scene, target, 0, &report, 1, &count), ARGUMENT, "most: is 0");
    BAD(jostle_scene_best_grasps(scene, target, 3, NULL, 3, &count), ARGUMENT, "buffer: is null");
}

static void bad_scenes(jostle_context *context, jostle_body target, jostle_body other)
{
    jostle_body nobody = {0}, body = nobody;
    jostle_body foreign = {target.id + (UINT64_C(1) << 32)};
    jostle_pose2 pose = {{0.5, 0}, 0};
    jostle_body_pose poses[3] = {{target, {{0.5, 0}, 0}, 1, 0}, {other, {{0.6, 0}, 0}, 1, 0}, {other, {{0.6, 0}, 0}, 1, 0}};
    jostle_gripper gripper = jostle_gripper_default();
    jostle_workspace workspace = jostle_workspace_default();
    char text[2];
    size_t count = 99;
    uint32_t flag = 99;
    jostle_grasp grasp;

    BAD(jostle_scene_remove_body(scene, nobody), ARGUMENT, "body: is zero");
    BAD(jostle_scene_remove_body(scene, foreign), NOT_FOUND, "body: body 0x");
    BAD(jostle_scene_find_body(scene, "nobody", &body), NOT_FOUND, "name: no body of the scene is named `nobody`");
    BAD(jostle_scene_find_body(scene, "\xc3", &body), ARGUMENT, "name: is not UTF-8");
    BAD(jostle_scene_body_name(scene, target, text, sizeof text, &count), JOSTLE_ERROR_BUFFER, "capacity: is 2; 7 are");
    if (count != 7) failures++;
    BAD(jostle_scene_body_name(scene, target, NULL, 3, &count), ARGUMENT, "buffer: is null, but capacity is 3");
    BAD(jostle_scene_body_name(scene, foreign, NULL, 0, &count), NOT_FOUND, "body: ");
    BAD(jostle_scene_set_pose(scene, foreign, &pose), NOT_FOUND, "body: ");
    BAD(jostle_scene_set_pose(scene, nobody, &pose), ARGUMENT, "body: is zero");
    pose.theta = NOT_A_NUMBER;
    BAD(jostle_scene_set_pose(scene, target, &pose), ARGUMENT, "pose.theta: is ");
    BAD(jostle_scene_get_pose(scene, foreign, &pose), NOT_FOUND, "body: ");
    BAD(jostle_scene_set_present(scene, foreign, 1), NOT_FOUND, "body: ");
    BAD(jostle_scene_set_present(scene, target, 7), ARGUMENT, "present: is 7");
    BAD(jostle_scene_get_present(scene, foreign, &flag), NOT_FOUND, "body: ");

    BAD(jostle_scene_update(scene, NULL, 2), ARGUMENT, "poses: is null, but its count is 2");
    BAD(jostle_scene_update(scene, poses, (size_t)-1), ARGUMENT, "poses: its count");
    BAD(jostle_scene_update(scene, poses, 3), ARGUMENT, "poses[2]: names the same body as poses[1]");
    poses[1].pose.p.x = 0.51;
    BAD(jostle_scene_update(scene, poses, 2), ARGUMENT, "poses[1]: `other` overlaps `target` by 30.0 mm");
    poses[1].pose.p.x = NOT_A_NUMBER;
    BAD(jostle_scene_update(scene, poses, 2), ARGUMENT, "poses[1].pose.");
    poses[1].pose.p.x = 0.6;
    poses[1].present = 3;
    BAD(jostle_scene_update(scene, poses, 2), ARGUMENT, "poses[1].present: is 3");
    poses[1].present = 1;
    poses[1].body = foreign;
    BAD(jostle_scene_update(scene, poses, 2), NOT_FOUND, "poses[1].body: body 0x");
    poses[1].body = nobody;
    BAD(jostle_scene_update(scene, poses, 2), ARGUMENT, "poses[1].body: is zero");
    BAD(jostle_scene_poses(scene, poses, 1, &count), JOSTLE_ERROR_BUFFER, "capacity: is 1; 2 are needed");

    gripper.fit = NOT_A_NUMBER;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.fit: ");
    gripper = jostle_gripper_default();
    gripper.push_width = 0;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.push_width: is 0");
    gripper = jostle_gripper_default();
    gripper.grasp_score = 3;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.grasp_score: is 3");
    gripper.grasp_score = JOSTLE_SCORE_OWN;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.grasp_score: is 2, but the scene has no tables");
    gripper = jostle_gripper_default();
    gripper.tip_path = 3;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.tip_path: is 3");
    gripper.tip_path = JOSTLE_TIP_OWN;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.tip_path: is 2, but the scene has no path");
    jostle_tip_path path = jostle_tip_path_default();
    jostle_vec2 level[] = {{0, 0.01}, {0.1, 0.02}}, rise[] = {{0, 0}, {1, 0.05}};
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.sink: has 0 points");
    path.sink_count = 2;
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.sink: is null, but its count is 2");
    path.sink = level, path.rise = rise, path.rise_count = 2;
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.sink[1]: is above the point before");
    path.sink_count = 1, path.rise_count = 1;
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.rise: does not go from [0, 0]");
    path.rise_count = 2, path.shortfall_across = 2;
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.shortfall_across: is 2");
    path.struct_size = 4;
    BAD(jostle_scene_set_tip_path(scene, &path), ARGUMENT, "path.struct_size: is 4");
    gripper.struct_size = 0;
    BAD(jostle_scene_set_gripper(scene, &gripper), ARGUMENT, "gripper.struct_size: is 0");
    BAD(jostle_scene_get_gripper(scene, &gripper), ARGUMENT, "gripper.struct_size: is 0");
    BAD(jostle_gripper_by_name("claw", &gripper), NOT_FOUND, "gripper: no gripper is named `claw`");
    BAD(jostle_gripper_init(&gripper, 3), ARGUMENT, "size: is 3");
    workspace.max.x = workspace.min.x;
    BAD(jostle_scene_set_workspace(scene, &workspace), ARGUMENT, "workspace.x: max");
    workspace = jostle_workspace_default();
    workspace.leave_rule = 9;
    BAD(jostle_scene_set_workspace(scene, &workspace), ARGUMENT, "workspace.leave_rule: is 9");
    workspace.leave_rule = JOSTLE_LEAVE_CENTRE;
    workspace.leave_scope = 9;
    BAD(jostle_scene_set_workspace(scene, &workspace), ARGUMENT, "workspace.leave_scope: is 9");
    workspace.struct_size = 1;
    BAD(jostle_scene_get_workspace(scene, &workspace), ARGUMENT, "workspace.struct_size: is 1");
    BAD(jostle_scene_set_friction(scene, NOT_A_NUMBER, 1), ARGUMENT, "ground: ");
    BAD(jostle_scene_set_friction(scene, 1, -1), ARGUMENT, "tip: is -1");
    BAD(jostle_scene_set_overlap_tolerance(scene, 1), ARGUMENT, "metres: is 1");

    BAD(jostle_scene_best_grasp(scene, foreign, &grasp, &flag), NOT_FOUND, "body: ");
    bad_grasps(target, foreign);
    BAD(jostle_scene_read(context, "no/such/file.json", &new_scene, &body), JOSTLE_ERROR_IO, "no/such/file.json: ");
    write_file("bad_input_empty.json", "");
    BAD(jostle_scene_read(context, "bad_input_empty.json", &new_scene, &body), JOSTLE_ERROR_FORMAT, "bad_input_empty.json: ");
    write_file("bad_input_text.json", "{ \"version\": 1, \"bodies\": 7 }");
    BAD(jostle_scene_read(context, "bad_input_text.json", &new_scene, &body), JOSTLE_ERROR_FORMAT, "bad_input_text.json: ");
    write_file("bad_input_version.json", "{ \"version\": 999 }");
    BAD(jostle_scene_read(context, "bad_input_version.json", &new_scene, &body), JOSTLE_ERROR_FORMAT,
        "bad_input_version.json: version: is 999");
    BAD(jostle_scene_read(context, "\xff", &new_scene, &body), ARGUMENT, "path: is not UTF-8");
    BAD(jostle_scene_write(scene, target, "no/such/folder/file.json"), JOSTLE_ERROR_IO, "no/such/folder/file.json: ");
    BAD(jostle_scene_write(scene, foreign, "never.json"), NOT_FOUND, "target: ");
    BAD(jostle_scene_generate(context, 1, 0, 0, &new_scene, &body), ARGUMENT, "bodies: is 0");
    BAD(jostle_scene_generate(context, 1, 0, 129, &new_scene, &body), ARGUMENT, "bodies: is 129");
#ifndef LIGHT /* it takes long to give up */
    BAD(jostle_scene_generate(context, 1, 0, 128, &new_scene, &body), ARGUMENT, "bodies: found no room");
#endif
    if (body.id || flag != 99) failures++;
}

static void bad_planners(jostle_context *context, jostle_planner *planner, jostle_plan *plan, jostle_body target)
{
    jostle_body nobody = {0}, foreign = {target.id + 77};
    jostle_planner_options options;
    jostle_solve_options solve = jostle_solve_options_default();
    jostle_simulator_options world;
    jostle_execute_options within = jostle_execute_options_default();
    jostle_context_options whole = jostle_context_options_default();
    jostle_plan_statistics statistics = jostle_plan_statistics_default();
    jostle_progress progress = jostle_progress_default();
    jostle_action action;
    double value;
    jostle_scene *other, *clash;
    jostle_body there, fixed, unused;
    jostle_body_def def;
    jostle_simulator *simulator;
    jostle_effect effect = 99;
    size_t count;

    whole.threads = 100000;
    BAD(jostle_context_new(&whole, &new_context), ARGUMENT, "options.threads: is 100000");
    whole.struct_size = 0;
    BAD(jostle_context_new(&whole, &new_context), ARGUMENT, "options.struct_size: is 0");

#define OPTION(change, want, message)                                                                                  \
    options = jostle_planner_options_default();                                                                        \
    change;                                                                                                            \
    BAD(jostle_planner_new(context, &options, &new_planner), want, message)

    OPTION(options.struct_size = 0, ARGUMENT, "options.struct_size: is 0");
    jostle_gripper hand = jostle_gripper_default(), unset = jostle_gripper_default();
    hand.opening = -1;
    unset.struct_size = 0;
    OPTION(options.gripper = &hand, ARGUMENT, "options.gripper.opening: is -1");
    hand = jostle_gripper_default();
    hand.grasp_score = JOSTLE_SCORE_OWN;
    OPTION(options.gripper = &hand, ARGUMENT, "options.gripper.grasp_score: is 2");
    OPTION(options.gripper = &unset, ARGUMENT, "options.gripper.struct_size: is 0");
    OPTION(options.planner = "oracle", NOT_FOUND, "options.planner: no planner is named `oracle`");
    OPTION(options.planner = "\xff", ARGUMENT, "options.planner: is not UTF-8");
    OPTION(options.engine = "newton", NOT_FOUND, "options.engine: no engine is named `newton`");
    OPTION(options.scorer = "dice", NOT_FOUND, "options.scorer: no scorer is named `dice`");
    OPTION(options.scorer_model = (void *)context, JOSTLE_ERROR_HANDLE, "options.scorer_model: is not a live handle");
    OPTION(options.engine_model = (void *)context, JOSTLE_ERROR_HANDLE, "options.engine_model: is not a live handle");
    OPTION(options.preset = "rough", NOT_FOUND, "options.preset: ");
    OPTION(options.max_iterations = 0, ARGUMENT, "options.max_iterations: is 0");
    OPTION(options.max_seconds = 0, ARGUMENT, "options.max_seconds: is 0");
    OPTION(options.max_seconds = -1, ARGUMENT, "options.max_seconds: is -1");
    OPTION(options.max_seconds = NOT_A_NUMBER, ARGUMENT, "options.max_seconds: ");
    OPTION(options.max_bytes = 0, ARGUMENT, "options.max_bytes: is 0");
    OPTION(options.push_length = -1, ARGUMENT, "options.push_length: is -1");
    OPTION(options.push_length = NOT_A_NUMBER, ARGUMENT, "options.push_length: ");
    OPTION(options.execute_score = 1.5, ARGUMENT, "options.execute_score: is 1.5");
    OPTION(options.solved_score = NOT_A_NUMBER, ARGUMENT, "options.solved_score: ");
    OPTION(options.max_depth = 100000, ARGUMENT, "options.max_depth: is 100000");
    OPTION(options.lanes = 100000, ARGUMENT, "options.lanes: is 100000");
    OPTION(options.threads = 100000, ARGUMENT, "options.threads: is 100000");
    OPTION(options.sampler = "dice", NOT_FOUND, "options.sampler: ");
    OPTION(options.variant = 0, ARGUMENT, "options.variant: is 0");

    BAD(jostle_planner_solve(planner, scene, nobody, NULL, &new_plan), ARGUMENT, "target: is zero");
    BAD(jostle_planner_solve(planner, scene, foreign, NULL, &new_plan), NOT_FOUND, "target: body 0x");
    solve.progress_seconds = -1;
    BAD(jostle_planner_solve(planner, scene, target, &solve, &new_plan), ARGUMENT, "options.progress_seconds: is -1");
    BAD(jostle_planner_job_start(planner, scene, target, &solve, &new_job), ARGUMENT, "options.progress_seconds: is -1");
    solve = jostle_solve_options_default();
    solve.cancel = (void *)scene;
    BAD(jostle_planner_solve(planner, scene, target, &solve, &new_plan), JOSTLE_ERROR_HANDLE, "options.cancel: ");
    solve.struct_size = 0;
    BAD(jostle_planner_solve(planner, scene, target, &solve, &new_plan), ARGUMENT, "options.struct_size: is 0");
    BAD(jostle_planner_step(planner, scene, target, 0, NULL, &new_plan), ARGUMENT, "iterations: is 0");
    BAD(jostle_planner_step(planner, scene, foreign, 1, NULL, &new_plan), NOT_FOUND, "target: ");
    BAD(jostle_planner_job_start(planner, scene, nobody, NULL, &new_job), ARGUMENT, "target: is zero");
    progress.struct_size = 0;
    BAD(jostle_planner_progress(planner, &progress), ARGUMENT, "progress.struct_size: is 0");

    memset(&action, 0, sizeof action);
    BAD(jostle_planner_advance(planner, &action, NULL), ARGUMENT, "action.kind: is 0");
    action.kind = JOSTLE_ACTION_PUSH;
    action.push.end.y = NOT_A_NUMBER;
    BAD(jostle_planner_advance(planner, &action, NULL), ARGUMENT, "action.push.end: is ");
    BAD(jostle_planner_failed(planner, &action), ARGUMENT, "action.push.end: is ");

    /* Scenes that cannot be planned with: empty, overlapping, target absent, target not pickable. */
    MUST(jostle_scene_new(context, &other));
    BAD(jostle_scene_check(other), ARGUMENT, "bodies: the scene has no bodies");
    BAD(jostle_planner_solve(planner, other, target, NULL, &new_plan), NOT_FOUND, "target: ");
    def = square(0.5, 0);
    MUST(jostle_scene_add_body(other, &def, &there));
    def = square(0.6, 0);
    def.pickable = 0;
    MUST(jostle_scene_add_body(other, &def, &fixed));
    BAD(jostle_planner_solve(planner, other, fixed, NULL, &new_plan), ARGUMENT, "target: `body 1` is not pickable");
    MUST(jostle_scene_set_present(other, there, 0));
    BAD(jostle_planner_solve(planner, other, there, NULL, &new_plan), ARGUMENT, "target: `body 0` is not present");
    BAD(jostle_simulator_new(context, other, there, NULL, &new_simulator), ARGUMENT, "target: `body 0` is not present");
    MUST(jostle_scene_clone(other, &clash));
    MUST(jostle_scene_set_present(clash, there, 1));
    def = square(0.51, 0.01);
    MUST(jostle_scene_add_body(clash, &def, &unused));
    BAD(jostle_scene_check(clash), ARGUMENT, "poses[2]: `body 2` overlaps `body 0`");
    BAD(jostle_planner_solve(planner, clash, there, NULL, &new_plan), ARGUMENT, "poses[2]: ");
    BAD(jostle_planner_step(planner, clash, there, 1, NULL, &new_plan), ARGUMENT, "poses[2]: ");
    BAD(jostle_planner_job_start(planner, clash, there, NULL, &new_job), ARGUMENT, "poses[2]: ");
    BAD(jostle_simulator_new(context, clash, there, NULL, &new_simulator), ARGUMENT, "poses[2]: ");
    BAD(jostle_scene_write(clash, there, "never.json"), ARGUMENT, "poses[2]: ");
    jostle_scene_free(clash);
    jostle_scene_free(other);

    BAD(jostle_plan_action(plan, 1000, &action), NOT_FOUND, "index: is 1000");
    BAD(jostle_plan_value(plan, 1000, &value), NOT_FOUND, "index: is 1000");
    BAD(jostle_plan_predicted(plan, 1000, NULL, 0, &count), NOT_FOUND, "index: is 1000");
    BAD(jostle_plan_waypoints(plan, 1000, NULL, 0, &count), NOT_FOUND, "index: is 1000");
    BAD(jostle_plan_waypoints(plan, 0, NULL, 0, &count), NOT_FOUND, "index: pushes and grasps have no waypoints");
    BAD(jostle_plan_cost(plan, &value, NULL), NOT_FOUND, "plan: only a rearrangement's has a cost");
    BAD(jostle_plan_json(plan, (char *)&value, 1, &count), JOSTLE_ERROR_BUFFER, "capacity: is 1");
    statistics.struct_size = 0;
    BAD(jostle_plan_get_statistics(plan, &statistics), ARGUMENT, "statistics.struct_size: is 0");

#define WORLD(change, want, message)                                                                                   \
    world = jostle_simulator_options_default();                                                                        \
    change;                                                                                                            \
    BAD(jostle_simulator_new(context, scene, target, &world, &new_simulator), want, message)

    WORLD(world.struct_size = 0, ARGUMENT, "options.struct_size: is 0");
    WORLD(world.engine = "newton", NOT_FOUND, "options.engine: ");
    WORLD(world.executor = 2, ARGUMENT, "options.executor: is 2");
    WORLD((world.executor = JOSTLE_EXECUTOR_ROBOT, world.engine = "rapier"), ARGUMENT, "options.engine: is `rapier`");
    WORLD(world.preset = "rough", NOT_FOUND, "options.preset: ");
    WORLD(world.friction_spread = NOT_A_NUMBER, ARGUMENT, "options.friction_spread: ");
    WORLD(world.position_noise = -1, ARGUMENT, "options.position_noise: is -1");
    WORLD(world.angle_noise = 3, ARGUMENT, "options.angle_noise: is 3");
    BAD(jostle_simulator_new(context, scene, foreign, NULL, &new_simulator), NOT_FOUND, "target: ");
    MUST(jostle_simulator_new(context, scene, target, NULL, &simulator));
    memset(&action, 0, sizeof action);
    action.kind = 5;
    BAD(jostle_simulator_execute(simulator, &action, &effect), ARGUMENT, "action.kind: is 5");
    action.kind = JOSTLE_ACTION_GRASP;
    BAD(jostle_simulator_execute(simulator, &action, &effect), ARGUMENT, "action.body: is zero");
    action.body = foreign;
    BAD(jostle_simulator_execute(simulator, &action, &effect), NOT_FOUND, "action.body: ");
    action.body = target;
    action.grasp.opening = NOT_A_NUMBER;
    BAD(jostle_simulator_execute(simulator, &action, &effect), ARGUMENT, "action.grasp.opening: is ");
    action.kind = JOSTLE_ACTION_PUSH;
    action.push.start.x = HUGE_VAL;
    BAD(jostle_simulator_execute(simulator, &action, &effect), ARGUMENT, "action.push.start: is ");
    action.push.start.x = 0.4;
    within.max_seconds = 0;
    BAD(jostle_simulator_execute_within(simulator, &action, &within, &effect), ARGUMENT, "options.max_seconds: is 0");
    within.max_seconds = NOT_A_NUMBER;
    BAD(jostle_simulator_execute_within(simulator, &action, &within, &effect), ARGUMENT, "options.max_seconds: ");
    within.struct_size = 0;
    BAD(jostle_simulator_execute_within(simulator, &action, &within, &effect), ARGUMENT, "options.struct_size: is 0");
    BAD(jostle_simulator_observe(simulator, NULL, 1, &count), ARGUMENT, "buffer: is null, but capacity is 1");
    BAD(jostle_simulator_poses(simulator, (void *)&action, 1, &count), JOSTLE_ERROR_BUFFER, "capacity: is 1; 2 are");
    jostle_simulator_free(simulator);
    if (effect != 99) failures++;
}

/* Goals that cannot be used, scenes whose goals do not fit, and planners given the other kind of problem. */
static void bad_clearings(jostle_context *context, jostle_body target)
{
    jostle_planner_options options = jostle_planner_options_default();
    jostle_planner *clearer = NULL;
    options.planner = "greedy";
    options.preset = "rough";
    BAD(jostle_planner_new(context, &options, &new_planner), NOT_FOUND, "options.preset: ");
    options.preset = NULL;
    options.push_length = 7;
    BAD(jostle_planner_new(context, &options, &new_planner), ARGUMENT, "options.push_length: is 7");
    options.push_length = 0;
    MUST(jostle_planner_new(context, &options, &clearer));
    BAD(jostle_planner_solve(clearer, scene, target, NULL, &new_plan), ARGUMENT, "target: is a body; a planner that");
    jostle_planner_free(clearer);
}

static void bad_rearrangements(jostle_context *context, jostle_planner *planner, jostle_body target)
{
    jostle_planner_options options = jostle_planner_options_default();
    jostle_planner *mover;
    jostle_scene *table;
    jostle_body nobody = {0}, a, b;
    jostle_body_def def;
    jostle_action action;
    jostle_goal goal;

#define GOAL(change, want, message)                                                                                    \
    goal = jostle_goal_default();                                                                                      \
    change;                                                                                                            \
    BAD(jostle_scene_set_goal(scene, target, &goal), want, message)

    GOAL(goal.struct_size = 0, ARGUMENT, "goal.struct_size: is 0");
    GOAL(goal.pose.theta = NOT_A_NUMBER, ARGUMENT, "goal.pose.theta: is ");
    GOAL(goal.symmetry = 65, ARGUMENT, "goal.symmetry: is 65");
    GOAL(goal.position_tolerance = -1, ARGUMENT, "goal.position_tolerance: is -1");
    GOAL(goal.rotation_tolerance = HUGE_VAL, ARGUMENT, "goal.rotation_tolerance: is inf");
    goal = jostle_goal_default();
    BAD(jostle_scene_set_goal(scene, nobody, &goal), ARGUMENT, "body: is zero");
    BAD(jostle_scene_get_goal(scene, target, &goal), NOT_FOUND, "goal: the body has none");
    goal.struct_size = 0;

    options.planner = "hbfs";
    options.max_iterations = 1;
    MUST(jostle_planner_new(context, &options, &mover));
    BAD(jostle_planner_solve(mover, scene, target, NULL, &new_plan), ARGUMENT, "target: is a body; a planner of");
    BAD(jostle_planner_solve(mover, scene, nobody, NULL, &new_plan), ARGUMENT, "scene: no body has a goal");
    BAD(jostle_planner_job_start(mover, scene, nobody, NULL, &new_job), ARGUMENT, "scene: no body has a goal");

    MUST(jostle_scene_new(context, &table));
    def = square(0.4, 0);
    MUST(jostle_scene_add_body(table, &def, &a));
    def = square(0.6, 0);
    MUST(jostle_scene_add_body(table, &def, &b));
    goal = jostle_goal_default();
    goal.pose.p.x = 0.5;
    MUST(jostle_scene_set_goal(table, a, &goal));
    MUST(jostle_scene_set_goal(table, b, &goal));
    BAD(jostle_planner_solve(mover, table, nobody, NULL, &new_plan), ARGUMENT, "goals[1]: `body 1` overlaps `body 0`");
    BAD(jostle_scene_write(table, nobody, "never.json"), ARGUMENT, "goals[1]: ");
    goal.pose.p.x = 0.72;
    MUST(jostle_scene_set_goal(table, b, &goal));
    BAD(jostle_planner_step(mover, table, nobody, 1, NULL, &new_plan), ARGUMENT, "goals[1]: `body 1` reaches");
    MUST(jostle_scene_set_goal(table, b, NULL));
    BAD(jostle_scene_get_goal(table, b, &goal), NOT_FOUND, "goal: the body has none");

    memset(&action, 0, sizeof action);
    action.kind = JOSTLE_ACTION_DRAG;
    BAD(jostle_planner_advance(planner, &action, NULL), ARGUMENT, "action.kind: is a move of a rearrangement");
    BAD(jostle_planner_advance(mover, &action, NULL), ARGUMENT, "action.body: is zero");
    action.kind = JOSTLE_ACTION_PUSH;
    BAD(jostle_planner_advance(mover, &action, NULL), ARGUMENT, "action.kind: is 1; a rearrangement has moves only");
    BAD(jostle_planner_failed(mover, &action), ARGUMENT, "action.kind: is 1; a rearrangement has moves only");
    jostle_scene_free(table);
    jostle_planner_free(mover);
}

/* Networks that are none; tests/capi/models.c has files that a check refuses. */
static void bad_models(jostle_context *context)
{
    jostle_model_options options;
    size_t length;

#define MODEL(change, want, message)                                                                                   \
    options = jostle_model_options_default();                                                                          \
    change;                                                                                                            \
    BAD(jostle_model_load(context, "never.onnx", NULL, &options, &new_model), want, message)

    MODEL(options.struct_size = 0, ARGUMENT, "options.struct_size: is 0");
    MODEL(options.device = -2, ARGUMENT, "options.device: is -2");
    MODEL(options.self_test = 2, ARGUMENT, "options.self_test: is 2");
    MODEL(options.tolerate = 9, ARGUMENT, "options.tolerate: is 9");
    MODEL(options.backend = "abacus", NOT_FOUND, "options.backend: no backend is named `abacus`");
    MODEL(options.runtime = "\xff", ARGUMENT, "options.runtime: is not UTF-8");
    MODEL(options.threads = 1, NOT_FOUND, "never.onnx: there is no such file");
    BAD(jostle_model_load(context, "never", NULL, NULL, &new_model), NOT_FOUND, "name: no built-in network is named");
    BAD(jostle_model_load(context, "never.onnx", "cat", NULL, &new_model), NOT_FOUND, "kind: no kind of network is");
    BAD(jostle_runtime_info(NULL, 0, NULL), ARGUMENT, "length: is null");
    BAD(jostle_model_options_init(NULL, sizeof options), ARGUMENT, "options: is null");
    BAD(jostle_model_info(NULL, NULL, 0, &length), ARGUMENT, "model: is null");
}

int main(void)
{
    jostle_context *context, *dead_context;
    jostle_scene *dead_scene;
    jostle_planner *planner, *dead_planner;
    jostle_job *job, *dead_job;
    jostle_plan *plan, *dead_plan;
    jostle_cancel *cancel, *dead_cancel;
    jostle_simulator *simulator, *dead_simulator;
    /* Of the right type, and never made: making one needs a runtime. */
    jostle_model *model = NULL, *dead_model = (jostle_model *)(uintptr_t)0x3e700000011u;
    jostle_body target, other;

    jostle_context_options good_jostle_context_options = jostle_context_options_default();
    jostle_body_def good_jostle_body_def = square(0.5, 0.15), def;
    jostle_gripper good_jostle_gripper = jostle_gripper_default();
    jostle_workspace good_jostle_workspace = jostle_workspace_default();
    jostle_planner_options good_jostle_planner_options = jostle_planner_options_default();
    jostle_solve_options good_jostle_solve_options = jostle_solve_options_default();
    jostle_body_info good_jostle_body_info;
    jostle_tip_path good_jostle_tip_path = jostle_tip_path_default();
    jostle_goal good_jostle_goal = jostle_goal_default();
    jostle_progress good_jostle_progress = jostle_progress_default();
    jostle_plan_statistics good_jostle_plan_statistics = jostle_plan_statistics_default();
    jostle_simulator_options good_jostle_simulator_options = jostle_simulator_options_default();
    jostle_execute_options good_jostle_execute_options = jostle_execute_options_default();
    jostle_model_options good_jostle_model_options = jostle_model_options_default();
    jostle_pose2 good_jostle_pose2 = {{0.5, 0.1}, 0};
    jostle_image_frame good_jostle_image_frame = {{{0.5, 0.0}, 0}, 0.002, 8, 8};
    jostle_pixel_map good_jostle_pixel_map = {{0, 0}, {0.002, 0}, {0, 0.002}};
    jostle_camera_image good_jostle_camera_image = jostle_camera_image_default();
    jostle_image_options good_jostle_image_options = jostle_image_options_default();
    jostle_seen_body good_jostle_seen_body;
    uint8_t good_labels[64] = {0};
    float good_heights[64] = {0};
    jostle_body good_jostle_body = {0};
    jostle_body_pose poses[64], good_jostle_body_pose;
    jostle_action good_jostle_action;
    jostle_ranked_action good_jostle_ranked_action;
    jostle_grasp good_jostle_grasp = {{0.5, 0}, 0, 0, 0, 0, 0};
    jostle_grasp_report good_jostle_grasp_report;
    jostle_outcome good_jostle_outcome;
    jostle_effect good_jostle_effect;
    jostle_job_state good_jostle_job_state;
    size_t good_count;
    uint64_t good_u64;
    uint32_t good_u32;
    double good_double;
    char text[64];

    if (jostle_abi_check(JOSTLE_ABI_VERSION) != JOSTLE_OK) return 1;
    MUST(jostle_context_new(NULL, &context));
    MUST(jostle_scene_new(context, &scene));
    def = square(0.5, 0);
    def.name = "target";
    MUST(jostle_scene_add_body(scene, &def, &target));
    def = square(0.6, 0);
    def.name = "other";
    MUST(jostle_scene_add_body(scene, &def, &other));
    MUST(jostle_scene_hash(scene, &scene_hash));
    good_jostle_planner_options.max_iterations = 1;
    MUST(jostle_planner_new(context, &good_jostle_planner_options, &planner));
    MUST(jostle_planner_solve(planner, scene, target, NULL, &plan));
    MUST(jostle_planner_job_start(planner, scene, target, NULL, &job));
    MUST(jostle_job_wait(job, HUGE_VAL, &good_jostle_job_state));
    if (good_jostle_job_state != JOSTLE_JOB_DONE) return 1;
    MUST(jostle_cancel_new(context, &cancel));
    MUST(jostle_simulator_new(context, scene, target, NULL, &simulator));
    good_jostle_camera_image.rows = good_jostle_camera_image.cols = good_jostle_camera_image.label_stride = 8;
    good_jostle_camera_image.labels = good_labels;
    memset(&good_jostle_body_pose, 0, sizeof good_jostle_body_pose);
    good_jostle_body_pose.body = target;
    memset(&good_jostle_action, 0, sizeof good_jostle_action);
    good_jostle_action.kind = JOSTLE_ACTION_PUSH;

    /* Handles that were freed. */
    MUST(jostle_context_new(NULL, &dead_context));
    jostle_context_free(dead_context);
    MUST(jostle_scene_new(context, &dead_scene));
    jostle_scene_free(dead_scene);
    MUST(jostle_planner_new(context, NULL, &dead_planner));
    jostle_planner_free(dead_planner);
    MUST(jostle_planner_job_start(planner, scene, target, NULL, &dead_job));
    jostle_job_free(dead_job);
    MUST(jostle_planner_solve(planner, scene, target, NULL, &dead_plan));
    jostle_plan_free(dead_plan);
    MUST(jostle_cancel_new(context, &dead_cancel));
    jostle_cancel_free(dead_cancel);
    MUST(jostle_simulator_new(context, scene, target, NULL, &dead_simulator));
    jostle_simulator_free(dead_simulator);
    /* Freeing twice and freeing null are safe. */
    jostle_context_free(dead_context), jostle_scene_free(dead_scene), jostle_planner_free(dead_planner);
    jostle_job_free(dead_job), jostle_plan_free(dead_plan), jostle_cancel_free(dead_cancel);
    jostle_simulator_free(dead_simulator);
    jostle_context_free(NULL), jostle_scene_free(NULL), jostle_planner_free(NULL), jostle_job_free(NULL);
    jostle_plan_free(NULL), jostle_cancel_free(NULL), jostle_simulator_free(NULL), jostle_model_free(NULL);
    jostle_model_free(dead_model);

#include "bad_input_calls.h"
    BAD(jostle_abi_check(JOSTLE_ABI_VERSION + 1), JOSTLE_ERROR_ABI, "version: is 1");
    BAD(jostle_job_wait(job, -1, NULL), ARGUMENT, "seconds: is -1");
    BAD(jostle_job_wait(job, NOT_A_NUMBER, NULL), ARGUMENT, "seconds: is ");
    good_jostle_progress.struct_size = 0;
    BAD(jostle_job_poll(job, NULL, &good_jostle_progress), ARGUMENT, "progress.struct_size: is 0");
    jostle_plan *taken;
    MUST(jostle_job_take_plan(job, &taken));
    BAD(jostle_job_take_plan(job, &new_plan), JOSTLE_ERROR_STATE, "job: its plan was taken");
    jostle_plan_free(taken);
    bad_bodies();
    bad_scenes(context, target, other);
    bad_images(target);
    bad_planners(context, planner, plan, target);
    bad_rearrangements(context, planner, target);
    bad_models(context);
    bad_clearings(context, target);

    /* What cannot fail says something for everything. */
    if (!jostle_version()[0] || !jostle_build_info()[0] || jostle_version_number() != JOSTLE_VERSION_NUMBER) failures++;
    if (jostle_abi_version() != JOSTLE_ABI_VERSION || jostle_feature(-5) != 0) failures++;
    if (strcmp(jostle_status_name(12345), "unknown status") || strcmp(jostle_outcome_name(0), "unknown outcome")) failures++;
    if (strcmp(jostle_effect_name(-1), "unknown effect")) failures++;
    if (strcmp(jostle_grasp_limit_name(0), "unknown limit")) failures++;

    /* Everything is as usable as before. */
    MUST(jostle_scene_check(scene));
    jostle_plan *again;
    MUST(jostle_planner_solve(planner, scene, target, NULL, &again));
    jostle_plan_free(again);
    /* Parents first: children hold on to what they need. */
    jostle_context_free(context), jostle_scene_free(scene), jostle_planner_free(planner), jostle_job_free(job);
    jostle_plan_free(plan), jostle_cancel_free(cancel), jostle_simulator_free(simulator);
    if (jostle_handle_count() != 0) {
        printf("%llu handles are left\n", (unsigned long long)jostle_handle_count());
        failures++;
    }
    if (failures) {
        printf("%lu failures\n", failures);
        return 1;
    }
    puts("bad input: all refused");
    return 0;
}
