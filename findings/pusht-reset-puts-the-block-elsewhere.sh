#!/usr/bin/env bash
# gym-pusht 0.1.8 (pymunk 6.11.1), 2026-11-30.
# One would guess: reset(options={"reset_to_state": [agent x, y, block x, y, angle]}) puts the block there, and the
# observation after it repeats the numbers.
# What is so: the angle is set after the position and turns the block about its centre of mass, 45 units off the origin of
# its pose: asked for (256, 256, 1 rad) the block stands at (293.9, 276.7). Angle 0 is exact.
# Why it matters: replaying recorded states, or simulating a planner's state in this environment, starts up to 45 units
# (of a 512 unit table) off. Set the angle first, then the position, on the body itself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check gym-pusht==0.1.8 pymunk==6.11.1 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import os
import warnings
from importlib.metadata import version
warnings.filterwarnings("ignore")
os.environ["SDL_VIDEODRIVER"] = "dummy"
import gymnasium
import gym_pusht  # noqa: F401  (registers the environment)
import numpy as np

env = gymnasium.make("gym_pusht/PushT-v0", obs_type="state")
off = {}
for angle in (0.0, 0.5, 1.0, 3.0):
    seen, _ = env.reset(seed=0, options={"reset_to_state": [100, 256, 256, 256, angle]})
    off[angle] = float(np.hypot(seen[2] - 256, seen[3] - 256))
    print(f"gym-pusht {version('gym-pusht')}: asked for block (256, 256, {angle}), got "
          f"({seen[2]:.1f}, {seen[3]:.1f}, {seen[4]:.1f}): {off[angle]:.1f} units off")
raise SystemExit(not (off[0.0] < 1e-6 and 35 < off[1.0] < 50 and off[3.0] > 80))
PYTHON
