#!/usr/bin/env bash
# python-fcl 0.7.0.11 (FCL 0.7), 2026-11-30.
# One would guess: continuousCollide between two poses checks the motion between them, rotation included.
# What is so: the default motion type is a pure translation: the rotation of the end pose is dropped without a word. A bar
# that turns by 90 degrees through a post is "free". CCDM_SCREW finds the hit. (CCDC_NAIVE, chosen by hand, samples ten
# poses and steps over a 5 mm wall.)
# Why it matters: paths in SE(2) that are checked edge by edge with the defaults sweep bodies through others.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check python-fcl==0.7.0.11 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import math
from importlib.metadata import version
import fcl
import numpy as np

def turn(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])

at = np.array([0.08 * math.cos(math.pi / 4), 0.08 * math.sin(math.pi / 4), 0])
bar, post = fcl.Box(0.2, 0.01, 0.02), fcl.Box(0.01, 0.01, 0.02)
stand = lambda degrees: fcl.CollisionObject(bar, fcl.Transform(turn(degrees), np.zeros(3)))
still = fcl.CollisionObject(post, fcl.Transform(at))

def hit(**options):
    begin, end, same = stand(0), fcl.Transform(turn(90), np.zeros(3)), fcl.Transform(at)
    request, result = fcl.ContinuousCollisionRequest(**options), fcl.ContinuousCollisionResult()
    fcl.continuousCollide(begin, end, still, same, request, result)
    return result.is_collide

by_hand = any(fcl.collide(stand(degrees), still) for degrees in range(0, 91, 5))
default, screw = hit(), hit(ccd_motion_type=fcl.CCDMotionType.CCDM_SCREW)
print(f"python-fcl {version('python-fcl')}: bar turned through a post: default says hit={default}, "
      f"CCDM_SCREW {screw}, poses tried one by one {by_hand}")
raise SystemExit(not (by_hand and screw and not default))
PYTHON
