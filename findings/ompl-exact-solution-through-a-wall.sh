#!/usr/bin/env bash
# OMPL 2.0.1 (its Python package), 2026-11-30.
# One would guess: motions in SE(2) are checked at 1 % of the room, so in a room of 2 m x 2 m a 20 mm wall might just be
# missed, and what is returned as "exact" is valid.
# What is so: the default resolution is 1 % of the extent of the whole space, in which half of pi for the heading is added
# to the diagonal: 44 mm. A wall of 20 mm across the whole room is crossed, with status "Exact solution".
# Why it matters: a comparison of planners on a table in metres must set the resolution (setStateValidityCheckingResolution,
# setLongestValidSegmentFraction) from the thinnest obstacle, or check paths again by an exact sweep.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ompl==2.0.1
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
from ompl import base, geometric, util

util.setLogLevel(util.LOG_ERROR)

def solve(width, fraction=None):
    space = base.SE2StateSpace()
    bounds = base.RealVectorBounds(2)
    bounds.setLow(-1)
    bounds.setHigh(1)
    space.setBounds(bounds)
    if fraction:
        space.setLongestValidSegmentFraction(fraction)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: abs(state.getX()) >= width / 2)
    ends = []
    for x in (-0.5, 0.5):
        state = space.allocState()
        state.setX(x)
        state.setY(0)
        state.setYaw(0)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.solve(0.5)
    return setup.haveExactSolutionPath(), space.getMaximumExtent() * space.getLongestValidSegmentFraction()

crossed, step = solve(0.02)
fine, _ = solve(0.02, fraction=0.002)
print(f"ompl {version('ompl')}: steps of {1000 * step:.0f} mm by default; an exact solution through a 20 mm wall: {crossed}, "
      f"with a fraction of 0.002: {fine}")
raise SystemExit(not (crossed and not fine and 0.04 < step < 0.05))
PYTHON
