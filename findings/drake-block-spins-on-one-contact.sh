#!/usr/bin/env bash
# Drake 1.51.1, 2026-11-30.
# One would guess: a 45 mm block that spins at 5 rad/s on a table with friction 0.5 stops within 0.02 to 0.03 s, after 3
# degrees, as patch friction has it (MuJoCo, PyBullet and PhysX agree).
# What is so: with the default contact model and no hydroelastic properties a box on a half space has one contact point,
# so hardly any moment: it spins for seconds and turns by tens of degrees. On four small spheres it stops within 0.01 s.
# Why it matters: pushes off the centre turn far too much. Before judging planar pushes, put small spheres under the corners
# and look at the number of contacts.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import logging
import warnings
warnings.filterwarnings("ignore")
logging.getLogger("drake").setLevel(logging.ERROR)
import pydrake
from pydrake.geometry import Box, HalfSpace, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

def spin(spheres):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.001)
    friction = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", friction)
    side = 0.045
    block = plant.AddRigidBody("block", SpatialInertia(0.1, [0, 0, 0], UnitInertia.SolidBox(side, side, side)))
    if spheres:
        for i in range(4):
            at = [(0.5 if i & 1 else -0.5) * side, (0.5 if i & 2 else -0.5) * side, 0.001 - side / 2]
            plant.RegisterCollisionGeometry(block, RigidTransform(at), Sphere(0.001), f"foot{i}", friction)
    else:
        plant.RegisterCollisionGeometry(block, RigidTransform(), Box(side, side, side), "box", friction)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, block, RigidTransform([0, 0, side / 2]))
    simulator.AdvanceTo(0.2)
    contacts = plant.get_contact_results_output_port().Eval(context).num_point_pair_contacts()
    yaw = lambda: RollPitchYaw(plant.EvalBodyPoseInWorld(context, block).rotation()).yaw_angle()
    turned = -yaw()
    plant.SetFreeBodySpatialVelocity(context=context, body=block, V_JpJc=SpatialVelocity([0, 0, 5.0], [0, 0, 0]))
    time = 0.2
    while time < 3.0:
        time += 0.005
        simulator.AdvanceTo(time)
        if abs(plant.EvalBodySpatialVelocityInWorld(context, block).rotational()[2]) < 0.25:
            break
    return contacts, time - 0.2, abs(turned + yaw()) * 57.2958

version = pydrake.__version__ if hasattr(pydrake, "__version__") else "1.51.1"
one, feet = spin(False), spin(True)
for name, (contacts, seconds, degrees) in (("box", one), ("four spheres", feet)):
    print(f"drake {version}, {name}: {contacts} contact points, stops after {seconds:.3f} s and {degrees:.1f} degrees")
raise SystemExit(not (one[0] == 1 and one[1] > 0.5 and feet[1] < 0.06))
PYTHON
