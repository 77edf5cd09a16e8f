// Builds a world of prisms as PyBullet does, call for call, so that both go through the same arithmetic. What each
// setting is worth stands in docs/bullet.md.

#include "world.h"

#include <algorithm>

using jostle_bt::Body;

namespace {

// Moment of inertia of a box that is moved from outside, so great that contacts do not turn it within a step.
const btScalar BOX_INERTIA = 10000;

btVector3 vector(const double v[3]) { return btVector3(v[0], v[1], v[2]); }
btQuaternion quaternion(const double q[4]) { return btQuaternion(q[0], q[1], q[2], q[3]); }

btMultiBodyConstraintSolver *make_solver(int32_t kind)
{
    if (kind == JOSTLE_BT_SOLVER_COMPACT || kind == JOSTLE_BT_SOLVER_COMPACT_ROOT)
        return jostle_bt::make_compact_solver(kind == JOSTLE_BT_SOLVER_COMPACT_ROOT).release();
    return new btMultiBodyConstraintSolver;
}

// Bullet's margin of tree boxes is a global of Bullet, not of ours. With 0 (as PyBullet has it) pairs are met in
// PyBullet's order. Another user of the same library in this process sees slower tree updates, no other results.
void no_tree_margin()
{
    btScalar now, none = 0;
    __atomic_load(&gDbvtMargin, &now, __ATOMIC_RELAXED);
    if (now != none) __atomic_store(&gDbvtMargin, &none, __ATOMIC_RELAXED);
}

}  // namespace

namespace jostle_bt {

std::unique_ptr<btConvexHullShape> make_hull(const double *points, uint32_t count, double margin)
{
    std::unique_ptr<btConvexHullShape> hull(new btConvexHullShape);
    hull->setMargin(margin);
    for (uint32_t i = 0; i < count; i++) hull->addPoint(vector(points + 3 * i), false);
    hull->recalcLocalAabb();
    // No initializePolyhedralFeatures() here: with it blocks meet face to face in another way, and agreement falls
    // from 0.92 to 0.81.
    hull->optimizeConvexHull();
    return hull;
}

}  // namespace jostle_bt

jostle_bt_world::jostle_bt_world(const jostle_bt_settings &given)
    : settings(given), dispatcher(&configuration), solver(make_solver(given.solver))
{
    no_tree_margin();
    broadphase.setVelocityPrediction(0);
    world.reset(new btMultiBodyDynamicsWorld(&dispatcher, &broadphase, solver.get(), &configuration));
    world->setForceUpdateAllAabbs(false);
    world->setGravity(btVector3(0, 0, -settings.gravity));
    btContactSolverInfo &info = world->getSolverInfo();
    info.m_numIterations = settings.iterations;
    info.m_erp2 = settings.erp;
    info.m_frictionERP = settings.friction_erp;
    info.m_linearSlop = settings.linear_slop;
    info.m_leastSquaresResidualThreshold = settings.residual;
    info.m_minimumSolverBatchSize = 0;
    info.m_warmstartingFactor = settings.warm_start;

    if (settings.ground == JOSTLE_BT_GROUND_PLANE) {
        ground.shape.reset(new btStaticPlaneShape(btVector3(0, 0, 1), 0));
        ground.shape->setMargin(settings.margin);
        ground.position = btVector3(0, 0, settings.ground_height);
    } else {
        std::unique_ptr<btBoxShape> box(new btBoxShape(btVector3(100, 100, 5)));
        box->setMargin(settings.margin);
        std::unique_ptr<btCompoundShape> compound(new btCompoundShape);
        compound->setMargin(settings.margin);
        btTransform below = btTransform::getIdentity();
        below.setOrigin(btVector3(0, 0, -5));
        compound->addChildShape(below, box.get());
        ground.pieces.push_back(std::move(box));
        ground.shape = std::move(compound);
        ground.position = btVector3(0, 0, settings.ground_height);
    }
    ground.rotation = btQuaternion::getIdentity();
    ground.base.reset(new btMultiBody(0, 0, btVector3(0, 0, 0), true, true));
    ground.collider.reset(new btMultiBodyLinkCollider(ground.base.get(), -1));
    ground.collider->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    ground.collider->setFriction(settings.ground_friction);
    ground.collider->setRestitution(settings.ground_restitution);
    add(ground, btBroadphaseProxy::StaticFilter, btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
}

jostle_bt_world::~jostle_bt_world()
{
    if (!world) return;
    auto take = [this](Body &body) {
        if (!body.present || !body.base) return;
        world->removeMultiBody(body.base.get());
        world->removeCollisionObject(body.collider.get());
    };
    for (auto &box : boxes) take(*box);
    for (auto &body : bodies) take(*body);
    take(ground);
    world.reset();
}

void jostle_bt_world::add(Body &body, int group, int mask)
{
    body.collider->setCollisionShape(body.shape.get());
    if (settings.contact_processing > 0) body.collider->setContactProcessingThreshold(settings.contact_processing);
    body.base->setBaseCollider(body.collider.get());
    body.base->setBasePos(body.position);
    body.base->setWorldToBaseRot(body.rotation.inverse());
    body.collider->setWorldTransform(btTransform(body.rotation, body.position));
    world->addCollisionObject(body.collider.get(), group, mask);
    body.base->finalizeMultiDof();
    world->addMultiBody(body.base.get());
    place(body, body.position, body.rotation);
}

void jostle_bt_world::add_body(const jostle_bt_body_def &def)
{
    std::unique_ptr<Body> body(new Body);
    std::unique_ptr<btCompoundShape> compound(new btCompoundShape);
    compound->setMargin(settings.margin);
    const double *points = def.points;
    for (uint32_t i = 0; i < def.piece_count; i++) {
        std::unique_ptr<btConvexHullShape> hull = jostle_bt::make_hull(points, def.piece_sizes[i], settings.margin);
        compound->addChildShape(btTransform::getIdentity(), hull.get());
        body->pieces.push_back(std::move(hull));
        points += 3 * def.piece_sizes[i];
    }
    body->shape = std::move(compound);
    body->position = vector(def.position);
    body->rotation = quaternion(def.rotation);
    body->base.reset(new btMultiBody(0, def.mass, vector(def.inertia), false, true));
    body->collider.reset(new btMultiBodyLinkCollider(body->base.get(), -1));
    body->collider->setFriction(def.friction);
    body->collider->setRollingFriction(def.rolling_friction);
    body->collider->setSpinningFriction(def.spinning_friction);
    body->collider->setUserIndex(int(bodies.size()));
    bodies.push_back(std::move(body));
    add(*bodies.back(), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
}

void jostle_bt_world::add_box(const jostle_bt_box_def &def)
{
    std::unique_ptr<Body> box(new Body);
    box->shape.reset(new btBoxShape(vector(def.half)));
    box->shape->setMargin(settings.margin);
    box->position = btVector3(0, 0, 5);
    box->rotation = btQuaternion::getIdentity();
    box->base.reset(new btMultiBody(0, def.mass, btVector3(BOX_INERTIA, BOX_INERTIA, BOX_INERTIA), false, false));
    box->base->setLinearDamping(0);
    box->base->setAngularDamping(0);
    box->collider.reset(new btMultiBodyLinkCollider(box->base.get(), -1));
    box->collider->setFriction(def.friction);
    box->collider->setUserIndex(-1);
    boxes.push_back(std::move(box));
    Body &added = *boxes.back();
    add(added, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
    if (def.kinematic) added.base->setBaseDynamicType(btCollisionObject::CF_KINEMATIC_OBJECT);
}

void jostle_bt_world::place(Body &body, const btVector3 &position, const btQuaternion &rotation)
{
    body.base->setBasePos(position);
    // Not normalised, as PyBullet does not either.
    body.base->setWorldToBaseRot(rotation.inverse());
    body.base->forwardKinematics(scratch_rotations, scratch_positions);
    body.base->updateCollisionObjectWorldTransforms(scratch_rotations, scratch_positions);
    world->updateSingleAabb(body.collider.get());
}

void jostle_bt_world::move_box(Body &box, const jostle_bt_motion &motion)
{
    place(box, vector(motion.position), quaternion(motion.rotation));
    btVector3 velocity = vector(motion.linear);
    // The step adds gravity to a box that is not kinematic; what it is given makes up for that.
    if (!box.base->isBaseKinematic()) velocity.setZ(velocity.z() + settings.gravity * settings.time_step);
    box.base->setBaseVel(velocity);
    box.base->setBaseOmega(vector(motion.angular));
}

void jostle_bt_world::remove_box(Body &box)
{
    if (!box.present) return;
    world->removeMultiBody(box.base.get());
    world->removeCollisionObject(box.collider.get());
    box.present = false;
}
