#!/usr/bin/env bash
# coal 3.0.3 (once hpp-fcl) and python-fcl 0.7.0.11, 2026-11-30.
# One would guess: a contact's penetration_depth is how deep two bodies are in each other, positive, as in FCL, of which coal is
# the successor, and 0 or none for bodies that do not touch.
# What is so: it is the signed distance. Two cubes 5 mm in each other have +5 mm in FCL and -5 mm in coal. With a
# security_margin of 10 mm cubes that stand 5 mm apart have a contact with a penetration_depth of +5 mm, and collide() counts it
# as one; distance_lower_bound then says -5 mm, as the margin is taken off there and not in the depth.
# Why it matters: "the deepest contact" by the greatest number is the shallowest, bodies are moved further in where they should
# be moved out, and with a margin bodies that are clear look as deep as others are. Test the sign, and distance() for the gap.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check coal==3.0.3 python-fcl==0.7.0.11 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

import coal
import fcl
import numpy as np

SIDE = 0.045


def in_coal(gap, margin):
    """Depth and lower bound of the distance of two cubes with a gap between them, mm; None without contact."""
    request, result = coal.CollisionRequest(coal.CollisionRequestFlag.CONTACT, 1), coal.CollisionResult()
    request.security_margin = margin
    cube = coal.Box(SIDE, SIDE, SIDE)
    coal.collide(cube, coal.Transform3s(), cube, coal.Transform3s(np.eye(3), np.array([SIDE + gap, 0, 0])), request, result)
    if not result.isCollision():
        return None
    return 1e3 * result.getContact(0).penetration_depth, 1e3 * result.distance_lower_bound


def in_fcl(gap):
    request, result = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), fcl.CollisionResult()
    cubes = [fcl.CollisionObject(fcl.Box(SIDE, SIDE, SIDE), fcl.Transform(np.array([x, 0, 0]))) for x in (0, SIDE + gap)]
    fcl.collide(*cubes, request, result)
    return 1e3 * result.contacts[0].penetration_depth if result.is_collision else None


inside, apart, none = in_coal(-0.005, 0.0), in_coal(0.005, 0.010), in_coal(0.005, 0.0)
old = in_fcl(-0.005)
print(f"5 mm in each other: penetration_depth {old:+.2f} mm in python-fcl {version('python-fcl')}, {inside[0]:+.2f} mm in coal "
      f"{version('coal')}")
print(f"5 mm apart with a margin of 10 mm in coal: {apart[0]:+.2f} mm, distance_lower_bound {apart[1]:+.2f} mm; without "
      f"a margin {none}")
raise SystemExit(not (abs(old - 5) < 0.1 and abs(inside[0] + 5) < 0.1 and abs(apart[0] - 5) < 0.1
                      and abs(apart[1] + 5) < 0.1 and none is None))
PYTHON
