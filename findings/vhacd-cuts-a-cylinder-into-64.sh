#!/usr/bin/env bash
# vhacdx 0.1.1 (V-HACD 4, as trimesh 5.2.0 calls it), 2026-11-30.
# One would guess: convex decomposition by default leaves a convex body as one part, and what it makes of others
# covers them, as parts are hulls: at worst too much is filled, never too little.
# What is so: a cylinder (a prism of 32 corners, convex) becomes 64 parts, the most that are allowed, most of them
# flat pieces of its height, some of nearly no volume; so does a block with a round notch. The parts leave out 1 % of
# the outline: shrink-wrapped hulls of voxels fall short by up to 0.4 mm between them and at the rim. max_hulls=8
# gives 8 parts that lack as much.
# Why it matters: engines take a part as a shape, so each body costs 64 of them, and contacts lie where its outline is
# not. For bodies on a table cut the outline (a section at half height) into convex polygons instead; a convex body
# needs no cutting.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 vhacdx==0.1.1 mapbox-earcut shapely scipy \
    networkx numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
from importlib.metadata import version
import numpy as np
import shapely
from trimesh.creation import extrude_polygon

HEIGHT = 0.045
BODIES = {
    "cylinder": shapely.Point(0, 0).buffer(0.0225, quad_segs=8),
    "notched block": shapely.box(-0.045, -0.0225, 0.045, 0.0225).difference(
        shapely.Point(0, 0.0225).buffer(0.0235, quad_segs=16)),
}
found = {}
for name, outline in BODIES.items():
    mesh = extrude_polygon(outline, HEIGHT)
    for options in ({}, {"maxConvexHulls": 8}):
        parts = [np.array(part.vertices) for part in mesh.convex_decomposition(**options)]
        flat = sum(np.ptp(part[:, 2]) < 0.98 * HEIGHT for part in parts)
        covered = shapely.unary_union([shapely.MultiPoint(part[:, :2]).convex_hull for part in parts])
        missing = 100 * outline.difference(covered).area / outline.area
        found[name, not options] = len(parts), missing
        print(f"vhacdx {version('vhacdx')}, {name} ({'convex' if mesh.is_convex else 'concave'}), {options or 'defaults'}: {len(parts)} "
              f"parts, {flat} of them not as high as the body; {missing:.2f} % of the outline is in none")
raise SystemExit(not all(count == 64 and missing > 0.8 for (_, default), (count, missing) in found.items() if default))
PYTHON
