#!/usr/bin/env bash
# manifold3d 3.5.4, 2026-11-30.
# One would guess: a cylinder or circle has a number of segments that suits its shape, by default one each 10 degrees, as in
# OpenSCAD, or fewer where it is small beside the rest.
# What is so: a side is at least 1 unit long by default, whatever else there is, and there are at least 4 sides. In metres a disc
# of 44 mm is a square with 64 % of its area, and so is a disc of 1.2 m; a wheel of 4 m has 12 corners. A block of 90 x 45 mm less
# half a disc has a notch like a V, and rounding a square of 45 mm by 10 mm cuts its corners straight.
# set_min_circular_edge_length(0.0005) before gives round ones.
# Why it matters: footprints of cups and cans from Manifold are 36 % too small and have corners that engines push against. The
# number is of the process; give segments with each call, or work in millimetres.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check manifold3d==3.5.4 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import math
from importlib.metadata import version

import manifold3d
from manifold3d import CrossSection, JoinType, Manifold


def shares():
    """Corners, and area or volume over the exact one: a disc, a cylinder, a rounded square; corners of a notched block."""
    disc, cylinder = CrossSection.circle(0.022), Manifold.cylinder(0.045, 0.022)
    rounded = CrossSection.square((0.045, 0.045)).offset(0.010, JoinType.Round)
    exact = 0.045**2 + 4 * 0.045 * 0.010 + math.pi * 0.010**2
    notched = CrossSection.square((0.090, 0.045)) - CrossSection.circle(0.0235).translate((0.045, 0.045))
    return ((disc.num_vert(), disc.area() / (math.pi * 0.022**2)),
            (cylinder.num_vert(), cylinder.volume() / (math.pi * 0.022**2 * 0.045)),
            (rounded.num_vert(), rounded.area() / exact), notched.num_vert())


def told(found):
    (d, a), (c, v), (r, e), n = found
    return f"disc of 44 mm {d} corners, {a:.3f}; cylinder {c}, {v:.3f}; rounded square {r}, {e:.3f}; notched block {n}"


usual = shares()
large = [CrossSection.circle(r).num_vert() for r in (0.6, 2.0)]
manifold3d.set_min_circular_edge_length(0.0005)
fine = shares()
print(f"manifold3d {version('manifold3d')} in metres: {told(usual)}; discs of 1.2 and 4 m {large} corners")
print(f"with sides of 0.5 mm at least: {told(fine)}")
raise SystemExit(not (usual[0][0] == 4 and usual[1][1] < 0.65 and large[0] < 9 and usual[2][0] == 8 and fine[0][1] > 0.99))
PYTHON
