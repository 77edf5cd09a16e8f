/*
 * Retrieve a block that is known from camera images alone: each time the scene is made anew of a label image and a height
 * image, a plan is made in it, and its first action is executed.
 *
 * Camera and robot here are the library's own; on a real one, replace see() by your segmentation and your depth camera
 * (any origin, axes and row strides will do) and execute() by your drivers.
 *
 *   cc -std=c11 -Iinclude examples_c/camera_scene.c -Ltarget/release -ljostle -lm
 */
#include <jostle/jostle.h>

#include <math.h>
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
#define SIDE 224       /* pixels of 2 mm: 0.448 m */
#define ROW (SIDE + 8) /* rows may be padded */
#define TARGET 1       /* its label: the segmentation keeps it from image to image */

/* What lies on the table, which only the camera and the robot know. Metres and radians. */
static const struct {
    const char *block;
    jostle_pose2 pose;
} table[BODIES] = {
    {"cube", {{0.500, 0.000}, 0.0}}, /* between four others: no finger fits in */
    {"cube", {{0.500, 0.047}, 0.0}},
    {"cube", {{0.500, -0.047}, 0.0}},
    {"rect", {{0.454, 0.000}, 0.0}},
    {"half_cube", {{0.535, 0.000}, 0.0}},
};

static uint8_t labels[SIDE * ROW];
static float heights[SIDE * ROW];

/* Takes the images. */
static jostle_status see(const jostle_scene *world, jostle_camera_image *image)
{
    const jostle_image_frame frame = {{{0.5, 0.0}, 0.0}, 0.002, SIDE, SIDE};
    jostle_status status;
    *image = jostle_camera_image_default();
    image->rows = image->cols = SIDE;
    image->labels = labels, image->label_stride = ROW;
    image->heights = heights, image->height_stride = ROW * sizeof heights[0];
    if ((status = jostle_image_frame_map(&frame, &image->map)) != JOSTLE_OK) return status;
    if ((status = jostle_scene_label_image(world, &frame, labels, ROW)) != JOSTLE_OK) return status;
    return jostle_scene_height_image(world, &frame, heights, ROW * sizeof heights[0]);
}

int main(void)
{
    jostle_context *context = NULL;
    jostle_scene *world = NULL, *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_simulator *robot = NULL;
    jostle_plan *plan = NULL;
    jostle_body blocks[BODIES];
    jostle_body_pose truth[BODIES];
    jostle_camera_image image;
    jostle_seen_body seen[BODIES];
    size_t count;
    int retrieved = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));

    TRY(jostle_scene_new(context, &world));
    for (int i = 0; i < BODIES; i++) {
        jostle_body_def def = jostle_body_def_default();
        def.shape = JOSTLE_SHAPE_BLOCK;
        def.block = table[i].block;
        def.pose = table[i].pose;
        TRY(jostle_scene_add_body(world, &def, &blocks[i]));
    }
    TRY(jostle_simulator_new(context, world, blocks[TARGET - 1], NULL, &robot));

    jostle_planner_options options = jostle_planner_options_default();
    options.seed = 1;
    options.max_iterations = 300; /* a limit of iterations: the same plans on every run */
    TRY(jostle_planner_new(context, &options, &planner));

    for (int i = 1; i <= MOST_ACTIONS && !retrieved; i++) {
        jostle_action decided, action;
        jostle_effect effect;
        jostle_body target = {0};

        /* A scene of what is seen, and the target in it. */
        TRY(see(world, &image));
        TRY(jostle_scene_new(context, &scene));
        TRY(jostle_scene_add_image(scene, &image, NULL, seen, BODIES, &count));
        for (size_t k = 0; k < count; k++) {
            if (seen[k].label == TARGET) target = seen[k].body;
        }
        printf("%2d  %u bodies seen\n", i, (unsigned)count);

        TRY(jostle_planner_solve(planner, scene, target, NULL, &plan));
        TRY(jostle_plan_action_count(plan, &count));
        if (count == 0) {
            puts("    nothing to do");
            break;
        }
        TRY(jostle_plan_action(plan, 0, &decided));
        action = decided;
        /* The robot knows its bodies by the names of its own scene. */
        for (int k = 0; k < BODIES; k++) {
            if (action.body.id != 0 && JOSTLE_BODY_EQ(action.body, seen[k].body)) {
                action.body = blocks[seen[k].label - 1];
                break;
            }
        }
        TRY(jostle_simulator_execute(robot, &action, &effect));
        printf("    %s  %s\n", action.kind == JOSTLE_ACTION_PUSH ? "push " : "grasp", jostle_effect_name(effect));
        retrieved = effect == JOSTLE_EFFECT_GRASPED && JOSTLE_BODY_EQ(action.body, blocks[TARGET - 1]);

        /* What failed is not offered again, though the next look makes another scene. */
        if (effect == JOSTLE_EFFECT_PUSHED || effect == JOSTLE_EFFECT_TOPPLED || retrieved) {
            TRY(jostle_planner_advance(planner, &decided, NULL));
        } else {
            TRY(jostle_planner_failed(planner, &decided));
        }

        TRY(jostle_simulator_observe(robot, truth, BODIES, &count));
        TRY(jostle_scene_update(world, truth, count));
        jostle_plan_free(plan);
        plan = NULL;
        jostle_scene_free(scene);
        scene = NULL;
    }

    /* Where the shapes are known (as in `world`), their poses are found more exactly, whatever the labels say. */
    TRY(see(world, &image));
    TRY(jostle_scene_match_image(world, &image, NULL, seen, BODIES, &count));
    double worst = 0;
    for (size_t k = 0; k < count; k++) {
        double nearest = HUGE_VAL; /* of equal blocks any may be found at a place */
        for (int j = 0; j < BODIES; j++) {
            double off = hypot(seen[k].pose.p.x - truth[j].pose.p.x, seen[k].pose.p.y - truth[j].pose.p.y);
            if (truth[j].present && off < nearest) nearest = off;
        }
        if (seen[k].seen != JOSTLE_SEEN_BODY || nearest > worst) worst = nearest;
    }
    printf("%u blocks matched, %s\n", (unsigned)count, worst < 2e-3 ? "all within a pixel" : "some farther off");
    puts(retrieved ? "retrieved" : "not retrieved");

done: /* in any order; null is fine */
    jostle_plan_free(plan);
    jostle_simulator_free(robot);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_scene_free(world);
    jostle_context_free(context);
    return retrieved ? 0 : 1;
}
