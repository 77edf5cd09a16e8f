#!/usr/bin/env bash
# PyBullet 3.2.7, 2026-11-30.
# One would guess: resetSimulation() either resets the physics parameters or keeps them.
# What is so: it does both. Gravity and the number of solver iterations go back to 0 and 50; the time step stays. What
# a program calls "the default settings" after a reset is then the step of whatever ran before in the same connection.
# Why it matters: a judge that resets one connection between engines' settings, or a test after a test with finer
# steps, runs every later push with the wrong step: a tip that is moved by 1/240 s a step then moves at four times its
# speed through a world of 1/960 s. Set the time step after each reset.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
import pybullet as p

p.connect(p.DIRECT)
def parameters():
    found = p.getPhysicsEngineParameters()
    return found["fixedTimeStep"], found["numSolverIterations"], found["gravityAccelerationZ"]

fresh = parameters()
p.setGravity(0, 0, -9.8)
p.setPhysicsEngineParameter(fixedTimeStep=1 / 960, numSolverIterations=7)
changed = parameters()
p.resetSimulation()
reset = parameters()
block = p.createMultiBody(0.1, p.createCollisionShape(p.GEOM_SPHERE, radius=0.02))
p.setGravity(0, 0, -9.8)
for _ in range(240):
    p.stepSimulation()
fallen = -p.getBasePositionAndOrientation(block)[0][2]
for name, (step, iterations, gravity) in (("fresh", fresh), ("changed", changed), ("after resetSimulation()", reset)):
    print(f"pybullet {version('pybullet')}, {name}: step {step:.6f} s, {iterations} iterations, gravity {gravity}")
print(f"240 steps after the reset a ball has fallen {fallen:.3f} m (4.9 in a second, 0.31 in a quarter)")
raise SystemExit(not (reset == (1 / 960, fresh[1], 0.0) and 0.2 < fallen < 0.4))
PYTHON
