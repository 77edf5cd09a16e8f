#!/usr/bin/env bash
# robosuite 1.5.2 (files) with MuJoCo 4.0.0, 2026-11-30.
# One would guess: an object on a table resists turning as its contacts with the table do: a loaf of 48 x 40 mm turns under a
# moment of its weight times 30 mm, the distance of its corners, and a push at its side turns it.
# What is so: bread, can, cereal and milk of the pick-and-place tasks have condim 4 and a torsional friction of 0.3, which is a
# length: their contacts take a moment of the weight times 300 mm, 6 to 13 times what sliding at the corners takes. A push of
# 60 mm off the centre turns the loaf by 3 degrees in place of 26, the can by 8 in place of 21. With condim 3 they are as one
# would guess. The bottle has the same number and no condim 4, so that it does nothing.
# Why it matters: pushes there hardly turn anything, so policies and models learned from them do not carry over, and a tip that
# meets a body off its centre looks as good as one at its centre. Set condim to 3, or the second coefficient to 0.005.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy
# What else robosuite needs is not used: its files of objects are read alone.
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps robosuite==1.5.2
cd "$folder"
venv/bin/python - <<'PYTHON'
import math
import sysconfig
from pathlib import Path

import mujoco
import numpy as np

OBJECTS = Path(sysconfig.get_path("purelib")) / "robosuite/models/assets/objects"


class Table:
    """An object of robosuite on a plane with the friction and the solver of its tables, and a tip that waits beside."""

    def __init__(self, name, condim):
        spec = mujoco.MjSpec.from_file(str(OBJECTS / f"{name}.xml"))
        spec.option.timestep, spec.option.impratio, spec.option.cone = 0.001, 20, mujoco.mjtCone.mjCONE_ELLIPTIC
        world = spec.worldbody
        world.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], friction=[1, 0.005, 0.0001])
        top = world.first_body()
        top.add_freejoint()
        for geom in spec.geoms:
            if condim and geom.type == mujoco.mjtGeom.mjGEOM_MESH:
                geom.condim = condim
        tip = world.add_body(name="tip")
        tip.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
        tip.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.011, 0.01, 0.01], mass=1000, friction=[0.5, 0.005, 0.0001])
        self.model = model = spec.compile()
        self.data = data = mujoco.MjData(model)
        self.mass = sum(model.body_mass[1:]) - 1000
        mujoco.mj_forward(model, data)
        points = []
        for g in range(model.ngeom):
            if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH:
                first, count = model.mesh_vertadr[model.geom_dataid[g]], model.mesh_vertnum[model.geom_dataid[g]]
                turn = data.geom_xmat[g].reshape(3, 3)
                points.append(model.mesh_vert[first:first + count] @ turn.T + data.geom_xpos[g])
        points = np.concatenate(points)
        self.low, self.high = points.min(0), points.max(0)
        data.qpos[2] -= self.low[2]
        for _ in range(500):
            self.step(-1, 0)

    def step(self, place, speed):
        self.data.qpos[-1], self.data.qvel[-1] = place, speed
        mujoco.mj_step(self.model, self.data)

    def yaw(self):
        w, x, y, z = self.data.qpos[3:7]
        return math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    def reach(self):
        """The moment under which it turns faster than 1 rad/s, over its weight, mm."""
        moment = 0.0
        while abs(self.data.qvel[5]) < 1:
            moment += 1e-6 * self.mass * 9.81
            self.data.qfrc_applied[5] = moment
            self.step(-1, 0)
        return 1e3 * moment / (self.mass * 9.81)

    def pushed(self):
        """By how far it turns when it is pushed for 60 mm, off its centre by 0.6 of half its width."""
        size, start = self.high - self.low, self.yaw()
        self.model.body_pos[-1] = [0, 0.3 * size[1] + self.data.qpos[1], 0.4 * size[2]]
        first, travel = self.data.qpos[0] - size[0] / 2 - 0.02, 0.0
        while travel < 0.071:
            self.step(first + travel, 0.13)
            travel += 0.13 * 0.001
        return abs(self.yaw() - start)


same = True
for name in ("bread", "can", "cereal", "milk", "bottle"):
    reach, usual = (Table(name, condim).reach() for condim in (0, 3))
    table = Table(name, 0)
    size = " x ".join(f"{1e3 * s:.0f}" for s in (table.high - table.low)[:2])
    print(f"robosuite 1.5.2, {name}, {size} mm, {1e3 * table.mass:.0f} g: turns under a moment of its weight times "
          f"{reach:.0f} mm, with condim 3 times {usual:.0f} mm")
    same &= reach > 5 * usual if name != "bottle" else abs(reach - usual) < 0.1
for name in ("bread", "can"):
    turn, usual = (Table(name, condim).pushed() for condim in (0, 3))
    print(f"{name}, pushed off its centre: turns by {turn:.1f} degrees, with condim 3 by {usual:.1f}")
    same &= turn < usual / 2
raise SystemExit(not same)
PYTHON
