// The world behind the C interface. See shim.h for units and rules.
#ifndef JOSTLE_BULLET_WORLD_H
#define JOSTLE_BULLET_WORLD_H

#include <cstdint>
#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletCollisionCommon.h>

#include "shim.h"

namespace jostle_bt {

// One body: its shapes, the multibody (a base without links) and its collider.
struct Body {
    std::vector<std::unique_ptr<btCollisionShape>> pieces;
    std::unique_ptr<btCollisionShape> shape;
    std::unique_ptr<btMultiBody> base;
    std::unique_ptr<btMultiBodyLinkCollider> collider;
    btVector3 position;
    btQuaternion rotation;
    bool present = true;
};

std::unique_ptr<btConvexHullShape> make_hull(const double *points, uint32_t count, double margin);

// A solver with the same results and less memory traffic (solver.cpp).
std::unique_ptr<btMultiBodyConstraintSolver> make_compact_solver(bool root);

}  // namespace jostle_bt

// Members are destroyed from the last to the first: bodies after the world that refers to them was emptied.
struct jostle_bt_world {
    explicit jostle_bt_world(const jostle_bt_settings &settings);
    ~jostle_bt_world();
    jostle_bt_world(const jostle_bt_world &) = delete;
    jostle_bt_world &operator=(const jostle_bt_world &) = delete;

    void add_body(const jostle_bt_body_def &def);
    void add_box(const jostle_bt_box_def &def);
    void place(jostle_bt::Body &body, const btVector3 &position, const btQuaternion &rotation);
    void move_box(jostle_bt::Body &box, const jostle_bt_motion &motion);
    void remove_box(jostle_bt::Body &box);

    jostle_bt_settings settings;
    std::vector<std::unique_ptr<jostle_bt::Body>> bodies;
    std::vector<std::unique_ptr<jostle_bt::Body>> boxes;
    jostle_bt::Body ground;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btDbvtBroadphase broadphase;
    std::unique_ptr<btMultiBodyConstraintSolver> solver;
    std::unique_ptr<btMultiBodyDynamicsWorld> world;
    btAlignedObjectArray<btQuaternion> scratch_rotations;
    btAlignedObjectArray<btVector3> scratch_positions;

private:
    void add(jostle_bt::Body &body, int group, int mask);
};

#endif
