#!/usr/bin/env bash
# trimesh 5.2.0, 2026-11-30.
# One would guess: an L-shaped prism whose two L faces are one hexagon each in the OBJ file (as CAD programs write it)
# is read right, or a concave face is refused; and a mesh that is watertight with the right volume is the right mesh.
# What is so: a face is cut into a fan about its first corner, across the notch where the corner does not see all
# others. The mesh is watertight, its volume is exact (what lies outside counts negative), no word is said, but its
# area is 7 to 14 % too great and its outline from above covers up to half of the notch.
# Why it matters: the usual check (is_watertight, volume) passes and the footprint that a planar planner takes is
# wrong: a gripper that fits in the notch is refused. Cut faces into triangles on export, or take the outline by a
# section at half height.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy scipy shapely networkx
cd "$folder"
venv/bin/python - <<'PYTHON'
import io
import numpy as np
import trimesh

OUTLINE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]

def read(first):
    corners = OUTLINE[first:] + OUTLINE[:first]
    lines = [f"v {x} {y} {z}" for z in (0, 1) for x, y in corners]
    lines += ["f 6 5 4 3 2 1", "f 7 8 9 10 11 12"]
    lines += [f"f {k + 1} {(k + 1) % 6 + 1} {(k + 1) % 6 + 7} {k + 7}" for k in range(6)]
    return trimesh.load(io.StringIO("\n".join(lines)), file_type="obj", force="mesh")

as_said = True
for first in (0, 2):
    mesh = read(first)
    above = trimesh.path.polygons.projected(mesh, [0, 0, 1]).area
    section = mesh.section([0, 0, 1], [0, 0, 0.5]).to_2D()[0].area
    print(f"trimesh {trimesh.__version__}, faces that begin at corner {first}: watertight {mesh.is_watertight}, volume {mesh.volume:.3f} "
          f"(3), area {mesh.area:.2f} (14), outline from above {above:.2f} (3), section at half height {section:.2f} (3)")
    as_said &= mesh.is_watertight and abs(mesh.volume - 3) < 1e-9 and mesh.area > 14.9 and above > 3.2 and abs(section - 3) < 1e-9
raise SystemExit(not as_said)
PYTHON
