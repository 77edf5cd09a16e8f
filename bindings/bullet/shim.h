/*
 * What jostle needs of the Bullet physics library, as plain C. Internal: no header that users see includes it.
 *
 * Rules: SI units, right-handed axes, z up; quaternions are x, y, z, w. Every call that can fail returns a
 * jostle_bt_status; no C++ exception leaves. A world belongs to one thread at a time, different worlds are independent.
 * Body and box numbers are those that the add functions gave, in order of adding.
 */
#ifndef JOSTLE_BULLET_SHIM_H
#define JOSTLE_BULLET_SHIM_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum jostle_bt_status {
    JOSTLE_BT_OK = 0,
    JOSTLE_BT_BAD_ARGUMENT = 1,
    JOSTLE_BT_NO_MEMORY = 2,
    JOSTLE_BT_EXCEPTION = 3,
    /* The process has another build of Bullet in the place of the double-precision one. */
    JOSTLE_BT_WRONG_LIBRARY = 4
} jostle_bt_status;

typedef enum jostle_bt_solver {
    /* Bullet's own. */
    JOSTLE_BT_SOLVER_BULLET = 0,
    /* Compact rows, the same operations in the same order: the same bits. */
    JOSTLE_BT_SOLVER_COMPACT = 1,
    /* Compact rows; the friction cone by a square root in place of three trigonometric functions. */
    JOSTLE_BT_SOLVER_COMPACT_ROOT = 2
} jostle_bt_solver;

typedef enum jostle_bt_ground {
    JOSTLE_BT_GROUND_BOX = 0,
    JOSTLE_BT_GROUND_PLANE = 1
} jostle_bt_ground;

typedef struct jostle_bt_settings {
    double time_step;
    double gravity;
    double erp;
    double friction_erp;
    double linear_slop;
    double residual;
    double warm_start;
    double contact_processing; /* metres; 0 or less: Bullet's default */
    double margin;             /* collision margin of every shape, metres */
    double ground_height;      /* metres */
    double ground_friction;
    double ground_restitution;
    int32_t iterations;
    int32_t solver; /* jostle_bt_solver */
    int32_t ground; /* jostle_bt_ground */
} jostle_bt_settings;

typedef struct jostle_bt_body_def {
    double mass;
    double inertia[3]; /* about the body frame's axes; its origin is the centre of mass */
    double friction;
    double rolling_friction;
    double spinning_friction;
    double position[3];
    double rotation[4];
    /* Convex pieces: x, y, z of piece after piece, piece_sizes[i] points each. */
    const double *points;
    const uint32_t *piece_sizes;
    uint32_t piece_count;
} jostle_bt_body_def;

/* A box that is moved from outside: a push tip or a finger. */
typedef struct jostle_bt_box_def {
    double half[3];
    double mass; /* kilograms; a box is never turned by contacts */
    double friction;
    int32_t kinematic; /* 0: a heavy body whose pose and velocity are set; 1: Bullet's kinematic kind */
} jostle_bt_box_def;

typedef struct jostle_bt_motion {
    double position[3];
    double rotation[4];
    double linear[3];
    double angular[3];
} jostle_bt_motion;

typedef struct jostle_bt_world jostle_bt_world;

/* Checks that the calls of this library reach the double-precision Bullet. Writes the path of the library that is in
 * the way (or an empty text) to `found`, whose size is `size`. */
jostle_bt_status jostle_bt_check(char *found, uint32_t size);

jostle_bt_status jostle_bt_world_new(const jostle_bt_settings *settings, jostle_bt_world **out);
void jostle_bt_world_free(jostle_bt_world *world);

jostle_bt_status jostle_bt_add_body(jostle_bt_world *world, const jostle_bt_body_def *def);
/* Starts out of the way, 5 m up. */
jostle_bt_status jostle_bt_add_box(jostle_bt_world *world, const jostle_bt_box_def *def);
/* Sets every body's pose once more, as a client that creates first and places then does. */
jostle_bt_status jostle_bt_place_bodies(jostle_bt_world *world);
/* Where a box is after a step: contacts may have held it back. */
jostle_bt_status jostle_bt_box(const jostle_bt_world *world, uint32_t box, jostle_bt_motion *out);
/* Sets a box's pose and velocity; to be called before every step for a box that moves. */
jostle_bt_status jostle_bt_move_box(jostle_bt_world *world, uint32_t box, const jostle_bt_motion *motion);
/* Takes a box out of the world. */
jostle_bt_status jostle_bt_remove_box(jostle_bt_world *world, uint32_t box);

jostle_bt_status jostle_bt_step(jostle_bt_world *world);

jostle_bt_status jostle_bt_body(const jostle_bt_world *world, uint32_t body, jostle_bt_motion *out);

/* What a box touches: touching[i] becomes 1 if body i and the box are in contact (no farther apart than `within`,
 * margins included) and stays as it is otherwise; `count` is the size of `touching`. `force` (may be null) gets the
 * same way the normal impulse of the last step over the time step, newton, added up. */
jostle_bt_status jostle_bt_contacts(const jostle_bt_world *world, uint32_t box, double within, uint8_t *touching,
                                    double *force, uint32_t count);

/* A convex hull's corners after Bullet has taken it in: for a test of what the compiler does to single precision. */
jostle_bt_status jostle_bt_hull(const double *points, uint32_t count, double margin, double *out, uint32_t capacity,
                                uint32_t *written);

#ifdef __cplusplus
}
#endif

#endif
