#!/usr/bin/env bash
# MuJoCo 4.0.0, 2026-11-30.
# One would guess: a plate driven as a mocap body carries a block that lies on it by friction, as a moving support does.
# What is so: contacts see a mocap body at rest whatever its pose does; the plate moves 100 mm and the block stays, to
# the micrometre. Pushing along the normal works only because the moved body overlaps and the overlap is pushed out.
# Why it matters: a push tip driven as mocap has no tangential drag. Off-centre and sliding pushes come out as with a
# frictionless tip, so a planner's tip friction cannot be fitted to such a simulation. Drive the tip by a joint.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import mujoco

SCENE = """<mujoco><option timestep="0.001"/><worldbody>{plate}
  <body name="block" pos="0 0 .0325"><freejoint/><geom type="box" size=".0225 .0225 .0225" mass=".1" friction="1"/></body>
</worldbody>{drive}</mujoco>"""
BOX = '<geom type="box" size=".3 .3 .01" friction="1" mass="5"/>'

def carried(plate, drive, move):
    model = mujoco.MjModel.from_xml_string(SCENE.format(plate=plate, drive=drive))
    data = mujoco.MjData(model)
    block = model.joint(model.body("block").jntadr[0]).qposadr[0]
    while data.time < 1.0:
        move(model, data)
        mujoco.mj_step(model, data)
    return data.qpos[block]

def by_mocap(model, data):
    data.mocap_pos[0] = [0.1 * data.time, 0, 0]

def by_joint(model, data):
    data.ctrl[0] = 0.1

mocap = carried(f'<body mocap="true">{BOX}</body>', "", by_mocap)
joint = carried(f'<body><joint name="j" type="slide" axis="1 0 0"/>{BOX}</body>',
                '<actuator><velocity joint="j" kv="1000"/></actuator>', by_joint)
print(f"mujoco {mujoco.__version__}: plate moved 100 mm; block on a mocap plate moved {1000 * mocap:.3f} mm, "
      f"on a plate driven by a joint {1000 * joint:.1f} mm")
raise SystemExit(not (abs(mocap) < 1e-6 and joint > 0.09))
PYTHON
