#!/usr/bin/env bash
# gym-pusht 0.1.8 (pymunk 6.11.1), 2026-11-30.
# One would guess: pushing the T has Coulomb friction at the tip (else where would stable pushes come from) and on
# the table (else the T would drift).
# What is so: every shape has friction 0, so the tip slides freely along the T; and the space has damping 0, which sets all
# velocities to zero in every step: the T is quasi-static without a limit surface, its turning set by its moment of
# inertia, not by pressure on a table.
# Why it matters: policies and planners judged here never meet sticking contact, and a pushing model fitted to its
# recordings has tip friction 0 and the torque radius of inertia. Results do not carry over to a table.
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
import gym_pusht  # noqa: F401
import numpy as np

env = gymnasium.make("gym_pusht/PushT-v0", obs_type="state")
env.reset(seed=0)
inner = env.unwrapped
frictions = sorted({shape.friction for shape in inner.space.shapes})

def push(steps):
    env.reset(seed=0, options={"reset_to_state": [100, 256, 256, 256, 0.0]})
    for k in range(steps):
        env.step(np.array([100 + 120 * (k + 1) / steps, 256.0]))
    for _ in range(20):
        seen, *_ = env.step(np.array([220.0, 256.0]))
    return seen[2:]

fast, slow = push(3), push(60)
print(f"gym-pusht {version('gym-pusht')}: friction of all shapes {frictions}, damping {inner.space.damping}; pushed in 3 and "
      f"in 60 steps the T ends at {np.round(fast, 2).tolist()} and {np.round(slow, 2).tolist()}")
raise SystemExit(not (frictions == [0.0] and inner.space.damping == 0 and np.abs(fast - slow).max() < 0.5))
PYTHON
