#!/usr/bin/env bash
# Box2D 2.3.10 (its Python package), 2026-11-30.
# One would guess: bodies meet within the linear slop, 5 mm; a 45 mm block moves when the tip is some millimetres away.
# What is so: in SI units a block is held 19.8 mm clear of the tip that pushes it: each polygon has a skin of 10 mm which
# cannot be set from Python, and both skins count. The same scene in centimetres (100 times the numbers) has 0.15 mm.
# Why it matters: table-top scenes in metres are nonsense in Box2D 2; scale lengths by 100 (and gravity, velocities with
# them) before comparing pushes, and never take contact from touching shapes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check Box2D==2.3.10
cd "$folder"
venv/bin/python - <<'PYTHON'
import Box2D
from Box2D import b2FixtureDef, b2PolygonShape, b2World

def gap(scale):
    """Between tip and block in millimetres of the scene in metres, after a push of 50 mm."""
    world = b2World(gravity=(0, 0))
    half = 0.0225 * scale
    block = world.CreateDynamicBody(position=(0, 0), linearDamping=50, angularDamping=50, fixtures=b2FixtureDef(
        shape=b2PolygonShape(box=(half, half)), density=1, friction=0.5))
    tip = world.CreateKinematicBody(position=(-0.05 * scale, 0), linearVelocity=(0.05 * scale, 0), fixtures=b2FixtureDef(
        shape=b2PolygonShape(box=(0.005 * scale, 0.015 * scale)), density=1, friction=0.5))
    for _ in range(480):
        world.Step(1 / 240, 8, 3)
    return 1000 * ((block.position.x - half) - (tip.position.x + 0.005 * scale)) / scale

metres, centimetres = gap(1), gap(100)
print(f"Box2D {Box2D.__version__}: the tip pushes from {metres:.2f} mm away in metres, {centimetres:.2f} mm in centimetres")
raise SystemExit(not (15 < metres < 25 and abs(centimetres) < 0.5))
PYTHON
