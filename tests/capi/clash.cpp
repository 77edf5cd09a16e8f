// A host that uses Bullet itself. Built against the single-precision library, the double-precision one, or none
// (-DNO_BULLET). Prints how far its own box fell and what jostle's engine says.
#include <cmath>
#include <cstdio>
#include <cstring>

#include <jostle/jostle.h>

#ifndef NO_BULLET
#include <btBulletDynamicsCommon.h>

static double fall()
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity(btVector3(0, 0, -10));
    btBoxShape shape(btVector3(1, 1, 1));
    btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(1, 1, 1)));
    world.addRigidBody(&body);
    for (int i = 0; i < 100; i++) world.stepSimulation(btScalar(0.01), 0);
    const double z = body.getWorldTransform().getOrigin().z();
    world.removeRigidBody(&body);
    return -z;
}
#else
static double fall() { return 5; }
#endif

int main()
{
    const double fallen = fall();
    std::printf("own box: %s\n", std::fabs(fallen - 5) < 0.2 ? "fell" : "WRONG");

    jostle_context *context = nullptr;
    jostle_scene *scene = nullptr;
    jostle_simulator *simulator = nullptr;
    jostle_context_new(nullptr, &context);
    jostle_scene_new(context, &scene);
    const jostle_vec2 square[4] = {{-.0225, -.0225}, {.0225, -.0225}, {.0225, .0225}, {-.0225, .0225}};
    jostle_body_def def = jostle_body_def_default();
    def.points = square;
    def.point_count = 4;
    def.pose.p.x = 0.5;
    jostle_body body;
    jostle_scene_add_body(scene, &def, &body);
    jostle_simulator_options options = jostle_simulator_options_default();
    options.engine = "bullet";
    options.preset = "fast";
    const jostle_status status = jostle_simulator_new(context, scene, body, &options, &simulator);
    if (status == JOSTLE_OK)
        std::puts("engine: made");
    else
        std::printf("engine: refused as %s: %s\n", status == JOSTLE_ERROR_UNSUPPORTED ? "unsupported" : "WRONG",
                    jostle_last_error());
    jostle_simulator_free(simulator);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return 0;
}
