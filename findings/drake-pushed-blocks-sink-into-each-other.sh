#!/usr/bin/env bash
# Drake 1.51.1, 2026-11-30.
# One would guess: of three blocks of 45 mm in a row, the first pushed at its middle by 50 mm, the centres are 45 mm
# apart afterwards too, within the millimetre or less that compliant contacts of bodies of this weight yield.
# What is so: by default (point contact, steps of 1 ms) neighbours end 9 and 17 mm in each other. Two faces that meet
# flush have one contact point, which jumps from corner to corner from step to step. With steps of 0.25 ms, or with
# compliant hydroelastic contact, they stay apart.
# Why it matters: pushes of packed blocks, which planners for clutter are about, end with blocks inside of blocks, and
# no error says so. Look at the depth of contacts after every push, take short steps, or use hydroelastic contact.
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
from importlib.metadata import version
from pydrake.geometry import (AddCompliantHydroelasticProperties, AddContactMaterial, AddRigidHydroelasticProperties, Box,
                              HalfSpace, ProximityProperties)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

SIDE, SPEED, GAP, WAY = 0.045, 0.13, 0.01, 0.05

def push(step, hydroelastic):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=step), builder)

    def add(body, shape, rigid=False):
        properties = ProximityProperties()
        AddContactMaterial(None, None, CoulombFriction(0.5, 0.5), properties)
        if hydroelastic and rigid:
            AddRigidHydroelasticProperties(0.01, properties)
        elif hydroelastic:
            AddCompliantHydroelasticProperties(0.01, 1e6, properties)
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, "shape", properties)

    add(plant.world_body(), HalfSpace(), rigid=True)
    blocks = [plant.AddRigidBody(f"block{k}", SpatialInertia(0.1, [0, 0, 0], UnitInertia.SolidBox(SIDE, SIDE, SIDE)))
              for k in range(3)]
    for block in blocks:
        add(block, Box(SIDE, SIDE, SIDE))
    tip = plant.AddRigidBody("tip", SpatialInertia(100, [0, 0, 0], UnitInertia.SolidBox(1, 1, 1)))
    add(tip, Box(0.02, 0.03, 0.04), rigid=True)
    start = RigidTransform([-SIDE / 2 - GAP - 0.01, 0, 0.03])
    before = plant.AddFrame(FixedOffsetFrame("before", plant.world_frame(), start))
    joint = plant.AddJoint(PrismaticJoint("push", before, tip.body_frame(), [1, 0, 0]))
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for k, block in enumerate(blocks):
        plant.SetFreeBodyPose(context, block, RigidTransform([k * SIDE, 0, SIDE / 2]))
    steps = round((GAP + WAY) / SPEED / step)
    for k in range(steps):
        joint.set_translation(context, k * step * SPEED)
        joint.set_translation_rate(context, SPEED)
        simulator.AdvanceTo((k + 1) * step)
    places = [plant.EvalBodyPoseInWorld(context, block).translation()[0] for block in blocks]
    return [b - a for a, b in zip(places, places[1:])]

found = {"point contact, 1 ms": push(0.001, False), "point contact, 0.25 ms": push(0.00025, False),
         "hydroelastic, 1 ms": push(0.001, True)}
for name, apart in found.items():
    print(f"drake {version('drake')}, {name}: neighbours' centres are {', '.join(f'{1000 * d:.1f}' for d in apart)} mm apart "
          "(45 before the push)")
others = [min(apart) for name, apart in found.items() if name != "point contact, 1 ms"]
sunk = min(found["point contact, 1 ms"]) < 0.040
raise SystemExit(not (MultibodyPlantConfig().time_step == 0.001 and sunk and min(others) > 0.043))
PYTHON
