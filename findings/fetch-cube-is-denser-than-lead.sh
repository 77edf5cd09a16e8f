#!/usr/bin/env bash
# gymnasium-robotics 1.4.2 and metaworld 3.1.1 on MuJoCo 4.0.0, 2026-11-30.
# One would guess: the objects that robots push in the usual benchmarks weigh what such things weigh, 50 to 200 g.
# What is so: the 50 mm cube of FetchPush has 2 kg (16 000 kg/m^3; lead has 11 300) and slides on friction 1.0; the puck of
# FetchSlide has 25 500 kg/m^3, more than platinum; the object of Meta-World's push-v3 14 900.
# Why it matters: it takes 20 N to push the cube, some 40 times what a wooden block of that size takes. Masses, forces and
# limits of force that are tuned or learned there do not fit things on a table.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps gymnasium-robotics==1.4.2 metaworld==3.1.1
cd "$folder"
venv/bin/python - <<'PYTHON'
import importlib.util
import math
import pathlib
from importlib.metadata import version

import mujoco


def model(package, path):
    folder = pathlib.Path(importlib.util.find_spec(package).origin).parent
    return mujoco.MjModel.from_xml_path(str(folder / path))


def density(name, loaded, body):
    """Of a body that is one box or cylinder."""
    index = loaded.body(body).id
    solid = [g for g in range(loaded.ngeom) if loaded.geom_bodyid[g] == index and loaded.geom_contype[g]]
    a, b, c = loaded.geom_size[solid[0]]
    box = loaded.geom_type[solid[0]] == mujoco.mjtGeom.mjGEOM_BOX
    volume = 8 * a * b * c if box else 2 * math.pi * a * a * b
    found = loaded.body_mass[index] / volume
    print(f"{name}: {loaded.body_mass[index]:g} kg, {found:.0f} kg/m^3, sliding friction {loaded.geom_friction[solid[0]][0]:g}")
    return found


print(", ".join(f"{name} {version(name)}" for name in ("gymnasium-robotics", "metaworld", "mujoco")))
fetch = "envs/assets/fetch"
push = density("FetchPush", model("gymnasium_robotics", f"{fetch}/push.xml"), "object0")
slide = density("FetchSlide", model("gymnasium_robotics", f"{fetch}/slide.xml"), "object0")
meta = density("Meta-World push-v3", model("metaworld", "assets/sawyer_xyz/sawyer_push_v3.xml"), "obj")
raise SystemExit(not (push > 11300 and slide > 21400 and meta > 11300))
PYTHON
