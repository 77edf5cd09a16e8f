#!/usr/bin/env bash
# pymunk 7.3.1 (Chipmunk 2.0.1), 2026-11-30.
# One would guess: two blocks that an observation has 20 mm into each other are pushed apart within a second.
# What is so: they stay as they are for ever. The default collision slop is 0.1 of whatever the unit is, made for pixels: in
# metres every overlap of a table-top scene is within it. A slop of 0.1 mm parts them.
# Why it matters: scenes from a camera overlap. In SI units the engine accepts overlaps as large as the blocks, so a grasp
# or push between them is judged in a world that cannot be; set Space.collision_slop before comparing with it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymunk==7.3.1
cd "$folder"
venv/bin/python - <<'PYTHON'
import pymunk

def gap(slop=None):
    """Between two blocks of 45 mm that begin 20 mm in each other, after four seconds, millimetres."""
    space = pymunk.Space()
    if slop is not None:
        space.collision_slop = slop
    blocks = []
    for x in (0.0, 0.025):
        body = pymunk.Body(0.1, pymunk.moment_for_box(0.1, (0.045, 0.045)))
        body.position = (x, 0.0)
        space.add(body, pymunk.Poly.create_box(body, (0.045, 0.045)))
        blocks.append(body)
    for _ in range(960):
        space.step(1 / 240)
    return 1000 * (blocks[1].position.x - blocks[0].position.x - 0.045), space.collision_slop

(usual, slop), (set_, _) = gap(), gap(1e-4)
print(f"pymunk {pymunk.version}: default slop {slop:.3f}; blocks 20 mm in each other have a gap of {usual:.2f} mm after 4 s, "
      f"{set_:.2f} mm with a slop of 0.1 mm")
raise SystemExit(not (abs(usual + 20) < 0.1 and abs(set_) < 0.2))
PYTHON
