#!/usr/bin/env bash
# PyBullet 3.2.7, 2026-11-30.
# One would guess: changeDynamics(body, link, mass=m) keeps the inertia that was read from the file, or scales it by the mass.
# What is so: it throws the inertia of the file away, even where URDF_USE_INERTIA_FROM_FILE asked for it, and takes that of
# the collision shape with the new mass: (0.1, 0.2, 0.3) becomes (0.0033, 0.0033, 0.0033).
# Why it matters: domain randomisation of masses, the usual way to judge a planner, changes how bodies turn by factors.
# Set mass and localInertiaDiagonal in one call.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
import pybullet as p

open("body.urdf", "w").write("""<robot name="r"><link name="b"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size=".1 .1 .1"/></geometry></collision></link></robot>""")
p.connect(p.DIRECT)
body = p.loadURDF("body.urdf", flags=p.URDF_USE_INERTIA_FROM_FILE)
read = p.getDynamicsInfo(body, -1)[2]
p.changeDynamics(body, -1, mass=2.0)
changed = p.getDynamicsInfo(body, -1)[2]
print(f"pybullet {version('pybullet')}: inertia read {read}, after mass=2 {tuple(round(v, 5) for v in changed)}")
raise SystemExit(not (read[2] == 0.3 and max(changed) < 0.01))
PYTHON
