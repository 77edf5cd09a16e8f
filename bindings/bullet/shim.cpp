// The C interface: checks arguments, catches exceptions. No state of its own.

#include "shim.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "world.h"

namespace {

template <typename F>
jostle_bt_status guarded(F &&body) noexcept
{
    try {
        return body();
    } catch (const std::bad_alloc &) {
        return JOSTLE_BT_NO_MEMORY;
    } catch (...) {
        return JOSTLE_BT_EXCEPTION;
    }
}

jostle_bt_status read(const btMultiBody &base, jostle_bt_motion &out)
{
    const btVector3 &position = base.getBasePos();
    const btQuaternion rotation = base.getWorldToBaseRot().inverse();
    const btVector3 linear = base.getBaseVel(), angular = base.getBaseOmega();
    for (int i = 0; i < 3; i++) {
        out.position[i] = position[i];
        out.linear[i] = linear[i];
        out.angular[i] = angular[i];
    }
    for (int i = 0; i < 4; i++) out.rotation[i] = rotation[i];
    return JOSTLE_BT_OK;
}

}  // namespace

extern "C" {

jostle_bt_status jostle_bt_world_new(const jostle_bt_settings *settings, jostle_bt_world **out)
{
    if (!settings || !out) return JOSTLE_BT_BAD_ARGUMENT;
    *out = nullptr;
    return guarded([&] {
        *out = new jostle_bt_world(*settings);
        return JOSTLE_BT_OK;
    });
}

void jostle_bt_world_free(jostle_bt_world *world)
{
    guarded([&] {
        delete world;
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_add_body(jostle_bt_world *world, const jostle_bt_body_def *def)
{
    if (!world || !def || !def->points || !def->piece_sizes || def->piece_count == 0) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        world->add_body(*def);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_add_box(jostle_bt_world *world, const jostle_bt_box_def *def)
{
    if (!world || !def) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        world->add_box(*def);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_place_bodies(jostle_bt_world *world)
{
    if (!world) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        for (auto &body : world->bodies) world->place(*body, body->position, body->rotation);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_move_box(jostle_bt_world *world, uint32_t box, const jostle_bt_motion *motion)
{
    if (!world || !motion || box >= world->boxes.size()) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        world->move_box(*world->boxes[box], *motion);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_remove_box(jostle_bt_world *world, uint32_t box)
{
    if (!world || box >= world->boxes.size()) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        world->remove_box(*world->boxes[box]);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_step(jostle_bt_world *world)
{
    if (!world) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        world->world->stepSimulation(world->settings.time_step, 0);
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_body(const jostle_bt_world *world, uint32_t body, jostle_bt_motion *out)
{
    if (!world || !out || body >= world->bodies.size()) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] { return read(*world->bodies[body]->base, *out); });
}

jostle_bt_status jostle_bt_box(const jostle_bt_world *world, uint32_t box, jostle_bt_motion *out)
{
    if (!world || !out || box >= world->boxes.size()) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] { return read(*world->boxes[box]->base, *out); });
}

jostle_bt_status jostle_bt_contacts(const jostle_bt_world *world, uint32_t box, double within, uint8_t *touching,
                                    double *force, uint32_t count)
{
    if (!world || !touching || box >= world->boxes.size()) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        const btCollisionObject *mine = world->boxes[box]->collider.get();
        const int manifolds = world->dispatcher.getNumManifolds();
        for (int i = 0; i < manifolds; i++) {
            const btPersistentManifold *manifold =
                const_cast<btCollisionDispatcher &>(world->dispatcher).getManifoldByIndexInternal(i);
            const btCollisionObject *other = nullptr;
            if (manifold->getBody0() == mine) other = manifold->getBody1();
            if (manifold->getBody1() == mine) other = manifold->getBody0();
            if (!other || other->getUserIndex() < 0 || uint32_t(other->getUserIndex()) >= count) continue;
            for (int k = 0; k < manifold->getNumContacts(); k++) {
                const btManifoldPoint &point = manifold->getContactPoint(k);
                if (point.getDistance() > within) continue;
                touching[other->getUserIndex()] = 1;
                if (force) force[other->getUserIndex()] += point.m_appliedImpulse / world->settings.time_step;
            }
        }
        return JOSTLE_BT_OK;
    });
}

jostle_bt_status jostle_bt_hull(const double *points, uint32_t count, double margin, double *out, uint32_t capacity,
                                uint32_t *written)
{
    if (!points || !out || !written) return JOSTLE_BT_BAD_ARGUMENT;
    return guarded([&] {
        auto hull = jostle_bt::make_hull(points, count, margin);
        *written = std::min(uint32_t(hull->getNumPoints()), capacity);
        for (uint32_t i = 0; i < *written; i++)
            for (int k = 0; k < 3; k++) out[3 * i + k] = hull->getUnscaledPoints()[i][k];
        return JOSTLE_BT_OK;
    });
}

}  // extern "C"
