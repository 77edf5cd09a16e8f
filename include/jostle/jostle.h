/*
 * jostle: planning for robots that work in clutter. The C API.
 *
 * This file is generated from src/ffi; do not edit it. The rules that hold for all functions are in docs/c-api.md:
 *
 * - Every call that can fail returns a jostle_status: JOSTLE_OK or a negative JOSTLE_ERROR_ number. Then
 *   jostle_last_error() says which field is wrong, why, and what to change. After a failure outputs that are pointers
 *   are null, other outputs and all objects are as they were.
 * - Outcomes of planning are not errors: see JOSTLE_OUTCOME_.
 * - Options begin with jostle_..._default(), which sets struct_size.
 * - const jostle_x * may be used by several threads at once ("shared use"), jostle_x * by one at a time ("exclusive
 *   use"). A call that breaks this returns JOSTLE_ERROR_BUSY; it is never undefined behaviour.
 * - Handles are freed in any order; a freed handle is found out and refused.
 * - SI units, radians, right-handed axes; booleans are uint32_t, 0 or 1; texts are UTF-8.
 *
 * Each function says: Thread (which threads may call it), RT (whether a real-time thread may: no waiting, and no memory
 * taken when it succeeds), Nullable (parameters that may be null), Owns (who frees what), Errors (statuses it returns).
 */

#ifndef JOSTLE_JOSTLE_H
#define JOSTLE_JOSTLE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/// Version of the binary interface: the number at the end of the shared library's name (soname). It rises only when
/// programs have to be compiled again.
#define JOSTLE_ABI_VERSION 0

/// The engine `rapier`.
#define JOSTLE_FEATURE_RAPIER 1

/// The engine `bullet`.
#define JOSTLE_FEATURE_BULLET 2

/// Trained networks are built in. Files can be loaded in any build, where there is a runtime.
#define JOSTLE_FEATURE_NETWORKS 3

/// The engine `planar`.
#define JOSTLE_FEATURE_PLANAR 4

/// The engine `prism`.
#define JOSTLE_FEATURE_PRISM 5

/// A call failed.
#define JOSTLE_LOG_ERROR 1

/// Something is unusual and probably not meant.
#define JOSTLE_LOG_WARNING 2

/// What was done, a line per decision.
#define JOSTLE_LOG_INFO 4

/// Every message.
#define JOSTLE_LOG_ALL 4294967295

/// Two grasps of a list are at least so far apart, metres, or their closing directions JOSTLE_GRASPS_TURNED. For a gripper
/// of another size than robotiq_2f85 the distance grows with it.
#define JOSTLE_GRASPS_APART 0.010

/// Two grasps of a list are JOSTLE_GRASPS_APART from each other, or their closing directions differ at least by this, radians.
#define JOSTLE_GRASPS_TURNED 0.35

/// `jostle_progress.solution_actions` while no solution is known.
#define JOSTLE_NO_SOLUTION 4294967295

/// Networks run on the processor.
#define JOSTLE_DEVICE_CPU (-1)

/// No limit of iterations or bytes.
#define JOSTLE_NO_LIMIT 18446744073709551615ull

/// As many threads as the context's options say.
#define JOSTLE_THREADS_OF_CONTEXT 4294967295

/// `no_plan_within` where nothing is known.
#define JOSTLE_UNKNOWN 4294967295

/// A flag that asks decisions to end; one may serve many decisions, at once or one after the other. Opaque.
typedef struct jostle_cancel jostle_cancel;

/// What all other objects are made from: logging and defaults. Opaque.
typedef struct jostle_context jostle_context;

/// A decision that runs in the background, on a thread of its own. Opaque.
typedef struct jostle_job jostle_job;

/// A network that is ready to run. It does not change and may be used by any number of planners. Opaque.
typedef struct jostle_model jostle_model;

/// The answer of a planner. It never changes. Opaque.
typedef struct jostle_plan jostle_plan;

/// Decides what a robot does next: options in, plans out, a search tree kept between decisions. Opaque.
typedef struct jostle_planner jostle_planner;

/// What a robot knows of its table: bodies and where they are, gripper, workspace, friction. Opaque.
typedef struct jostle_scene jostle_scene;

/// A world to try plans in. It may differ from the planner's model as a real table does. Opaque.
typedef struct jostle_simulator jostle_simulator;

/// What a call returns: 0 or one of the negative `JOSTLE_ERROR_` numbers. Numbers are never given a new meaning.
typedef int32_t jostle_status;

/// One message of the library. Made by the library, valid during the callback.
typedef struct jostle_log_message {
  /// Size of the struct as the library knows it; later versions append.
  uint32_t struct_size;
  /// One of JOSTLE_LOG_ERROR, JOSTLE_LOG_WARNING, JOSTLE_LOG_INFO.
  uint32_t level;
  /// The function of the API that the message comes from.
  const char *function;
  /// UTF-8.
  const char *text;
} jostle_log_message;

/// Receives messages. It may be called from every thread that calls the library and from jobs' threads, from several
/// at once; no lock is held. It must not throw or longjmp.
typedef void (*jostle_log_callback)(const struct jostle_log_message *message, void *user);

/// Settings that all objects of a context share.
typedef struct jostle_context_options {
  /// Set by jostle_context_options_default().
  uint32_t struct_size;
  /// Worker threads of each planner that does not say otherwise; 0 runs everything on the caller (the default).
  uint32_t threads;
  /// Receives messages; null for none (the default).
  jostle_log_callback log_callback;
  /// Passed to `log_callback`; must stay usable until the context and all objects made from it are freed.
  void *log_user;
  /// Which messages: JOSTLE_LOG_ values, or-ed. Errors and warnings by default.
  uint32_t log_mask;
  /// 0.
  uint32_t reserved;
} jostle_context_options;

/// What a shape is: one of the JOSTLE_SHAPE_ values.
typedef int32_t jostle_shape;

/// A point or a vector in the plane, metres. Frozen: never changes.
typedef struct jostle_vec2 {
  double x;
  double y;
} jostle_vec2;

/// Position (metres) and heading (radians, counter-clockwise from +x) of a body. Frozen: never changes.
typedef struct jostle_pose2 {
  struct jostle_vec2 p;
  double theta;
} jostle_pose2;

/// A part of a compound shape. Frozen: never changes.
typedef struct jostle_shape_part {
  /// JOSTLE_SHAPE_POLYGON, JOSTLE_SHAPE_CONVEX_POLYGON or JOSTLE_SHAPE_DISC.
  jostle_shape shape;
  /// 0.
  uint32_t reserved;
  /// In the body frame, each coordinate in -10 to 10 m.
  struct jostle_pose2 pose;
  /// Corners of a polygon, metres: 3 to 4096 corners, each coordinate in -10 to 10 m.
  const struct jostle_vec2 *points;
  size_t point_count;
  /// Of a disc, 6e-4 to 10 m.
  double radius;
} jostle_shape_part;

/// A body: an upright prism on the table. SI units. Everything it points to is copied.
typedef struct jostle_body_def {
  /// Set by jostle_body_def_default().
  uint32_t struct_size;
  /// JOSTLE_SHAPE_POLYGON by default.
  jostle_shape shape;
  /// Where it is at first: (0, 0, 0) by default. Like every pose in the world, x and y lie in -100 to 100 m (poses are
  /// stored in single precision: put the origin near the workspace) and theta in -1e6 to 1e6 rad.
  struct jostle_pose2 pose;
  /// Corners of a polygon in the body frame, metres: 3 to 4096 corners, each coordinate in -10 to 10 m.
  const struct jostle_vec2 *points;
  size_t point_count;
  /// Of a disc, 6e-4 to 10 m.
  double radius;
  /// Parts of a compound: 1 to 256 parts.
  const struct jostle_shape_part *parts;
  size_t part_count;
  /// Name of a block of the library.
  const char *block;
  /// Unique in its scene; null (the default) for "body N".
  const char *name;
  /// From the table up, 1e-4 to 10 m: 0.045 by default. A block has its own: leave height, mass, friction,
  /// centre_of_mass, inertia and outline_tolerance at their defaults.
  double height;
  /// 1e-9 to 1000 kg: 0.1 by default.
  double mass;
  /// Coefficient of its surface, 0 to 10: 0.5 by default; a contact uses the product of the two surfaces' coefficients.
  double friction;
  /// 1 (the default) if a grasp may take it.
  uint32_t pickable;
  /// 1 (the default) if a push may be aimed at it. Any body may be moved by the others.
  uint32_t pushable;
  /// 1 (the default) if it is there.
  uint32_t present;
  /// 1 if `centre_of_mass` is given; 0 (the default) takes the centroid.
  uint32_t has_centre_of_mass;
  /// In the body frame, each coordinate in -10 to 10 m.
  struct jostle_vec2 centre_of_mass;
  /// About the centre of mass, kg m^2; 0 (the default) takes a uniform prism's. Its radius of gyration, the root of
  /// inertia over mass, lies in 1e-4 to 10 m.
  double inertia;
  /// Corners of a polygon that lie within so many metres of the outline without them are left out: planning takes
  /// longer the more there are. 0 keeps all, 0.01 is the most; -1 (the default) is 0.1 mm, or a hundredth of the
  /// shape's thickness (twice the area over the perimeter) where that is less. jostle_scene_body_info says what
  /// became of the outline.
  double outline_tolerance;
} jostle_body_def;

/// Names a body of a scene. Plain data: copy and store it as you like; it is valid in the scene that gave it and in
/// that scene's clones, plans and simulators. Zero is no body. Frozen: never changes.
typedef struct jostle_body {
  uint64_t id;
} jostle_body;

/// What was made of a body's shape. Frozen: never changes.
typedef struct jostle_body_info {
  /// Corners that stand for its outlines; a disc has 32.
  uint32_t corners;
  /// Convex pieces.
  uint32_t pieces;
  /// Square metres, of the shape as given.
  double area;
  /// Greatest distance of a corner that was left out from the outline, metres.
  double deviation;
} jostle_body_info;

/// Where a body is, or that it is not there. Frozen: never changes.
typedef struct jostle_body_pose {
  struct jostle_body body;
  struct jostle_pose2 pose;
  /// 1 if the body is there, 0 if it was taken away (then `pose` is kept but means nothing).
  uint32_t present;
  /// 0.
  uint32_t reserved;
} jostle_body_pose;

/// How the tip's lower end goes along the straight line from a push's commanded start to its commanded end. Metres. The
/// engines "planar", "prism" and "bullet" follow it; a planner or simulator with another engine is refused.
typedef struct jostle_tip_path {
  /// Set by jostle_tip_path_default().
  uint32_t struct_size;
  /// 1 where `base` is given, else 0.
  uint32_t has_base;
  /// x: way from the start, y: height above the table, before the arm lifts. x rises, y never does. 1 to 64 points.
  const struct jostle_vec2 *sink;
  size_t sink_count;
  /// x: share of the shortfall that is gone, from 0 to 1; y: how far the tip has risen since the lift began, from 0 on,
  /// never falling. 2 to 64 points.
  const struct jostle_vec2 *rise;
  size_t rise_count;
  /// How long before the commanded end the arm begins to lift, in pushes along the line to the base: 0 to 1 m.
  double shortfall_along;
  /// And in pushes across it. Without a base the mean of the two holds.
  double shortfall_across;
  /// Where the robot stands, in the scene's frame.
  struct jostle_vec2 base;
} jostle_tip_path;

/// A vertical two-finger grasp in the world frame. Frozen: never changes.
typedef struct jostle_grasp {
  /// Midpoint between the pads.
  struct jostle_vec2 position;
  /// Direction along which the fingers close, from +x, in [0, pi).
  double angle;
  /// Distance between the pads before closing, metres.
  double opening;
  /// Width of the body between the pads, metres.
  double width;
  /// Least spare room of all conditions of the grasp, metres; it holds while this is not negative.
  double margin;
  /// Expected quality in [0, 1].
  double score;
} jostle_grasp;

/// A condition of the grasp rule: one of the JOSTLE_LIMIT_ values.
typedef int32_t jostle_grasp_limit;

/// What a grasp is known by (docs/grasp-score.md). Every value is NaN where no part of the body is between the pads. Frozen:
/// never changes.
typedef struct jostle_grasp_features {
  /// Extent of the body between the pads along the closing direction, metres.
  double width;
  /// Length along the pads of what comes to lie on a pad, the lesser of both sides, metres.
  double touch;
  /// Least turn that lays a face flat on its pad, radians.
  double turn;
  /// How far the body reaches past the pads' middle along them, the lesser of both ways, metres.
  double end;
  /// Least gap of the open fingers to the body and to the others, metres; below 0 they come down on one.
  double clearance;
  /// How far the closed pads reach down the body, metres; NaN for a gripper without a chance of keeping.
  double depth;
  /// Of the body's top above the table, metres.
  double height;
  /// Of the body, kg.
  double mass;
} jostle_grasp_features;

/// What there is to know of one grasp. A `_spare` is the room that a condition has, and is not met while that is negative;
/// each is NaN where no part of the body is between the pads. Frozen: never changes.
typedef struct jostle_grasp_report {
  /// The grasp as it was given (an opening of 0 as the gripper's), with its width, margin and score. The margin is minus
  /// infinity where no part of the body is between the pads, the score 0 for a grasp that is not allowed.
  struct jostle_grasp grasp;
  /// The body that it takes.
  struct jostle_body body;
  /// 1 if a planner may execute it: all conditions are met; else 0.
  uint32_t allowed;
  /// The condition that is not met; of an allowed grasp, the one with the least spare room.
  jostle_grasp_limit limit;
  /// The body that JOSTLE_LIMIT_FINGER and _BETWEEN mean; else zero.
  struct jostle_body limit_body;
  /// Chance that the gripper keeps the body, allowed or not; NaN for a gripper without a chance of keeping (its score is
  /// a judgement by the shape of the grip: JOSTLE_SCORE_SHAPE).
  double chance;
  /// Angle between the gripped faces, radians.
  double wedge;
  /// Between the open fingers and the body itself, metres.
  double fit_spare;
  /// Of the length that the pads cover, metres.
  double cover_spare;
  /// Between the fingers and the other bodies, metres; infinite without any.
  double finger_spare;
  /// Between the space between the fingers and the other bodies, metres; infinite without any.
  double between_spare;
  /// Of the gripper's opening over the one asked for, metres.
  double opening_spare;
  /// Of the angle between the gripped faces, radians.
  double wedge_spare;
  /// The body that `finger_spare` is to; zero without any.
  struct jostle_body finger_body;
  /// The body that `between_spare` is to; zero without any.
  struct jostle_body between_body;
  struct jostle_grasp_features features;
} jostle_grasp_report;

/// What the score of a grasp is: one of the JOSTLE_SCORE_ values.
typedef int32_t jostle_grasp_score;

/// How the robot moves the tip when it is told to push: one of the JOSTLE_TIP_ values.
typedef int32_t jostle_tip;

/// The measures of a two-finger gripper: the closed fingers it pushes with, the jaw it grasps with. Metres and radians.
/// Widths, thicknesses and the opening lie in 1e-4 to 10 m, free gaps (clearances, fit) in 0 to 0.1 m.
typedef struct jostle_gripper {
  /// Set by jostle_gripper_default().
  uint32_t struct_size;
  /// What scores grasps: one of the JOSTLE_SCORE_ values.
  jostle_grasp_score grasp_score;
  /// Closed fingers: extent across the push.
  double push_width;
  /// Closed fingers: extent along the push.
  double push_thickness;
  /// Free gap needed round the closed fingers where they come down.
  double push_clearance;
  /// Free distance between the pads when open.
  double opening;
  /// Extent of a finger across the closing direction (the pad's width).
  double finger_width;
  /// Extent of a finger along the closing direction.
  double finger_thickness;
  /// Free gap needed on every side of a finger.
  double finger_clearance;
  /// Free gap needed between each pad and the body before closing.
  double fit;
  /// Strip at either end of the pads that another body may block while closing.
  double pad_edge;
  /// Least length of the body that the pads must cover.
  double min_cover;
  /// Greatest angle between the two gripped faces.
  double max_wedge;
  /// How the robot moves the tip in a push: one of the JOSTLE_TIP_ values.
  jostle_tip tip_path;
  /// 0.
  uint32_t reserved;
  /// The fingers' ends come no nearer to the table than this: 0 by default, at most 10. A body that they would not reach
  /// down by 5 mm (for robotiq_2f85) cannot be grasped; one that they end above is in no finger's way.
  double lowest;
  /// Length of the fingers below the palm, which stops at the body's top: over a tall one they end higher up. Infinity, the
  /// default: longer than any body is high.
  double finger_length;
} jostle_gripper;

/// When a body counts as having left the workspace: one of the JOSTLE_LEAVE_ values.
typedef int32_t jostle_leave_rule;

/// Which bodies must not leave: one of the JOSTLE_SCOPE_ values.
typedef int32_t jostle_leave_scope;

/// The rectangle that bodies must not leave, in the world frame: its sides are 0.001 to 200 m, its corners lie where
/// poses may. The target of a problem must be in it, by the rule.
typedef struct jostle_workspace {
  /// Set by jostle_workspace_default().
  uint32_t struct_size;
  /// JOSTLE_LEAVE_CENTRE or JOSTLE_LEAVE_FOOTPRINT.
  jostle_leave_rule leave_rule;
  /// Least x and y, metres.
  struct jostle_vec2 min;
  /// Greatest x and y, metres.
  struct jostle_vec2 max;
  /// JOSTLE_SCOPE_ALL_BODIES or JOSTLE_SCOPE_TARGET_ONLY.
  jostle_leave_scope leave_scope;
  /// 0.
  uint32_t reserved;
} jostle_workspace;

/// Where a body is wanted.
typedef struct jostle_goal {
  /// Set by jostle_goal_default().
  uint32_t struct_size;
  /// Turns about the body's origin that look the same: 1 (the default) none, 2 half a turn, 4 a square's, 0 any. A
  /// disc about its origin counts as 0 whatever is given.
  uint32_t symmetry;
  /// Of the body's frame in the world.
  struct jostle_pose2 pose;
  /// A body whose origin is at most this far from the goal's is there, metres: 5 mm by default.
  double position_tolerance;
  /// And whose heading differs by at most this, radians: 3 degrees by default.
  double rotation_tolerance;
} jostle_goal;

/// Where an image lies over the table. Columns run along +x of the image's frame, rows along +y (row 0 has the least y),
/// the frame's origin is the middle of the image: pixel (row, column) has its centre at x = (column + 1/2 - cols/2) pixel,
/// y = (row + 1/2 - rows/2) pixel. Frozen: never changes.
typedef struct jostle_image_frame {
  /// Of the image's middle in the world.
  struct jostle_pose2 pose;
  /// Side of a pixel, metres.
  double pixel;
  /// At most 16384.
  size_t rows;
  /// At most 16384.
  size_t cols;
} jostle_image_frame;

/// From the pixels of a camera's image to the table: pixel (row, column) has its centre at origin + column `column` +
/// row `row`. Any axes will do, turned and mirrored ones too, if they span pixels that are about square. Frozen: never
/// changes.
typedef struct jostle_pixel_map {
  /// World position of the centre of the first pixel of the first row.
  struct jostle_vec2 origin;
  /// From a pixel to the next one in its row, metres.
  struct jostle_vec2 column;
  /// From a row to the next, metres.
  struct jostle_vec2 row;
} jostle_pixel_map;

/// A camera's image of the table.
typedef struct jostle_camera_image {
  /// Set by jostle_camera_image_default().
  uint32_t struct_size;
  /// 0.
  uint32_t reserved;
  /// At most 16384.
  size_t rows;
  /// At most 16384.
  size_t cols;
  /// Which body each pixel shows, from a segmentation: 0 for the table, 1 to 255 for bodies. Null if there are masks.
  const uint8_t *labels;
  /// From a row of labels to the next, bytes.
  size_t label_stride;
  /// In place of labels, a mask for each body, one after the other: 0 where a pixel does not show it. The mask at k
  /// counts as label k + 1. Masks may overlap.
  const uint8_t *masks;
  /// At most 255.
  size_t mask_count;
  /// From a row of a mask to the next, bytes.
  size_t mask_stride;
  /// From a mask to the next, bytes.
  size_t mask_plane_stride;
  /// Height of what each pixel shows above the table, metres; NaN, 0 and less where it is not known. May be null.
  const float *heights;
  /// From a row of heights to the next, bytes.
  size_t height_stride;
  /// Where the pixels lie on the table.
  struct jostle_pixel_map map;
} jostle_camera_image;

/// What becomes of a body that reaches the image's border: one of the JOSTLE_BORDER_ values.
typedef int32_t jostle_border;

/// How images are read.
typedef struct jostle_image_options {
  /// Set by jostle_image_options_default().
  uint32_t struct_size;
  /// JOSTLE_BORDER_SKIP by default. For new bodies only.
  jostle_border at_border;
  /// How far the simplified outline of a new body may be from that between the pixels, pixels: 1 by default.
  double tolerance;
  /// Smaller regions are left out, square metres: 1e-4 by default.
  double min_area;
  /// A new body's height is this quantile of the heights of its pixels: 0.9 by default.
  double height_quantile;
  /// Of new bodies where the image has no heights, metres: 0.045 by default.
  double height;
  /// Of new bodies, kilograms: 0.1 by default.
  double mass;
  /// Of new bodies, 0.5 by default.
  double friction;
  /// A known body is not taken for a region that fits it worse than this, pixels: 3 by default.
  double greatest_cost;
  /// 1 (the default) if round outlines become discs.
  uint32_t discs;
  /// 0.
  uint32_t reserved;
} jostle_image_options;

/// What became of a region or of a known body: one of the JOSTLE_SEEN_ values.
typedef int32_t jostle_seen;

/// A region of an image and its body. Frozen: never changes.
typedef struct jostle_seen_body {
  /// Zero where the region became no body.
  struct jostle_body body;
  /// Where the body is; means something for JOSTLE_SEEN_BODY only.
  struct jostle_pose2 pose;
  /// In the image; 0 for a known body that was not seen.
  uint32_t label;
  jostle_seen seen;
  /// How far the region's outline is from the body's, pixels: root mean square. About 0.3 for clean images.
  double deviation;
  /// Pixels of holes of the region, which were filled.
  uint32_t hole_pixels;
  /// Pixels of the label apart from the region, which were dropped.
  uint32_t dropped_pixels;
} jostle_seen_body;

/// How far a decision is.
typedef struct jostle_progress {
  /// Set by jostle_progress_default().
  uint32_t struct_size;
  /// Actions of the shortest solution found so far, JOSTLE_NO_SOLUTION while there is none.
  uint32_t solution_actions;
  /// Iterations done.
  uint64_t iterations;
  /// Nodes of the search tree.
  uint64_t nodes;
  /// Pushes simulated.
  uint64_t simulations;
  /// Best return seen for a first action.
  double best_value;
  /// Since the decision began.
  double elapsed_seconds;
} jostle_progress;

/// How a network is loaded and run. Texts are copied.
typedef struct jostle_model_options {
  /// Set by jostle_model_options_default().
  uint32_t struct_size;
  /// JOSTLE_DEVICE_CPU (the default), or the number of an NVIDIA graphics card: then ONNX Runtime needs its CUDA
  /// provider, and results are not bit for bit.
  int32_t device;
  /// Threads of one call of the network, 1 by default. More pay for big networks that are called one at a time;
  /// planners have threads of their own.
  uint32_t threads;
  /// 1 (the default) runs the file's self-test.
  uint32_t self_test;
  /// File of ONNX Runtime's shared library; null (the default) to look for it (docs/networks.md says where). A process
  /// has one runtime, that of the first network it loads.
  const char *runtime;
  /// "onnxruntime" or "tract" (where it was built in); null (the default) for the first that is found.
  const char *backend;
  /// Name of the gripper that it must have been made for; null (the default) for any.
  const char *gripper;
  /// SHA-256 that the file must have, hexadecimal digits; null (the default) for any.
  const char *sha256;
  /// 1 lets a network for another gripper pass, here (jostle_model_info() has a warning then) and in planners. 0 by default.
  uint32_t tolerate;
  /// 0.
  uint32_t reserved;
} jostle_model_options;

/// Which form of a planner: one of the JOSTLE_VARIANT_ values.
typedef int32_t jostle_variant;

/// What a planner is told once. Texts are copied.
typedef struct jostle_planner_options {
  /// Set by jostle_planner_options_default().
  uint32_t struct_size;
  /// Worker threads; 0 runs everything on the caller. Never changes a plan made within a limit of iterations.
  /// JOSTLE_THREADS_OF_CONTEXT by default.
  uint32_t threads;
  /// "hedge", "pmbs", "mcts", "more", "ppn", "vft" or "dipn" to retrieve a target, "untangle", "pmmr" or "hbfs" to bring
  /// bodies to the scene's goals, "greedy" or "dipn_gn" (or a baseline, "random_push" or "grasp_only") to take everything off
  /// the table; null (the default) for "hedge". The options on pushes, grasps and engines are not for rearrangements.
  const char *planner;
  /// Engine that predicts what a push does: "rapier", "planar", "prism", "bullet" or the network "dipn"; null (the
  /// default) for the planner's own.
  const char *engine;
  /// The engine's preset, "fast" or "fine" among others; null (the default) for the one that suits planning.
  const char *preset;
  /// Push sampler: "vft", "more", "pmbs" or "dense"; null (the default) for the planner's own.
  const char *sampler;
  /// 0 by default.
  uint64_t seed;
  /// Iterations of one decision, at least 1; JOSTLE_NO_LIMIT (the default) for no such limit. With neither this nor
  /// max_seconds the planner's published number of iterations is used.
  uint64_t max_iterations;
  /// Wall-clock seconds of one decision, greater than 0; infinity (HUGE_VAL, the default) for no such limit.
  double max_seconds;
  /// Bytes of the search tree, or of the pushes that a planner of clearings judges, at least 1; JOSTLE_NO_LIMIT (the default)
  /// for no such limit. Planners of rearrangements other than "pmmr" do not count theirs.
  uint64_t max_bytes;
  /// Travel of a push, metres; 0 (the default) for the sampler's own.
  double push_length;
  /// A grasp is executed if its score is at least this, in [0, 1]; the default is the library's.
  double execute_score;
  /// A simulated state is a solution if its best grasp's score is at least this, in [0, 1]; the default is the library's.
  double solved_score;
  /// Logical lanes of a parallel search; changes plans. 0 (the default) for the planner's own.
  uint32_t lanes;
  /// Greatest number of pushes in a plan; 0 (the default) for the planner's own.
  uint32_t max_depth;
  /// Which form of the planner: JOSTLE_VARIANT_TUNED by default.
  jostle_variant variant;
  /// 0.
  uint32_t reserved;
  /// Engine in which the plan found and its best rivals are tried before the decision, a more faithful one than the
  /// search can afford: "ENGINE" or "ENGINE:PRESET", such as "prism:fine"; "none" for no trying; null (the default)
  /// for the planner's own choice.
  const char *confirm;
  /// What says how good a state is: "geometric", or the networks "gc" (graspable or not) or "gn" (grasp map); null (the
  /// default) for the planner's own.
  const char *scorer;
  /// The scorer's network; null (the default) for the built-in one. The planner keeps it.
  const struct jostle_model *scorer_model;
  /// The network of the engine "dipn"; null (the default) for the one that `preset` names: a built-in network or a file.
  /// The planner keeps it.
  const struct jostle_model *engine_model;
  /// What values pushes before they are tried: "ppn", a network, or "none"; null (the default) for the planner's own.
  const char *prior;
  /// The network that values pushes; null (the default) for the built-in one. The planner keeps it.
  const struct jostle_model *prior_model;
  /// The gripper of the scenes that will come: a network that was made for another one is refused by jostle_planner_new. Null
  /// (the default): by the first call with a scene, as it is in any case.
  const struct jostle_gripper *gripper;
} jostle_planner_options;

/// Told how far a decision is; a value other than 0 cancels it. It is called on the thread that decides (the caller's
/// for solve and step, the job's own for a job) while the search waits, so it should return soon. No lock is held, but
/// the planner is in use: calls on it return JOSTLE_ERROR_BUSY. It must not throw or longjmp.
typedef int32_t (*jostle_progress_callback)(const struct jostle_progress *progress, void *user);

/// What one decision is told.
typedef struct jostle_solve_options {
  /// Set by jostle_solve_options_default().
  uint32_t struct_size;
  /// 0.
  uint32_t reserved;
  /// Ends the decision when triggered; null (the default) for none. It may be freed while the decision runs.
  const struct jostle_cancel *cancel;
  /// Told how far the decision is; null (the default) for none.
  jostle_progress_callback progress;
  /// Passed to `progress`.
  void *user;
  /// Least time between two calls of `progress`, seconds: 0.1 by default.
  double progress_seconds;
} jostle_solve_options;

/// What an action is: one of the JOSTLE_ACTION_ values.
typedef int32_t jostle_action_kind;

/// A straight push in the world frame: the closed fingers come down at `start`, move to `end` and lift. The points are
/// the centre of the fingers' footprint; their width stays across the push. Frozen: never changes.
typedef struct jostle_push {
  struct jostle_vec2 start;
  struct jostle_vec2 end;
} jostle_push;

/// One action. Frozen: never changes.
typedef struct jostle_action {
  /// One of the JOSTLE_ACTION_ values.
  jostle_action_kind kind;
  /// 0.
  uint32_t reserved;
  /// The body that a grasp takes, a move moves or a push was aimed at; zero for a push aimed at none.
  struct jostle_body body;
  struct jostle_push push;
  struct jostle_grasp grasp;
} jostle_action;

/// Whether a job still runs: one of the JOSTLE_JOB_ values.
typedef int32_t jostle_job_state;

/// How a decision ended: one of the JOSTLE_OUTCOME_ values. None of them is an error.
typedef int32_t jostle_outcome;

/// A first action that was considered, for explaining a decision. Frozen: never changes.
typedef struct jostle_ranked_action {
  struct jostle_action action;
  /// Mean of the returns.
  double value;
  /// Greatest return.
  double best_return;
  uint64_t visits;
  double prior;
  /// Fewest actions to a solution below it, JOSTLE_NO_SOLUTION if none was found.
  uint32_t solution_actions;
  /// 0.
  uint32_t reserved;
} jostle_ranked_action;

/// What a decision took.
typedef struct jostle_plan_statistics {
  /// Set by jostle_plan_statistics_default().
  uint32_t struct_size;
  /// No plan of this many pushes or fewer exists in the planner's actions and model (all were tried);
  /// JOSTLE_UNKNOWN if that is not known.
  uint32_t no_plan_within;
  /// Iterations of the search; as a limit, the same number makes the same plan again.
  uint64_t iterations;
  /// Nodes of the search tree.
  uint64_t nodes;
  /// Pushes simulated.
  uint64_t simulations;
  /// The planner's seed.
  uint64_t seed;
  /// Wall-clock time of the decision.
  double seconds;
  /// Time of all threads in physics, grasp test and sampling.
  double domain_seconds;
  /// Time of the deciding thread outside of them.
  double search_seconds;
  /// Score of the plan's last grasp in the model, 0 without one.
  double grasp_score;
  /// Plans tried in the confirming engine before the decision; 0 where plans are not confirmed.
  uint64_t plans_tried;
  /// Of these, plans that succeed there too.
  uint64_t plans_confirmed;
  /// Pushes simulated in the confirming engine.
  uint64_t confirm_simulations;
  /// Wall-clock time of it, contained in `seconds`.
  double confirm_seconds;
  /// 1 if no shorter plan exists in the planner's actions and model: every push of every state that fewer pushes lead
  /// to was tried; else 0.
  uint32_t proved_shortest;
  /// Perturbed worlds that the next two are estimated from; 0 if the planner weighs no plans in such worlds, or had no
  /// need to.
  uint32_t worlds;
  /// Probability that the target is out after no more actions than the plan has, if the robot looks and plans again
  /// after every action.
  double success_chance;
  /// Mean number of actions until then.
  double expected_actions;
} jostle_plan_statistics;

/// What executes actions in a simulator's world: one of the JOSTLE_EXECUTOR_ values.
typedef int32_t jostle_executor;

/// How the world differs from the planner's model: not at all by default, but for the finer preset.
typedef struct jostle_simulator_options {
  /// Set by jostle_simulator_options_default().
  uint32_t struct_size;
  /// What executes actions: one of the JOSTLE_EXECUTOR_ values.
  jostle_executor executor;
  /// Engine: "rapier", "planar", "prism" or "bullet"; null (the default) for "rapier", or with JOSTLE_EXECUTOR_ROBOT or a
  /// gripper that has a tip path for "prism".
  const char *engine;
  /// The engine's preset, "fine" among others; null (the default) for the one that suits judging.
  const char *preset;
  /// Of friction and noise: the same seed is the same world. 0 by default.
  uint64_t seed;
  /// The friction of the fingertips and of every body is scaled by a factor of its own, drawn between 1 - this and
  /// 1 + this: 0 by default, at most 0.9.
  double friction_spread;
  /// Standard deviation of observed positions, metres: 0 by default, at most 0.02.
  double position_noise;
  /// Standard deviation of observed headings, radians: 0 by default, at most 0.5.
  double angle_noise;
} jostle_simulator_options;

/// What one action is told.
typedef struct jostle_execute_options {
  /// Set by jostle_execute_options_default().
  uint32_t struct_size;
  /// 0.
  uint32_t reserved;
  /// Wall-clock limit, seconds; infinity (the default) for none.
  double max_seconds;
  /// Ends the action when triggered; null (the default) for none. It may be freed while the action runs.
  const struct jostle_cancel *cancel;
} jostle_execute_options;

/// What an action did: one of the JOSTLE_EFFECT_ values.
typedef int32_t jostle_effect;

/// Done.
#define JOSTLE_OK 0

/// A value that cannot be used: null, not finite, out of range, degenerate, inconsistent.
#define JOSTLE_ERROR_ARGUMENT (-1)

/// Not a live handle of the wanted type: freed already, or not made by this library.
#define JOSTLE_ERROR_HANDLE (-2)

/// The object is not in a state that allows the call.
#define JOSTLE_ERROR_STATE (-3)

/// Another call is using the object.
#define JOSTLE_ERROR_BUSY (-4)

/// The buffer is too small; the needed count was written, nothing else.
#define JOSTLE_ERROR_BUFFER (-5)

/// A name, an index or a body that does not exist.
#define JOSTLE_ERROR_NOT_FOUND (-6)

/// This build, or this combination of options, cannot do it.
#define JOSTLE_ERROR_UNSUPPORTED (-7)

/// A file could not be read or written.
#define JOSTLE_ERROR_IO (-8)

/// A file or text was read but does not say what it should.
#define JOSTLE_ERROR_FORMAT (-9)

/// A network could not be run: it or its runtime gave what no network of its kind may give.
#define JOSTLE_ERROR_MODEL (-10)

/// The memory limit does not suffice.
#define JOSTLE_ERROR_MEMORY (-11)

/// A callback broke its contract. (Kept; no call returns it yet.)
#define JOSTLE_ERROR_CALLBACK (-12)

/// A defect of the library, caught before it reached the host. Objects that the call could change are poisoned.
#define JOSTLE_ERROR_PANIC (-13)

/// An earlier call on this object ended in JOSTLE_ERROR_PANIC; it can only be freed.
#define JOSTLE_ERROR_POISONED (-14)

/// Header and library, or a struct and the library, do not fit together.
#define JOSTLE_ERROR_ABI (-15)

/// A network's file is empty.
#define JOSTLE_ERROR_MODEL_EMPTY (-16)

/// A network's file is too big.
#define JOSTLE_ERROR_MODEL_TOO_BIG (-17)

/// A network's file is a Git LFS pointer; fetch the file itself with `git lfs pull`.
#define JOSTLE_ERROR_MODEL_LFS_POINTER (-18)

/// A network's file is no ONNX model, or is cut off.
#define JOSTLE_ERROR_MODEL_PARSE (-19)

/// Nothing that runs networks was found, or it is too old; the message says where it was looked for.
#define JOSTLE_ERROR_MODEL_RUNTIME (-20)

/// The runtime refuses the network; the message has its reason.
#define JOSTLE_ERROR_MODEL_SESSION (-21)

/// A network's file is not the one that its SHA-256 names.
#define JOSTLE_ERROR_MODEL_HASH (-22)

/// A network is of another kind than asked for, or does not say of which.
#define JOSTLE_ERROR_MODEL_KIND (-23)

/// A network has an interface that this version does not know.
#define JOSTLE_ERROR_MODEL_INTERFACE (-24)

/// An input or output of a network has another name, type or shape than its interface.
#define JOSTLE_ERROR_MODEL_IO_MISMATCH (-25)

/// A network was made for another configuration: gripper, pixel, image size, angles.
#define JOSTLE_ERROR_MODEL_SPEC_MISMATCH (-26)

/// A network does not give what it gave where it was exported.
#define JOSTLE_ERROR_MODEL_SELFTEST (-27)

/// A network's weights are in another file; save it as one file.
#define JOSTLE_ERROR_MODEL_EXTERNAL (-28)

/// A network has an operator that is not taken: one that controls the flow, or whose results may have any size.
#define JOSTLE_ERROR_MODEL_OPERATOR (-29)

/// A network would need more memory or work than the limits in docs/networks.md allow, or how much cannot be told.
#define JOSTLE_ERROR_MODEL_SIZE (-30)

/// Loading and testing a network took longer than the limit in docs/networks.md.
#define JOSTLE_ERROR_MODEL_DEADLINE (-31)

/// A simple polygon, convex or not: `points`, in order round the outline, in either direction. Corners within 0.1 um of the
/// one before them count once, also where the last repeats the first.
#define JOSTLE_SHAPE_POLYGON 1

/// As JOSTLE_SHAPE_POLYGON, but refused where it is not convex.
#define JOSTLE_SHAPE_CONVEX_POLYGON 2

/// A disc of `radius` about the origin.
#define JOSTLE_SHAPE_DISC 3

/// `parts` at poses in the body frame; they should touch.
#define JOSTLE_SHAPE_COMPOUND 4

/// A block of the library by its name `block`, with its measured mass, height and friction.
#define JOSTLE_SHAPE_BLOCK 5

/// A straight push; `push` says which, `grasp` is zero.
#define JOSTLE_ACTION_PUSH 1

/// A vertical two-finger grasp; `grasp` says which, `push` is zero.
#define JOSTLE_ACTION_GRASP 2

/// A pick-and-place of `body` in a rearrangement: `push` goes from where it is picked to where it is placed, `grasp` is
/// zero. jostle_plan_waypoints gives both poses.
#define JOSTLE_ACTION_PICK_PLACE 3

/// A drag of `body` along the table in a rearrangement: `push` goes from where it begins to where it ends, `grasp` is
/// zero. jostle_plan_waypoints gives the way.
#define JOSTLE_ACTION_DRAG 4

/// Straight from the commanded start to the commanded end, at the height that the engine has (the default).
#define JOSTLE_TIP_STRAIGHT 0

/// As a UR5e with its base in the origin does: the tip sinks on the way and lifts before it has arrived (docs/robot.md).
#define JOSTLE_TIP_UR5E 1

/// A path of the scene's own, which this struct does not hold: a scene that has one keeps it (jostle_scene_set_tip_path).
#define JOSTLE_TIP_OWN 2

/// No part of the body is between the pads.
#define JOSTLE_LIMIT_NOTHING_BETWEEN 1

/// The body is not pickable.
#define JOSTLE_LIMIT_NOT_PICKABLE 2

/// The gripper does not open so far.
#define JOSTLE_LIMIT_OPENING 3

/// The body's width in the opening: it does not fit between the fingers, wherever along the closing direction they are.
#define JOSTLE_LIMIT_WIDTH 4

/// A finger's clearance to `limit_body`: another body, or the one to be grasped where the fingers come down on it or too
/// near to it.
#define JOSTLE_LIMIT_FINGER 5

/// `limit_body`, another one, reaches into the space between the fingers.
#define JOSTLE_LIMIT_BETWEEN 6

/// The length of the body that the pads cover.
#define JOSTLE_LIMIT_COVER 7

/// The angle between the gripped faces.
#define JOSTLE_LIMIT_WEDGE 8

/// How far the fingers reach down the body: it is too low for them.
#define JOSTLE_LIMIT_DEPTH 9

/// A judgement by the shape of the grip (the default).
#define JOSTLE_SCORE_SHAPE 0

/// The chance that the gripper keeps the body, by shape, height and mass of the body and the room of the fingers: the model
/// of robotiq_2f85_kept, at this gripper's size.
#define JOSTLE_SCORE_KEPT 1

/// A chance by the tables of the scene's own file, which a struct does not hold: a scene that has them keeps them.
#define JOSTLE_SCORE_OWN 2

/// Its frame's origin is outside (the default).
#define JOSTLE_LEAVE_CENTRE 1

/// Any part of its footprint is outside.
#define JOSTLE_LEAVE_FOOTPRINT 2

/// All bodies (the default).
#define JOSTLE_SCOPE_ALL_BODIES 1

/// The target alone.
#define JOSTLE_SCOPE_TARGET_ONLY 2

/// It is taken as far as it is seen.
#define JOSTLE_BORDER_KEEP 1

/// It is left out and reported (the default).
#define JOSTLE_BORDER_SKIP 2

/// The image is refused.
#define JOSTLE_BORDER_REFUSE 3

/// It is a body, with its pose.
#define JOSTLE_SEEN_BODY 0

/// The region's area is less than min_area.
#define JOSTLE_SEEN_TOO_SMALL 1

/// The region reaches the image's border.
#define JOSTLE_SEEN_AT_BORDER 2

/// No pixel of the region has a height.
#define JOSTLE_SEEN_NO_HEIGHT 3

/// The region's outline has no simple polygon within the tolerance.
#define JOSTLE_SEEN_NO_OUTLINE 4

/// No region fits the known body.
#define JOSTLE_SEEN_NOWHERE 5

/// As the text of the dissertation says.
#define JOSTLE_VARIANT_DISSERTATION 1

/// As the published code does.
#define JOSTLE_VARIANT_CODE 2

/// The published parameters with what measures better here.
#define JOSTLE_VARIANT_TUNED 3

/// It runs.
#define JOSTLE_JOB_RUNNING 1

/// It ended; jostle_job_take_plan gives its plan, or says why there is none.
#define JOSTLE_JOB_DONE 2

/// The plan ends with the target grasped, or with every body at its goal, in the planner's model.
#define JOSTLE_OUTCOME_SOLVED 1

/// The search ended by itself without a grasp, or short of the goals; the plan holds the best actions found.
#define JOSTLE_OUTCOME_PARTIAL 2

/// It was shown that the planner's actions do not solve the problem: there is no grasp and no legal push, or a body that has
/// to be dragged is enclosed by what stays. The plan holds no actions; jostle_plan_reason() says why.
#define JOSTLE_OUTCOME_INFEASIBLE 3

/// A limit was reached first; the plan holds the best found so far.
#define JOSTLE_OUTCOME_BUDGET 4

/// Cancelled. The plan holds no actions, so that an outcome that nobody reads moves no robot.
#define JOSTLE_OUTCOME_CANCELLED 5

/// The push was executed.
#define JOSTLE_EFFECT_PUSHED 1

/// The fingers would come down on a body, or the engine could not solve the push; nothing was executed.
#define JOSTLE_EFFECT_BLOCKED 2

/// The target, or in a world without one the body of the grasp, was grasped and taken away.
#define JOSTLE_EFFECT_GRASPED 3

/// The grasp does not hold where the bodies really are, or is not one of the target; nothing changed, or with
/// JOSTLE_EXECUTOR_ROBOT the body was shoved or lost: look before you go on.
#define JOSTLE_EFFECT_MISSED 4

/// The action was not finished: its limit was reached, or it was cancelled. Nothing changed.
#define JOSTLE_EFFECT_INTERRUPTED 5

/// The push was executed and a body fell over or leans on something: its outline is no longer what it was, so look before
/// you go on. "prism" ends the push where that happens, with the tip short of its end.
#define JOSTLE_EFFECT_TOPPLED 6

/// The tip goes straight where it is sent, or as the gripper's tip path says; the engine's trial of a grasp, or where it has
/// none geometry, says what is taken.
#define JOSTLE_EXECUTOR_ENGINE 0

/// The recorded robot, a UR5e with a 2F-85 (docs/robot.md): its tip sinks and lifts on the way, and its hand keeps, shoves
/// and loses bodies by the chance fitted to recorded grasps, or by the gripper's own. Needs an engine that follows tip
/// paths: "planar", "prism" or "bullet".
#define JOSTLE_EXECUTOR_ROBOT 1

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// The message of the last call that failed on this thread: which field, what is wrong, what to change.
/// Empty if none has failed. It says something only just after a failure; later failures overwrite it.
///
/// Thread: any; every thread has its own message.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library; valid until the thread's next failing call or its end.
/// Errors: none.
const char *jostle_last_error(void);

/// The name of a status, such as "JOSTLE_ERROR_BUSY"; "unknown status" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_status_name(jostle_status status);

/// The number of the binary interface that the library was built with.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
uint32_t jostle_abi_version(void);

/// Refuses a library that does not fit the header: call jostle_abi_check(JOSTLE_ABI_VERSION) before anything else.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ABI (the caller was compiled with the header of another binary interface).
jostle_status jostle_abi_check(uint32_t version);

/// The library's version, such as "0.1.0".
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_version(void);

/// The library's version as major * 10000 + minor * 100 + patch, to compare with JOSTLE_VERSION_NUMBER.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
uint32_t jostle_version_number(void);

/// Version, target, profile and compiler of the library, for bug reports.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_build_info(void);

/// 1 if this build has the JOSTLE_FEATURE_ of that number, 0 if not or if the number is unknown. Every function exists
/// in every build; what needs an absent feature returns JOSTLE_ERROR_UNSUPPORTED.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
uint32_t jostle_feature(int32_t feature);

/// How many handles of all types are alive in the process: 0 once everything was freed.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: none.
uint64_t jostle_handle_count(void);

/// Sets every field to its default; `size` is sizeof(jostle_context_options) as the caller was compiled.
/// jostle_context_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_context_options_init(struct jostle_context_options *options,
                                          size_t size);

/// Makes a context.
///
/// Thread: any.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *context and frees it with jostle_context_free; `options` is copied.
/// Errors: ARGUMENT (null, threads out of range), ABI (options of a newer header), MEMORY.
jostle_status jostle_context_new(const struct jostle_context_options *options,
                                 struct jostle_context **context);

/// Frees a context. Objects made from it stay usable until they are freed themselves.
///
/// Thread: any.
/// RT: no.
/// Nullable: context (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_context_free(struct jostle_context *context);

/// Sets every field to its default; `size` is sizeof(jostle_body_def) as the caller was compiled.
/// jostle_body_def_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_body_def_init(struct jostle_body_def *def, size_t size);

/// What was made of a body's shape: how many corners and pieces, and how far its outline went from the given one.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_body_info(const struct jostle_scene *scene,
                                     struct jostle_body body,
                                     struct jostle_body_info *info);

/// Makes an empty scene: gripper robotiq_2f85, workspace of 0.448 m square centred at (0.5, 0).
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
jostle_status jostle_scene_new(const struct jostle_context *context, struct jostle_scene **scene);

/// Makes a copy with a life of its own. Bodies have the same ids in both.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *copy and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED, MEMORY.
jostle_status jostle_scene_clone(const struct jostle_scene *scene, struct jostle_scene **copy);

/// Frees a scene. Planners, plans and simulators that were given it keep what they need.
///
/// Thread: any.
/// RT: no.
/// Nullable: scene (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_scene_free(struct jostle_scene *scene);

/// Adds a body. Whether it overlaps others is checked when all are placed: by jostle_scene_check, jostle_scene_update
/// and whatever plans or simulates.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `def` and all it points to are copied.
/// Errors: ARGUMENT (null, a field of def: the message names it), HANDLE, BUSY, NOT_FOUND (def.block), POISONED,
/// ABI. On failure the scene is unchanged.
jostle_status jostle_scene_add_body(struct jostle_scene *scene,
                                    const struct jostle_body_def *def,
                                    struct jostle_body *body);

/// Takes a body out of the scene for good; its id is not used again. (To say that a known body is not there for now,
/// use jostle_scene_set_present.)
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_remove_body(struct jostle_scene *scene,
                                       struct jostle_body body);

/// Number of bodies, present or not.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_body_count(const struct jostle_scene *scene, size_t *count);

/// The body with this name.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, not UTF-8), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_find_body(const struct jostle_scene *scene,
                                     const char *name,
                                     struct jostle_body *body);

/// Copies a body's name to `buffer`; `length` counts the closing zero. A null buffer of capacity 0 asks for the length.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, BUFFER (length was written), NOT_FOUND, POISONED.
jostle_status jostle_scene_body_name(const struct jostle_scene *scene,
                                     struct jostle_body body,
                                     char *buffer,
                                     size_t capacity,
                                     size_t *length);

/// Places a body. For what a camera saw of many bodies use jostle_scene_update.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `pose` is copied.
/// Errors: ARGUMENT (null, not finite, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_set_pose(struct jostle_scene *scene,
                                    struct jostle_body body,
                                    const struct jostle_pose2 *pose);

/// Where a body is.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_get_pose(const struct jostle_scene *scene,
                                    struct jostle_body body,
                                    struct jostle_pose2 *pose);

/// Says whether a body is there (1) or was taken away (0).
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (zero body, present not 0 or 1), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_set_present(struct jostle_scene *scene,
                                       struct jostle_body body,
                                       uint32_t present);

/// Writes 1 to *present if the body is there, else 0.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_get_present(const struct jostle_scene *scene,
                                       struct jostle_body body,
                                       uint32_t *present);

/// Takes over one observation of many bodies: all of it or, on failure, nothing. Bodies that are not listed stay as
/// they were. The result is checked: bodies may overlap by the overlap tolerance at most.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: poses (with count 0).
/// Owns: `poses` is copied.
/// Errors: ARGUMENT (null, not finite, zero body, a body listed twice, bodies that overlap: the message names the
/// index), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_update(struct jostle_scene *scene,
                                  const struct jostle_body_pose *poses,
                                  size_t count);

/// Copies the poses of all bodies, in the order in which they were added.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
jostle_status jostle_scene_poses(const struct jostle_scene *scene,
                                 struct jostle_body_pose *buffer,
                                 size_t capacity,
                                 size_t *count);

/// Checks that the scene can be planned with: it has bodies, and none overlap by more than the tolerance.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (what is wrong, with the index of the pose), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_check(const struct jostle_scene *scene);

/// A hash of all that the scene holds: equal scenes have equal hashes, in every process of this version. Poses count as
/// files and plans hold them, in single precision, so what was written and read again has the same hash.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_hash(const struct jostle_scene *scene,
                                uint64_t *hash);

/// Sets every field to its default; `size` is sizeof(jostle_tip_path) as the caller was compiled. The tables are yours to
/// give. jostle_tip_path_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_tip_path_init(struct jostle_tip_path *path,
                                   size_t size);

/// Gives the scene's robot this path of the tip, or with null a straight one. A gripper that is set later keeps it where its
/// tip_path is JOSTLE_TIP_OWN.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: path (straight).
/// Owns: `path` and its tables are copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
jostle_status jostle_scene_set_tip_path(struct jostle_scene *scene,
                                        const struct jostle_tip_path *path);

/// The best grasp of a body where all bodies are now. *found is 1 if there is one, else 0 and *grasp stays as it was.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body, absent body, bodies that overlap), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_best_grasp(const struct jostle_scene *scene,
                                      struct jostle_body body,
                                      struct jostle_grasp *grasp,
                                      uint32_t *found);

/// The best grasps of a body where all bodies are now, best first: at most `most`, fewer where there are no more. No two are
/// alike: their positions are JOSTLE_GRASPS_APART from each other, or their closing directions JOSTLE_GRASPS_TURNED. The
/// first is that of jostle_scene_best_grasp (whose lengths and score may differ in the last bits), and what a planner without networks would execute; each of the others is the
/// best of those that are unlike the ones before it. (Scores closer than 1e-9 count as equal.) All are allowed, and each
/// report is what jostle_scene_examine_grasp says of its grasp, to the bit. A buffer for `most` reports is large enough.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null, zero body, absent body, most of 0, bodies that overlap), HANDLE, BUSY, BUFFER (count was written),
/// NOT_FOUND, POISONED.
jostle_status jostle_scene_best_grasps(const struct jostle_scene *scene,
                                       struct jostle_body body,
                                       size_t most,
                                       struct jostle_grasp_report *buffer,
                                       size_t capacity,
                                       size_t *count);

/// All that is known of a grasp of a body where all bodies are now: whether it is allowed and why not, score, chance of
/// keeping, width, spare room, features. Of `grasp` position, angle and opening are read; an opening of 0 is the gripper's. A
/// grasp that is not allowed is no failure of the call.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `grasp` is copied.
/// Errors: ARGUMENT (null, zero body, absent body, a number that is none or out of range: the message names the field; bodies
/// that overlap), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_examine_grasp(const struct jostle_scene *scene,
                                         struct jostle_body body,
                                         const struct jostle_grasp *grasp,
                                         struct jostle_grasp_report *report);

/// Copies why a grasp is not allowed and what to change, or what leaves an allowed one the least room: a sentence with names
/// and millimetres, for people. `length` counts the closing zero. Of `grasp` the same is read as by
/// jostle_scene_examine_grasp.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer; `grasp` is copied.
/// Errors: as jostle_scene_examine_grasp, and BUFFER (length was written).
jostle_status jostle_scene_explain_grasp(const struct jostle_scene *scene,
                                         struct jostle_body body,
                                         const struct jostle_grasp *grasp,
                                         char *buffer,
                                         size_t capacity,
                                         size_t *length);

/// The name of a condition of the grasp rule, such as "cover"; "unknown limit" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_grasp_limit_name(jostle_grasp_limit limit);

/// Sets every field to the gripper robotiq_2f85; `size` is sizeof(jostle_gripper) as the caller was compiled.
/// jostle_gripper_default() in this header does it for you.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_gripper_init(struct jostle_gripper *gripper,
                                  size_t size);

/// The measures of a gripper of the library: "robotiq_2f85", "robotiq_2f85_kept" (the same, which scores grasps by the chance
/// that it keeps the body), "robotiq_2f85_ur5e" (that one, whose tip goes as a UR5e moves it) or "dissertation_mask".
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; gripper->struct_size says how much is written.
/// Errors: ARGUMENT (null, not UTF-8, gripper not initialised), NOT_FOUND (the message lists the names).
jostle_status jostle_gripper_by_name(const char *name,
                                     struct jostle_gripper *gripper);

/// Gives the scene's robot this gripper.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `gripper` is copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
jostle_status jostle_scene_set_gripper(struct jostle_scene *scene,
                                       const struct jostle_gripper *gripper);

/// The gripper of the scene's robot.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; gripper->struct_size says how much is written.
/// Errors: ARGUMENT (null, gripper not initialised), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_get_gripper(const struct jostle_scene *scene,
                                       struct jostle_gripper *gripper);

/// Sets every field to its default; `size` is sizeof(jostle_workspace) as the caller was compiled.
/// jostle_workspace_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_workspace_init(struct jostle_workspace *workspace, size_t size);

/// Sets the rectangle that bodies must not leave, and the rule.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: `workspace` is copied.
/// Errors: ARGUMENT (null, a field: the message names it), HANDLE, BUSY, POISONED, ABI.
jostle_status jostle_scene_set_workspace(struct jostle_scene *scene,
                                         const struct jostle_workspace *workspace);

/// The rectangle that bodies must not leave, and the rule.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; workspace->struct_size says how much is written.
/// Errors: ARGUMENT (null, workspace not initialised), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_get_workspace(const struct jostle_scene *scene,
                                         struct jostle_workspace *workspace);

/// Sets the friction coefficients of the table and of the fingertips. A contact uses the product of its two surfaces'
/// coefficients. Defaults: 1.1 and 0.9.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (not finite, out of 0..10), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_set_friction(struct jostle_scene *scene,
                                        double ground,
                                        double tip);

/// The friction coefficients of the table and of the fingertips.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_get_friction(const struct jostle_scene *scene,
                                        double *ground,
                                        double *tip);

/// Sets how far two bodies may overlap before an observation is refused, metres: 0.006 by default.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (not finite, out of 0..0.05), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_set_overlap_tolerance(struct jostle_scene *scene, double metres);

/// Sets every field to its default; `size` is sizeof(jostle_goal) as the caller was compiled. jostle_goal_default() in
/// this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_goal_init(struct jostle_goal *goal,
                               size_t size);

/// Says where a body is wanted; planners of rearrangements bring it there. Whether the goals fit each other is checked
/// when a planner is given the scene. A body without a goal may end anywhere.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: goal (takes the body's goal away).
/// Owns: `goal` is copied.
/// Errors: ARGUMENT (null, zero body, a field of goal: the message names it), HANDLE, BUSY, NOT_FOUND, POISONED, ABI.
/// On failure the scene is unchanged.
jostle_status jostle_scene_set_goal(struct jostle_scene *scene,
                                    struct jostle_body body,
                                    const struct jostle_goal *goal);

/// Where a body is wanted.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller; goal->struct_size says how much is written.
/// Errors: ARGUMENT (null, zero body, goal not initialised), HANDLE, BUSY, NOT_FOUND (the body, or it has no goal),
/// POISONED.
jostle_status jostle_scene_get_goal(const struct jostle_scene *scene,
                                    struct jostle_body body,
                                    struct jostle_goal *goal);

/// The frame of a square image about the centre of a body's footprint, its x axis at `heading` (radians) in the world:
/// `side` pixels of `pixel` metres.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, zero body, a value out of range), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_frame_around(const struct jostle_scene *scene,
                                        struct jostle_body body,
                                        double heading,
                                        double pixel,
                                        size_t side,
                                        struct jostle_image_frame *frame);

/// The map of an image of the library: what makes of its pixels a camera's.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: `frame` is copied.
/// Errors: ARGUMENT (null, a field of frame out of range).
jostle_status jostle_image_frame_map(const struct jostle_image_frame *frame,
                                     struct jostle_pixel_map *map);

/// Writes to each pixel which body it shows: 0 is the table, k + 1 the body that jostle_scene_poses lists at k. A pixel
/// shows a body if its centre lies in the body's footprint; where footprints overlap the higher body shows, of equally
/// high ones the earlier. Rows begin `row_stride` bytes apart; what lies between them is left as it is.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, frame or row_stride out of range, a scene without bodies or with more than 255), HANDLE, BUSY,
/// POISONED.
jostle_status jostle_scene_label_image(const struct jostle_scene *scene,
                                       const struct jostle_image_frame *frame,
                                       uint8_t *pixels,
                                       size_t row_stride);

/// Writes to each pixel how high what it shows reaches above the table, metres; 0 is the table. See
/// jostle_scene_label_image.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, frame or row_stride out of range, a scene without bodies), HANDLE, BUSY, POISONED.
jostle_status jostle_scene_height_image(const struct jostle_scene *scene,
                                        const struct jostle_image_frame *frame,
                                        float *pixels,
                                        size_t row_stride);

/// Writes 1 to each pixel that shows the body, 0 to all others. See jostle_scene_label_image.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns the pixels.
/// Errors: ARGUMENT (null, zero body, frame or row_stride out of range), HANDLE, BUSY, NOT_FOUND, POISONED.
jostle_status jostle_scene_mask_image(const struct jostle_scene *scene,
                                      struct jostle_body body,
                                      const struct jostle_image_frame *frame,
                                      uint8_t *pixels,
                                      size_t row_stride);

/// Sets every field to its default; `size` is sizeof(jostle_camera_image) as the caller was compiled.
/// jostle_camera_image_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_camera_image_init(struct jostle_camera_image *image,
                                       size_t size);

/// Sets every field to its default; `size` is sizeof(jostle_image_options) as the caller was compiled.
/// jostle_image_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_image_options_init(struct jostle_image_options *options,
                                        size_t size);

/// Adds the bodies that an image shows, which need not be known: each label becomes a body with a simplified outline (a
/// polygon or a disc, its frame at the centroid), the height that the image says and the name "label N". What became of
/// each label goes to `buffer`, by label. A null buffer of capacity 0 asks for the count and adds nothing.
///
/// Of a label in several parts the largest is taken; holes are filled. Bodies that overlap, as they may in an unclean
/// image, are found by jostle_scene_check.
///
/// Thread: exclusive use of scene.
/// RT: no.
/// Nullable: options (takes the defaults), buffer (with capacity 0).
/// Owns: the pixels are not kept; the caller owns the buffer.
/// Errors: ARGUMENT (null, a field of image or options: the message names it, more bodies than a scene holds, a label at
/// the border that is refused), HANDLE, BUSY, BUFFER (count was written), POISONED, ABI. On failure the scene is
/// unchanged.
jostle_status jostle_scene_add_image(struct jostle_scene *scene,
                                     const struct jostle_camera_image *image,
                                     const struct jostle_image_options *options,
                                     struct jostle_seen_body *buffer,
                                     size_t capacity,
                                     size_t *count);

/// Finds the bodies of the scene, whose shapes are known, in an image whose labels say nothing of which is which: one
/// entry for each body that is present, in the order of jostle_scene_poses, with its label and pose, or
/// JOSTLE_SEEN_NOWHERE. The scene stays as it is; give the poses to jostle_scene_update. Of shapes that look the same
/// from several sides any of the headings may come.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: options (takes the defaults), buffer (with capacity 0: asks for the count).
/// Owns: the pixels are not kept; the caller owns the buffer.
/// Errors: ARGUMENT (null, a field of image or options: the message names it, a scene without bodies), HANDLE, BUSY,
/// BUFFER (count was written), POISONED, ABI.
jostle_status jostle_scene_match_image(const struct jostle_scene *scene,
                                       const struct jostle_camera_image *image,
                                       const struct jostle_image_options *options,
                                       struct jostle_seen_body *buffer,
                                       size_t capacity,
                                       size_t *count);

/// Reads a problem's file (JSON, see docs/scene-format.md): the scene, and the body to retrieve. Of a rearrangement, the
/// scene with its goals, and zero; of a table to clear, the scene, and zero.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null, not UTF-8), HANDLE, IO, FORMAT (the message names the field and its line), MEMORY.
jostle_status jostle_scene_read(const struct jostle_context *context,
                                const char *path,
                                struct jostle_scene **scene,
                                struct jostle_body *target);

/// Writes the problem of retrieving `target`, or with a zero target that of bringing the bodies to their goals where
/// one has a goal, else that of taking everything off the table, as a file (JSON) that jostle_scene_read and the
/// command-line tool read.
///
/// Thread: shared use of scene.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null, not UTF-8, absent target, bodies that overlap, goals that do not fit), HANDLE, BUSY,
/// NOT_FOUND (target), IO, POISONED.
jostle_status jostle_scene_write(const struct jostle_scene *scene,
                                 struct jostle_body target,
                                 const char *path);

/// Makes a random packed scene of `bodies` blocks and picks the one to retrieve. The same seed, index and number make
/// the same scene.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *scene and frees it with jostle_scene_free.
/// Errors: ARGUMENT (null, bodies out of range or more than find room), HANDLE, MEMORY.
jostle_status jostle_scene_generate(const struct jostle_context *context,
                                    uint64_t seed,
                                    uint64_t index,
                                    size_t bodies,
                                    struct jostle_scene **scene,
                                    struct jostle_body *target);

/// Makes a flag that is not triggered.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *cancel and frees it with jostle_cancel_free, whenever it likes: decisions hold on to the flag.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
jostle_status jostle_cancel_new(const struct jostle_context *context,
                                struct jostle_cancel **cancel);

/// Makes a second handle to the same flag, with a life of its own: give each thread that triggers its own handle, and
/// no thread has to know when another frees.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *copy and frees it with jostle_cancel_free.
/// Errors: ARGUMENT (null), HANDLE, MEMORY.
jostle_status jostle_cancel_clone(const struct jostle_cancel *cancel,
                                  struct jostle_cancel **copy);

/// Asks every decision that was given the flag to end. It ends within the time that docs/c-api.md states, and its plan
/// holds no actions. Triggering twice changes nothing.
///
/// Thread: any, at any time, also from a signal handler or a real-time thread.
/// RT: yes (no lock, no memory, no system call).
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE (also when it was freed: that is safe to try).
jostle_status jostle_cancel_trigger(const struct jostle_cancel *cancel);

/// Makes the flag usable for the next decision. A decision that has seen the request already still ends.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_cancel_reset(const struct jostle_cancel *cancel);

/// Writes 1 to *triggered if the flag was triggered (and not reset), else 0.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_cancel_triggered(const struct jostle_cancel *cancel, uint32_t *triggered);

/// Frees a handle. The flag itself lives on while a decision or another handle uses it.
///
/// Thread: any, also while another thread triggers this handle.
/// RT: no.
/// Nullable: cancel (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_cancel_free(struct jostle_cancel *cancel);

/// Sets every field to its default; `size` is sizeof(jostle_progress) as the caller was compiled.
/// jostle_progress_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_progress_init(struct jostle_progress *progress, size_t size);

/// Sets every field to its default; `size` is sizeof(jostle_model_options) as the caller was compiled.
/// jostle_model_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_model_options_init(struct jostle_model_options *options,
                                        size_t size);

/// Loads a network and checks it: `name` is a built-in network's name, such as "gc", or the path of an ONNX file. `kind` is
/// what it must be: "dipn", "ppn", "gc", "gn" or "segmentation"; null for any.
///
/// Every check has its own status, and the message names the file, what was expected and what was found. A failed load
/// leaves nothing behind, except that a runtime that was found stays loaded.
///
/// Thread: any.
/// RT: no.
/// Nullable: kind, options (all defaults).
/// Owns: the caller owns *model and frees it with jostle_model_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it), HANDLE, NOT_FOUND (no such file, network, kind or backend), IO,
/// MODEL_EMPTY, MODEL_TOO_BIG, MODEL_LFS_POINTER, MODEL_PARSE, MODEL_HASH, MODEL_EXTERNAL, MODEL_OPERATOR, MODEL_KIND,
/// MODEL_INTERFACE, MODEL_IO_MISMATCH, MODEL_SPEC_MISMATCH, MODEL_SIZE, MODEL_RUNTIME, MODEL_SESSION, MODEL_SELFTEST,
/// MODEL_DEADLINE, UNSUPPORTED (device), MEMORY, ABI.
jostle_status jostle_model_load(const struct jostle_context *context,
                                const char *name,
                                const char *kind,
                                const struct jostle_model_options *options,
                                struct jostle_model **model);

/// Copies what is known of a network as JSON text: file, kind, interface, hash, metadata, inputs, outputs, warnings, and
/// what runs it. `length` counts the closing zero.
///
/// Thread: shared use of model.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written).
jostle_status jostle_model_info(const struct jostle_model *model,
                                char *buffer,
                                size_t capacity,
                                size_t *length);

/// Frees a network. Planners that were made with it keep it until they are freed themselves.
///
/// Thread: any.
/// RT: no.
/// Nullable: model (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_model_free(struct jostle_model *model);

/// Copies which runtime this process runs networks with, as JSON text: backend, version, file, build. Looks for one if none
/// was used yet. `length` counts the closing zero.
///
/// Thread: any.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), BUFFER (length was written), MODEL_RUNTIME (there is none; the message says what was tried).
jostle_status jostle_runtime_info(char *buffer,
                                  size_t capacity,
                                  size_t *length);

/// Sets every field to its default; `size` is sizeof(jostle_planner_options) as the caller was compiled.
/// jostle_planner_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_planner_options_init(struct jostle_planner_options *options,
                                          size_t size);

/// Sets every field to its default; `size` is sizeof(jostle_solve_options) as the caller was compiled.
/// jostle_solve_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_solve_options_init(struct jostle_solve_options *options,
                                        size_t size);

/// Makes a planner.
///
/// Thread: any.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *planner and frees it with jostle_planner_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it; a network made for another gripper than options.gripper),
/// HANDLE, NOT_FOUND (an unknown planner, engine, preset, sampler or scorer: the message lists the known), UNSUPPORTED,
/// MEMORY, ABI, and what jostle_model_load returns.
jostle_status jostle_planner_new(const struct jostle_context *context,
                                 const struct jostle_planner_options *options,
                                 struct jostle_planner **planner);

/// Frees a planner and ends its worker threads. If a job of the planner still runs, they end with the job.
///
/// Thread: any.
/// RT: no.
/// Nullable: planner (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_planner_free(struct jostle_planner *planner);

/// Decides what to do to retrieve `target`, within the planner's limits, and waits for it. A planner of rearrangements
/// is given a zero target, and brings the scene's bodies to their goals; so is one that clears the table, whose answer is
/// solved and without actions when nothing is left to be taken. The search tree that
/// jostle_planner_advance kept is used if the scene is the one that was expected. The same scene and target again give the
/// same plan again, until an action was executed or failed (a deadline may end the same search sooner or later);
/// jostle_planner_step goes on instead. The scene may be changed by other threads meanwhile: the planner has its own copy.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no (for real-time threads: jostle_planner_job_start from another thread, jostle_job_poll from any).
/// Nullable: options (all defaults).
/// Owns: the caller owns *plan and frees it with jostle_plan_free.
/// Errors: ARGUMENT (null, an option, zero target, target absent or not pickable, bodies that overlap, a gripper that a
/// network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), UNSUPPORTED, MEMORY, PANIC, POISONED, ABI.
/// Running into a limit and being cancelled are outcomes.
jostle_status jostle_planner_solve(struct jostle_planner *planner,
                                   const struct jostle_scene *scene,
                                   struct jostle_body target,
                                   const struct jostle_solve_options *options,
                                   struct jostle_plan **plan);

/// Does at most `iterations` iterations of the decision on the calling thread and gives the best plan so far; called
/// again with the same scene and target it goes on where it was.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *plan and frees it with jostle_plan_free.
/// Errors: ARGUMENT (null, an option, zero iterations, zero target, target absent or not pickable, bodies that overlap, a
/// gripper that a network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), UNSUPPORTED, MEMORY, PANIC,
/// POISONED, ABI.
jostle_status jostle_planner_step(struct jostle_planner *planner,
                                  const struct jostle_scene *scene,
                                  struct jostle_body target,
                                  uint64_t iterations,
                                  const struct jostle_solve_options *options,
                                  struct jostle_plan **plan);

/// Tells the planner that the first action of its last plan was executed: the part of the search tree below it is
/// kept. *kept is 1 if there was one, else 0.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: kept.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), PANIC, POISONED.
jostle_status jostle_planner_advance(struct jostle_planner *planner,
                                     const struct jostle_action *action,
                                     uint32_t *kept);

/// Tells the planner that the first action of its last plan was tried and failed: the fingers would have come down on a
/// body, or the target was not in the gripper. Grasps of the target like it score less from now on (docs/c-api.md), so that
/// another side of it is tried first; the same push is not offered before another was executed. Both hold also where the next
/// scene is another one that shows the same bodies, outlines that differ a little where the bodies may be. The search tree is
/// forgotten. jostle_planner_reset forgets what failed.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), PANIC, POISONED.
jostle_status jostle_planner_failed(struct jostle_planner *planner,
                                    const struct jostle_action *action);

/// Forgets the search tree and what failed.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_planner_reset(struct jostle_planner *planner);

/// Bytes that the search tree holds, or the pushes that a planner of clearings judged last; for a rearrangement the tree
/// and the paths that are known.
///
/// Thread: exclusive use of planner.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_planner_memory(struct jostle_planner *planner,
                                    uint64_t *bytes);

/// How far the planner's decision is, whichever thread makes it; the last numbers if none is being made.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller; progress->struct_size says how much is written.
/// Errors: ARGUMENT (null, progress not initialised), HANDLE.
jostle_status jostle_planner_progress(const struct jostle_planner *planner,
                                      struct jostle_progress *progress);

/// Starts a decision in the background: as jostle_planner_solve, without waiting. Until it ends, other calls on the
/// planner return JOSTLE_ERROR_BUSY.
///
/// Thread: exclusive use of planner, shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *job and frees it with jostle_job_free.
/// Errors: ARGUMENT (null, an option, zero target, target absent or not pickable, bodies that overlap, a gripper that a
/// network of the planner was not made for), HANDLE, BUSY, NOT_FOUND (target), STATE (no thread can be started), MEMORY,
/// POISONED, ABI. Later failures are the job's.
jostle_status jostle_planner_job_start(struct jostle_planner *planner,
                                       const struct jostle_scene *scene,
                                       struct jostle_body target,
                                       const struct jostle_solve_options *options,
                                       struct jostle_job **job);

/// Whether the job still runs, and how far it is. Does not wait.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: state, progress.
/// Owns: the caller; progress->struct_size says how much is written.
/// Errors: ARGUMENT (progress not initialised), HANDLE, STATE (it ran in the process that this one was forked from).
jostle_status jostle_job_poll(const struct jostle_job *job,
                              jostle_job_state *state,
                              struct jostle_progress *progress);

/// Waits at most `seconds` for the job's end; infinity (HUGE_VAL) waits for as long as it takes. Running out of time is
/// not an error: *state says which it was.
///
/// Thread: any, several at once.
/// RT: no (it waits).
/// Nullable: state.
/// Owns: nothing.
/// Errors: ARGUMENT (seconds negative or not a number), HANDLE, STATE (it ran in the process that this one was forked from).
jostle_status jostle_job_wait(const struct jostle_job *job,
                              double seconds,
                              jostle_job_state *state);

/// Asks the job to end, as a cancel flag would.
///
/// Thread: any, at any time.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_job_cancel(const struct jostle_job *job);

/// Takes the plan of a job that has ended, or returns the job's failure with its message.
///
/// Thread: any.
/// RT: no.
/// Nullable: none.
/// Owns: the caller owns *plan and frees it with jostle_plan_free; a job gives its plan once.
/// Errors: ARGUMENT (null), HANDLE, STATE (it still runs, or the plan was taken), and whatever failed in the job.
jostle_status jostle_job_take_plan(struct jostle_job *job,
                                   struct jostle_plan **plan);

/// Frees a job. One that still runs is cancelled, and the call waits for its end.
///
/// Thread: any.
/// RT: no (it may wait for as long as a cancel takes).
/// Nullable: job (does nothing).
/// Owns: the handle is dead afterwards; a plan that was not taken is lost.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_job_free(struct jostle_job *job);

/// Frees a plan.
///
/// Thread: any.
/// RT: no.
/// Nullable: plan (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_plan_free(struct jostle_plan *plan);

/// How the decision ended. Read it before anything else.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_plan_outcome(const struct jostle_plan *plan, jostle_outcome *outcome);

/// The name of an outcome, such as "solved"; "unknown outcome" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_outcome_name(jostle_outcome outcome);

/// Number of reasons why the plan is not solved; 0 for one that is, and for one that was cancelled.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_plan_reason_count(const struct jostle_plan *plan, size_t *count);

/// Copies one of the reasons why the plan is not solved, from 0: a sentence that says what is so and what to change;
/// `length` counts the closing zero. jostle_plan_json() has the same with its numbers.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written), NOT_FOUND (the plan has no such reason).
jostle_status jostle_plan_reason(const struct jostle_plan *plan,
                                 size_t index,
                                 char *buffer,
                                 size_t capacity,
                                 size_t *length);

/// Number of actions.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_plan_action_count(const struct jostle_plan *plan, size_t *count);

/// One action, from 0. Execute the first, observe, and plan again.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, NOT_FOUND (the plan has no such action).
jostle_status jostle_plan_action(const struct jostle_plan *plan,
                                 size_t index,
                                 struct jostle_action *action);

/// Copies all actions, in order.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written).
jostle_status jostle_plan_actions(const struct jostle_plan *plan,
                                  struct jostle_action *buffer,
                                  size_t capacity,
                                  size_t *count);

/// Copies the poses of one action of a rearrangement, from 0: where the body is picked and where it is placed, or all
/// waypoints of a drag. Between two of them the body moves straight and turns the shorter way round.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (the plan has no such action, or it is a push
/// or a grasp).
jostle_status jostle_plan_waypoints(const struct jostle_plan *plan,
                                    size_t index,
                                    struct jostle_pose2 *buffer,
                                    size_t capacity,
                                    size_t *count);

/// What the moves of a rearrangement cost: the way with its fixed parts in metres, and the robot's time in seconds.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: metres, seconds.
/// Owns: nothing.
/// Errors: ARGUMENT (null plan), HANDLE, NOT_FOUND (a plan of a retrieval).
jostle_status jostle_plan_cost(const struct jostle_plan *plan,
                               double *metres,
                               double *seconds);

/// The search's value of one action, from 0.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, NOT_FOUND (the plan has no such action).
jostle_status jostle_plan_value(const struct jostle_plan *plan, size_t index, double *value);

/// Copies the poses that the planner expects of all bodies after one action; after a grasp the grasped body is absent.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (the plan has no such action).
jostle_status jostle_plan_predicted(const struct jostle_plan *plan,
                                    size_t index,
                                    struct jostle_body_pose *buffer,
                                    size_t capacity,
                                    size_t *count);

/// Copies the first actions that were considered, best first.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written).
jostle_status jostle_plan_considered(const struct jostle_plan *plan,
                                     struct jostle_ranked_action *buffer,
                                     size_t capacity,
                                     size_t *count);

/// Where the bodies are expected after a first action that was considered (`index` as in jostle_plan_considered()), and
/// what it came to in perturbed worlds: the probability that the target is out after no more actions than the best plan
/// that begins so, and the mean number of actions. Both are 0 for an action that was not weighed in such worlds.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count), success_chance, expected_actions.
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (count was written), NOT_FOUND (no such action, or a plan that moves bodies to
/// goals).
jostle_status jostle_plan_explain(const struct jostle_plan *plan,
                                  size_t index,
                                  double *success_chance,
                                  double *expected_actions,
                                  struct jostle_body_pose *buffer,
                                  size_t capacity,
                                  size_t *count);

/// Sets every field to its default; `size` is sizeof(jostle_plan_statistics) as the caller was compiled.
/// jostle_plan_statistics_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_plan_statistics_init(struct jostle_plan_statistics *statistics,
                                          size_t size);

/// What the decision took.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller; statistics->struct_size says how much is written.
/// Errors: ARGUMENT (null, statistics not initialised), HANDLE.
jostle_status jostle_plan_get_statistics(const struct jostle_plan *plan,
                                         struct jostle_plan_statistics *statistics);

/// A hash of outcome, actions and predicted poses: equal plans have equal hashes. Within a limit of iterations it is
/// the same at any number of threads.
///
/// Thread: shared use of plan.
/// RT: yes.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE.
jostle_status jostle_plan_hash(const struct jostle_plan *plan,
                               uint64_t *hash);

/// Copies the plan as JSON text; `length` counts the closing zero. Bodies are named by their indices in the scene.
///
/// Thread: shared use of plan.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the length).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUFFER (length was written).
jostle_status jostle_plan_json(const struct jostle_plan *plan,
                               char *buffer,
                               size_t capacity,
                               size_t *length);

/// Sets every field to its default; `size` is sizeof(jostle_simulator_options) as the caller was compiled.
/// jostle_simulator_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_simulator_options_init(struct jostle_simulator_options *options,
                                            size_t size);

/// Makes a world that begins where `scene` is; later changes of the scene do not reach it. With a zero target every
/// pickable body may be taken.
///
/// Thread: any; shared use of scene for a moment.
/// RT: no.
/// Nullable: options (all defaults).
/// Owns: the caller owns *simulator and frees it with jostle_simulator_free; `options` is copied.
/// Errors: ARGUMENT (null, an option: the message names it, target absent or not pickable, bodies that overlap), HANDLE, BUSY, NOT_FOUND (target, engine, preset), UNSUPPORTED, POISONED, MEMORY, ABI.
jostle_status jostle_simulator_new(const struct jostle_context *context,
                                   const struct jostle_scene *scene,
                                   struct jostle_body target,
                                   const struct jostle_simulator_options *options,
                                   struct jostle_simulator **simulator);

/// Frees a simulator.
///
/// Thread: any.
/// RT: no.
/// Nullable: simulator (does nothing).
/// Owns: the handle is dead afterwards.
/// Errors: none returned; a dead handle leaves a message in jostle_last_error().
void jostle_simulator_free(struct jostle_simulator *simulator);

/// Sets every field to its default; `size` is sizeof(jostle_execute_options) as the caller was compiled.
/// jostle_execute_options_default() in this header does it for you.
///
/// Thread: any.
/// RT: yes.
/// Nullable: none.
/// Owns: the caller.
/// Errors: ARGUMENT (null, a size that no version has).
jostle_status jostle_execute_options_init(struct jostle_execute_options *options,
                                          size_t size);

/// Executes an action and says what it did. It takes as long as the engine needs (in "bullet" seconds with many bodies):
/// jostle_simulator_execute_within() has a limit and can be cancelled.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: none.
/// Owns: `action` is copied.
/// Errors: ARGUMENT (null, not finite, unknown kind), HANDLE, BUSY, NOT_FOUND (action.body), UNSUPPORTED, PANIC,
/// POISONED.
jostle_status jostle_simulator_execute(struct jostle_simulator *simulator,
                                       const struct jostle_action *action,
                                       jostle_effect *effect);

/// The same within a limit: where the action is not finished when the time is up, or when it is cancelled, the effect is
/// JOSTLE_EFFECT_INTERRUPTED and the world is as it was before.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: options (all defaults: no limit).
/// Owns: `action` and `options` are copied.
/// Errors: ARGUMENT (null, not finite, unknown kind, an option: the message names it), HANDLE, BUSY, NOT_FOUND
/// (action.body), UNSUPPORTED, PANIC, POISONED, ABI. Running into the limit and being cancelled are effects.
jostle_status jostle_simulator_execute_within(struct jostle_simulator *simulator,
                                              const struct jostle_action *action,
                                              const struct jostle_execute_options *options,
                                              jostle_effect *effect);

/// The name of an effect, such as "pushed"; "unknown effect" for other numbers.
///
/// Thread: any.
/// RT: yes.
/// Nullable: never returns null.
/// Owns: the library, for ever.
/// Errors: none.
const char *jostle_effect_name(jostle_effect effect);

/// Copies what a camera reports now: the poses of all bodies, with new noise in every call. It fits
/// jostle_scene_update.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count, and takes no look).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
jostle_status jostle_simulator_observe(struct jostle_simulator *simulator,
                                       struct jostle_body_pose *buffer,
                                       size_t capacity,
                                       size_t *count);

/// Copies where all bodies really are.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: buffer (with capacity 0: asks for the count).
/// Owns: the caller owns the buffer.
/// Errors: ARGUMENT (null), HANDLE, BUSY, BUFFER (count was written), POISONED.
jostle_status jostle_simulator_poses(struct jostle_simulator *simulator,
                                     struct jostle_body_pose *buffer,
                                     size_t capacity,
                                     size_t *count);

/// Writes 1 to *left if the target, or in a world without one any body, is outside of the workspace, by the workspace's
/// rule, else 0.
///
/// Thread: exclusive use of simulator.
/// RT: no.
/// Nullable: none.
/// Owns: nothing.
/// Errors: ARGUMENT (null), HANDLE, BUSY, POISONED.
jostle_status jostle_simulator_target_left(struct jostle_simulator *simulator,
                                           uint32_t *left);

/// Version of this header; jostle_version() says the library's.
#define JOSTLE_VERSION "0.1.0"
#define JOSTLE_VERSION_MAJOR 0
#define JOSTLE_VERSION_MINOR 1
#define JOSTLE_VERSION_PATCH 0
/// To compare with jostle_version_number().
#define JOSTLE_VERSION_NUMBER (0 * 10000 + 1 * 100 + 0)

/// Whether two bodies are the same.
#define JOSTLE_BODY_EQ(a, b) ((a).id == (b).id)

/// All defaults, with the size that this header knows.
static inline jostle_context_options jostle_context_options_default(void) {
    jostle_context_options value;
    jostle_context_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_body_def jostle_body_def_default(void) {
    jostle_body_def value;
    jostle_body_def_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_gripper jostle_gripper_default(void) {
    jostle_gripper value;
    jostle_gripper_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_tip_path jostle_tip_path_default(void) {
    jostle_tip_path value;
    jostle_tip_path_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_workspace jostle_workspace_default(void) {
    jostle_workspace value;
    jostle_workspace_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_goal jostle_goal_default(void) {
    jostle_goal value;
    jostle_goal_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_camera_image jostle_camera_image_default(void) {
    jostle_camera_image value;
    jostle_camera_image_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_image_options jostle_image_options_default(void) {
    jostle_image_options value;
    jostle_image_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_planner_options jostle_planner_options_default(void) {
    jostle_planner_options value;
    jostle_planner_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_solve_options jostle_solve_options_default(void) {
    jostle_solve_options value;
    jostle_solve_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_progress jostle_progress_default(void) {
    jostle_progress value;
    jostle_progress_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_plan_statistics jostle_plan_statistics_default(void) {
    jostle_plan_statistics value;
    jostle_plan_statistics_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_simulator_options jostle_simulator_options_default(void) {
    jostle_simulator_options value;
    jostle_simulator_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_execute_options jostle_execute_options_default(void) {
    jostle_execute_options value;
    jostle_execute_options_init(&value, sizeof value);
    return value;
}

/// All defaults, with the size that this header knows.
static inline jostle_model_options jostle_model_options_default(void) {
    jostle_model_options value;
    jostle_model_options_init(&value, sizeof value);
    return value;
}

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* JOSTLE_JOSTLE_H */
