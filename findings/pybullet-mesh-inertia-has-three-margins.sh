#!/usr/bin/env bash
# PyBullet 3.2.7, 2026-11-30.
# One would guess: a block has the same inertia whether its collision shape is a box or a mesh of the same eight corners, up
# to the margin of 1 mm, which vanishes next to the block.
# What is so: a mesh has the inertia of its bounding box grown by three margins on each side, 3 mm at any size; a box that is
# given an <origin> has one margin, a plain box none. For a cube of 45 mm the moment is 1.28 times, of 20 mm 1.69 times,
# of 10 mm 2.56 times the true one. The mesh is also met 1 mm early on each side, so two cubes that are 2 mm apart touch.
# Why it matters: how bodies turn when they are pushed depends on how their file was written, the more the smaller they are.
# Set localInertiaDiagonal with changeDynamics after loading.
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


def grown(name, geometry, side):
    """How far the box of the body's inertia reaches beyond the cube on each side, mm; times the true moment."""
    open(f"{name}.urdf", "w").write(f"""<robot name="r"><link name="b"><inertial><mass value="0.1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision>{geometry}</collision></link></robot>""")
    moment = p.getDynamicsInfo(p.loadURDF(f"{name}.urdf"), -1)[2][2]
    true = 0.1 * side**2 / 6
    return ((moment / 0.1 * 6) ** 0.5 - side) / 2 * 1e3, moment / true


p.connect(p.DIRECT)
right = True
for side in (0.045, 0.020, 0.010):
    corners = [[s * side / 2 for s in signs] for signs in product((-1, 1), repeat=3)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    mesh = f"cube{side}.obj"
    with open(mesh, "w") as file:
        file.writelines("v %g %g %g\n" % tuple(c) for c in corners)
        file.writelines("f %d %d %d\nf %d %d %d\n" % (a, b, c, a, c, d) for a, b, c, d in faces)
    box = f'<geometry><box size="{side} {side} {side}"/></geometry>'
    offset = '<origin xyz="0 0 0.001"/>'
    for kind, geometry, margins in (("box", box, 0), ("box with an origin", offset + box, 1),
                                    ("mesh", f'<geometry><mesh filename="{mesh}"/></geometry>', 3)):
        more, factor = grown(f"{kind}{side}".replace(" ", "_"), geometry, side)
        print(f"cube of {side * 1e3:.0f} mm, {kind}: {more:.2f} mm more on each side, {factor:.2f} times the moment")
        right &= abs(more - margins) < 0.01
corners = [[s * 0.0225 for s in signs] for signs in product((-1, 1), repeat=3)]
cubes = [p.createMultiBody(0.1, p.createCollisionShape(p.GEOM_MESH, vertices=corners), basePosition=[x, 0, 0])
         for x in (0, 0.0475)]
gap = p.getClosestPoints(*cubes, 0.1)[0][8] * 1e3
print(f"pybullet {version('pybullet')}: mesh cubes 2.5 mm apart are {gap:.2f} mm apart")
raise SystemExit(not (right and abs(gap - 0.5) < 0.01))
PYTHON
