// Finds out whether our calls reach the Bullet that we were compiled for.
//
// Single- and double-precision Bullet export the same names. In a process whose program links the single-precision
// library the loader may bind our calls to that one, and then every number is wrong without any error. So we look where
// a few names of each library lead: functions, and tables of virtual functions.

#include <dlfcn.h>

#include <cstring>
#include <new>

#include "world.h"

// Tables of virtual functions have no name in C++; these are those that the compiler gives them.
extern "C" {
extern const char jostle_bt_vtable_world[] __asm__("_ZTV24btMultiBodyDynamicsWorld");
extern const char jostle_bt_vtable_solver[] __asm__("_ZTV27btMultiBodyConstraintSolver");
extern const char jostle_bt_vtable_hull[] __asm__("_ZTV17btConvexHullShape");
extern const char jostle_bt_vtable_compound[] __asm__("_ZTV15btCompoundShape");
extern const char jostle_bt_vtable_dispatcher[] __asm__("_ZTV21btCollisionDispatcher");
}

namespace {

template <typename Member>
const void *address(Member member)
{
    // A pointer to a member function that is not virtual begins with the function's address (Itanium C++ ABI).
    const void *where = nullptr;
    std::memcpy(&where, &member, sizeof where);
    return where;
}

const char *file_of(const void *where)
{
    Dl_info info;
    return dladdr(const_cast<void *>(where), &info) && info.dli_fname ? info.dli_fname : "an unknown file";
}

}  // namespace

extern "C" jostle_bt_status jostle_bt_check(char *found, uint32_t size)
{
    if (!found || size == 0) return JOSTLE_BT_BAD_ARGUMENT;
    found[0] = '\0';
    const void *const places[] = {
        reinterpret_cast<const void *>(&btAlignedAllocInternal),      // LinearMath
        address(&btConvexHullShape::addPoint),                        // Collision
        address(&btCompoundShape::addChildShape),                     // Collision
        address(&btMultiBody::finalizeMultiDof),                      // Dynamics
        address(&btMultiBody::forwardKinematics),                     // Dynamics
        jostle_bt_vtable_hull,
        jostle_bt_vtable_compound,
        jostle_bt_vtable_dispatcher,
        jostle_bt_vtable_world,
        jostle_bt_vtable_solver,
    };
    for (const void *place : places) {
        const char *file = file_of(place);
        if (std::strstr(file, "-float64")) continue;
        std::strncpy(found, file, size - 1);
        found[size - 1] = '\0';
        return JOSTLE_BT_WRONG_LIBRARY;
    }
    return JOSTLE_BT_OK;
}
