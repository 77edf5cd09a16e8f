#!/usr/bin/env bash
# Box2D 2.3.10 (its Python package), 2026-11-30.
# One would guess: a kinematic body with a velocity moves for ever; sleeping is for bodies that came to rest.
# What is so: one slower than 10 mm/s counts as at rest. After half a second beside nothing that moves it falls asleep, and
# stands still with a velocity of 0: at 8 mm/s a tip that is to travel 80 mm stops after 4 mm, in front of the block or against
# it. At 12 mm/s it arrives. The limit is in units of the scene (with lengths in centimetres it is 0.1 mm/s).
# Why it matters: quasi-static pushing is done slowly, and a simulated push that quietly ends early looks like a block that is
# too heavy. Set allowSleep of the tip to False, or doSleep of the world.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check Box2D==2.3.10
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

from Box2D import b2FixtureDef, b2PolygonShape, b2World


def travelled(speed, **tip):
    """Of a tip that pushes a block for so long that it should travel 80 mm, in mm; and its velocity after that."""
    world = b2World(gravity=(0, 0))
    block = world.CreateDynamicBody(
        fixtures=b2FixtureDef(shape=b2PolygonShape(box=(0.0225, 0.0225)), density=50, friction=0.5))
    world.CreateFrictionJoint(bodyA=world.CreateStaticBody(), bodyB=block, maxForce=0.54, maxTorque=0.01)
    pusher = world.CreateKinematicBody(
        position=(-0.06, 0), linearVelocity=(speed, 0),
        fixtures=b2FixtureDef(shape=b2PolygonShape(box=(0.011, 0.015)), friction=0.9), **tip)
    for _ in range(round(0.08 / speed * 240)):
        world.Step(1 / 240, 8, 3)
    return (pusher.position.x + 0.06) * 1e3, pusher.linearVelocity.x * 1e3


slow, quick, awake = travelled(0.008), travelled(0.012), travelled(0.008, allowSleep=False)
for name, (way, speed) in (("8 mm/s", slow), ("12 mm/s", quick), ("8 mm/s, allowSleep=False", awake)):
    print(f"Box2D {version('Box2D')}, {name}: {way:.1f} of 80 mm, then {speed:.1f} mm/s")
raise SystemExit(not (slow[0] < 10 and slow[1] == 0 and quick[0] > 79 and awake[0] > 79))
PYTHON
