#!/usr/bin/env bash
# trimesh 5.2.0, 2026-11-30.
# One would guess: a section of two boxes that share a face is one rectangle, or at worst two squares side by side; where the
# outline cannot be made out there is none.
# What is so: it is a strip 2 mm wide round the shared face, 2.5 % of the area, and nothing says so: where lines of a section
# meet in a point, the path that is followed crosses itself, and what is not a valid polygon is "repaired" into a thin band
# about its line. polygons_full is valid, runs clockwise (others run counter-clockwise), and has corners 1e-14 m apart. Two
# that overlap by half come to less than one of them, and a box with a wall inside is half a box.
# Why it matters: bodies put together of boxes, and scanned meshes with inner faces, are quite usual; their footprint at half
# height becomes a sliver that collides with nothing. Section the parts one by one and take the union, or compare the
# section's area with that of its convex hull.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 shapely==2.2.0 networkx==3.6.1 \
    scipy==1.17.1 rtree==1.4.1 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import numpy
import trimesh


def cube(x):
    return trimesh.creation.box((0.04, 0.04, 0.04), transform=trimesh.transformations.translation_matrix((x, 0, 0)))


def section(mesh):
    """Area of the section at half height, mm^2; whether its outlines run counter-clockwise; the least side of any, m."""
    mesh.merge_vertices()
    path, _ = mesh.section(plane_normal=[0, 0, 1], plane_origin=[0, 0, 0]).to_2D()
    polygons = path.polygons_full
    rings = [numpy.array(polygon.exterior.coords) for polygon in polygons]
    sides = numpy.concatenate([numpy.linalg.norm(numpy.diff(ring, axis=0), axis=1) for ring in rings])
    area = sum(polygon.area for polygon in polygons) * 1e6
    print(f"  {area:.0f} mm^2 in {len(polygons)} polygons of {len(sides)} corners, the least side {sides.min():.1e} m; "
          f"counter-clockwise: {[polygon.exterior.is_ccw for polygon in polygons]}")
    return area


print(f"trimesh {trimesh.__version__}, a cube of 40 mm (1600 mm^2):")
one = section(cube(0))
print("two that share a face (3200 mm^2):")
two = section(trimesh.util.concatenate([cube(0), cube(0.04)]))
print("two that overlap by half (2400 mm^2):")
over = section(trimesh.util.concatenate([cube(0), cube(0.02)]))
wall = trimesh.Trimesh([[-0.02, -0.02, -0.02], [0.02, 0.02, -0.02], [0.02, 0.02, 0.02], [-0.02, -0.02, 0.02]],
                       [[0, 1, 2], [0, 2, 3]])
print("one with a wall inside (1600 mm^2):")
walled = section(trimesh.util.concatenate([cube(0), wall]))
raise SystemExit(not (abs(one - 1600) < 1 and two < 200 and over < 1600 and walled < 1000))
PYTHON
