#!/usr/bin/env bash
# PyBullet 3.2.7, 2026-11-30.
# One would guess: loadURDF reads the file that it is given; at most meshes are kept, and a reset of the simulation
# forgets them.
# What is so: files are kept by name for the life of the connection, URDF and OBJ alike. A body.urdf with a box of 0.6 m
# that was written over one of 0.2 m loads as 0.2 m, after resetSimulation() too. In a new connection, and after
# setPhysicsEngineParameter(enableFileCaching=0), it loads right.
# Why it matters: random bodies are usually written to one file name again and again. All of them are then the first
# one, while the planner knows the true ones, and a judge of plans is wrong without a word.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
import pybullet as p

def write(size):
    with open("body.urdf", "w") as file:
        file.write(f'<robot name="r"><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
                   f'ixz="0" iyz="0"/></inertial><collision><geometry><box size="{size} {size} {size}"/></geometry>'
                   '</collision></link></robot>')

def loaded():
    low, high = p.getAABB(p.loadURDF("body.urdf"))
    return round(high[0] - low[0], 2)

p.connect(p.DIRECT)
write(0.2)
sizes = {"first": loaded()}
write(0.6)
sizes["rewritten to 0.6 m"] = loaded()
p.resetSimulation()
sizes["after a reset"] = loaded()
p.setPhysicsEngineParameter(enableFileCaching=0)
sizes["without file caching"] = loaded()
for name, size in sizes.items():
    print(f"pybullet {version('pybullet')}, {name}: a box of {size} m")
raise SystemExit(list(sizes.values()) != [0.2, 0.2, 0.2, 0.6])
PYTHON
