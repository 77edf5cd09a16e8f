#!/usr/bin/env bash
# MuJoCo 4.0.0, PyBullet 3.2.7, 2026-11-30.
# One would guess: a URDF file of one link with a mass is a body that may fall, everywhere; and one whose link hangs
# by a floating joint on a link "world" is the same said aloud.
# What is so: MuJoCo welds a first link to the world, so the first file has no degree of freedom (the block is scenery
# and its mass is gone); it wants the floating joint. PyBullet lets the first link fall, warns at a floating joint,
# makes it a fixed one, and takes the massless "world" for a static body. Each file falls in one of the two alone.
# Why it matters: a scene of blocks that was written for one has blocks that no push moves in the other, and nothing
# is refused. Write both files, or load the link alone into PyBullet and add the joint for MuJoCo.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 pybullet==3.2.7 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
import mujoco
import pybullet as p

LINK = """<link name="block"><inertial><mass value="0.1"/><inertia ixx="3e-5" iyy="3e-5" izz="3e-5" ixy="0" ixz="0" iyz="0"/>
  </inertial><collision><geometry><box size=".045 .045 .045"/></geometry></collision></link>"""
FILES = {
    "one link": f'<robot name="r">{LINK}</robot>',
    "floating joint": f"""<robot name="r"><link name="world"/>{LINK}
      <joint name="free" type="floating"><parent link="world"/><child link="block"/></joint></robot>""",
}

def in_mujoco(text):
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    while data.time < 0.5:
        mujoco.mj_step(model, data)
    return data.geom_xpos[0][2]

def in_pybullet(text):
    p.resetSimulation()
    p.setGravity(0, 0, -9.81)
    p.setPhysicsEngineParameter(enableFileCaching=0)
    with open("body.urdf", "w") as file:
        file.write(text)
    body = p.loadURDF("body.urdf")
    for _ in range(120):
        p.stepSimulation()
    return (p.getLinkState(body, 0)[0] if p.getNumJoints(body) else p.getBasePositionAndOrientation(body)[0])[2]

p.connect(p.DIRECT)
heights = {name: (in_mujoco(text), in_pybullet(text)) for name, text in FILES.items()}
for name, (a, b) in heights.items():
    print(f"{name}: after half a second of gravity in mujoco {version('mujoco')} at z = {a:.2f} m, "
          f"in pybullet {version('pybullet')} at {b:.2f} m")
fell = {name: (a < -1, b < -1) for name, (a, b) in heights.items()}
raise SystemExit(fell != {"one link": (False, True), "floating joint": (True, False)})
PYTHON
