#!/usr/bin/env bash
# PyBullet 3.2.7 (PyPI wheel), 2026-11-30.
# One would guess: a cube of 45 mm from a mesh (a convex hull) that spins at 20 rad/s on the ground with friction 0.55
# stops within 0.05 s and 30 degrees, on the plane of plane.urdf as on a GEOM_PLANE, and as a box primitive does.
# What is so: plane.urdf collides as a box of 200 m. On it the hull rests on one contact point (a new one a step,
# found by GJK and dropped again), has hardly any friction torque and spins for seconds, over six turns and more. On a
# GEOM_PLANE the same hull, and on plane.urdf the box primitive, stop within 30 degrees.
# Why it matters: meshes on plane.urdf are what most scenes of blocks are. How far a body turns after a push, or what
# torque the ground takes up, depends on the file of the ground. Take createCollisionShape(GEOM_PLANE) for the ground.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import math
from importlib.metadata import version
import pybullet as p
import pybullet_data

HALF, STEP = 0.0225, 1 / 240
corners = [(x, y, z) for z in (-HALF, HALF) for x, y in ((-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF))]
sides = [(1, 4, 3, 2), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]
with open("cube.obj", "w") as file:
    file.writelines(f"v {x} {y} {z}\n" for x, y, z in corners)
    file.writelines(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in sides)
SHAPES = {"mesh": '<mesh filename="cube.obj"/>', "box": f'<box size="{2 * HALF} {2 * HALF} {2 * HALF}"/>'}
p.connect(p.DIRECT)
p.setAdditionalSearchPath(pybullet_data.getDataPath())

def spin(shape, ground):
    p.resetSimulation()
    p.setGravity(0, 0, -9.8)
    plane = p.loadURDF("plane.urdf") if ground == "plane.urdf" else p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
    with open(f"{shape}.urdf", "w") as file:
        file.write(f'<robot name="r"><link name="b"><inertial><mass value="0.1"/><inertia ixx="3.4e-5" iyy="3.4e-5" '
                   f'izz="3.4e-5" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>{SHAPES[shape]}</geometry>'
                   '</collision></link></robot>')
    block = p.loadURDF(f"{shape}.urdf", [0, 0, 0.024], flags=p.URDF_USE_INERTIA_FROM_FILE)
    p.changeDynamics(plane, -1, lateralFriction=1.1)
    p.changeDynamics(block, -1, lateralFriction=0.5)
    for _ in range(480):
        p.stepSimulation()
    contacts = len(p.getContactPoints(block, plane))
    p.resetBaseVelocity(block, [0, 0, 0], [0, 0, 20.0])
    turned, steps = 0.0, 0
    while (speed := p.getBaseVelocity(block)[1][2]) > 0.5 and steps < 1200:
        p.stepSimulation()
        turned, steps = turned + speed * STEP, steps + 1
    return contacts, steps * STEP, math.degrees(turned)

results = {(shape, ground): spin(shape, ground) for shape in SHAPES for ground in ("plane.urdf", "GEOM_PLANE")}
for (shape, ground), (contacts, seconds, degrees) in results.items():
    print(f"pybullet {version('pybullet')}, {shape} on {ground}: {contacts} contact points at rest, from 20 to 0.5 rad/s in "
          f"{seconds:.2f} s and {degrees:.0f} degrees")
others = [degrees for key, (_, _, degrees) in results.items() if key != ("mesh", "plane.urdf")]
raise SystemExit(not (results["mesh", "plane.urdf"][2] > 720 and max(others) < 40))
PYTHON
