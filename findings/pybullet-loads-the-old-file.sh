#!/usr/bin/env bash
# PyBullet 3.2.7, 2026-11-30.
# One would guess: loadURDF reads the file that it is given, at the latest after resetSimulation.
# What is so: a file is read once and kept under its name. One that was written anew in between is not looked at again, before
# and after resetSimulation; only a new connection or setPhysicsEngineParameter(enableFileCaching=0) sees it. Meshes too.
# Why it matters: generators of scenes and of randomised bodies write one file name again and again, and then simulate the
# first body for ever, without a word. Give every body a name of its own, or turn the cache off.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
from itertools import product

import pybullet as p


def write(side):
    """A body of two shapes: a box in the file itself, and a mesh beside it."""
    open("body.urdf", "w").write(f"""<robot name="r"><link name="b"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><box size="{side} {side} {side}"/></geometry></collision></link></robot>""")
    corners = ["v %g %g %g\n" % tuple(s * side / 2 for s in signs) for signs in product((-1, 1), repeat=3)]
    faces = [(1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2),
             (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4)]
    open("body.obj", "w").writelines(corners + ["f %d %d %d\n" % face for face in faces])


def sizes():
    """Extents along x of what the two files hold, mm."""
    mesh = p.createMultiBody(1, p.createCollisionShape(p.GEOM_MESH, fileName="body.obj"))
    boxes = [p.getAABB(body) for body in (p.loadURDF("body.urdf"), mesh)]
    return [round((high[0] - low[0]) * 1e3) for low, high in boxes]


p.connect(p.DIRECT)
write(0.1)
first = sizes()
write(0.4)
again = sizes()
p.resetSimulation()
reset = sizes()
p.setPhysicsEngineParameter(enableFileCaching=0)
uncached = sizes()
print(f"pybullet {version('pybullet')}: 100 mm written and read as {first} mm; 400 mm written and read as {again}, "
      f"after resetSimulation as {reset}, without the cache as {uncached}")
raise SystemExit(not (first == again == reset and uncached[0] > 390))
PYTHON
