#!/usr/bin/env bash
# OMPL 2.0.1, Pinocchio 4.1.0 (package pin), 2026-11-30.
# One would guess: half way between two planar poses is the same pose in both libraries, as both call it SE(2), the
# distance is shortest and "interpolate" is the name of it.
# What is so: OMPL goes straight and turns evenly (R^2 x SO(2)); Pinocchio's planar joint goes along a screw, an arc.
# A metre to the side of a quarter turn, the two are 207 mm apart half way. The ends agree, so tests of ends pass.
# Why it matters: a path that OMPL checked for collisions is another one where Pinocchio (or a controller on it) plays
# it. Sample the path at the checker's resolution before handing it on, or interpolate x, y and the angle yourself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ompl==2.0.1 pin==4.1.0 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import math
from importlib.metadata import version
import numpy as np
import pinocchio as pin
from ompl import base as ob

model = pin.Model()
model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "planar")
start, goal = np.array([0, 0, 1.0, 0]), np.array([1.0, 0, 0, 1.0])
space = ob.SE2StateSpace()
bounds = ob.RealVectorBounds(2)
bounds.setLow(-2)
bounds.setHigh(2)
space.setBounds(bounds)
a, b, between = space.allocState(), space.allocState(), space.allocState()
for state, (x, y, yaw) in ((a, (0, 0, 0)), (b, (1, 0, math.pi / 2))):
    state.setX(float(x))
    state.setY(float(y))
    state.setYaw(yaw)
apart = []
for share in (0.0, 0.25, 0.5, 0.75, 1.0):
    x, y, c, s = pin.interpolate(model, start, goal, share)
    space.interpolate(a, b, share, between)
    apart.append(1000 * math.hypot(x - between.getX(), y - between.getY()))
    print(f"at {share:.2f}: ompl {version('ompl')} ({between.getX():.3f}, {between.getY():.3f}, {math.degrees(between.getYaw()):.1f} "
          f"degrees), pin {version('pin')} ({x:.3f}, {y:.3f}, {math.degrees(math.atan2(s, c)):.1f}), {apart[-1]:.0f} mm apart")
raise SystemExit(not (abs(apart[2] - 207.1) < 0.5 and apart[0] < 1e-6 and apart[4] < 1e-6))
PYTHON
