#!/usr/bin/env bash
# MuJoCo 4.0.0, 2026-11-30 (trimesh 5.2.0 makes the meshes).
# One would guess: the mass of a mesh geom is density times volume, exact for a closed mesh, or at worst that of the
# convex hull which collides.
# What is so: the default is the legacy rule, which counts every inward face as if it faced out. A closed ring weighs 4.7
# times its volume, and 1.24 times its convex hull; an L 1.41 times its volume. inertia="exact" on the mesh is right.
# Why it matters: hollow and notched objects (cups, rings, brackets) are pushed with a wrong mass and inertia, so a
# planner's masses cannot be compared. Ask for inertia="exact", or give mass and inertia.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 trimesh==5.2.0 shapely==2.2.0 mapbox_earcut==2.1.0 numpy scipy
cd "$folder"
venv/bin/python - <<'PYTHON'
import mujoco
import shapely
import trimesh

ell = shapely.Polygon([(0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)])
meshes = {"ring": trimesh.creation.annulus(0.03, 0.035, 0.08), "L": trimesh.creation.extrude_polygon(ell, 0.03)}
ratios = {}
for name, mesh in meshes.items():
    mesh.export(f"{name}.stl")
    for rule in ("", 'inertia="exact"'):
        model = mujoco.MjModel.from_xml_string(f"""<mujoco><asset><mesh name="m" file="{name}.stl" {rule}/></asset>
          <worldbody><body><freejoint/><geom type="mesh" mesh="m" density="1000"/></body></worldbody></mujoco>""")
        ratios[name, rule] = model.body_mass[1] / (1000 * mesh.volume)
        print(f"mujoco {mujoco.__version__}, {name}, watertight {mesh.is_watertight}, {rule or 'default'}: mass is "
              f"{ratios[name, rule]:.3f} of density x volume, {model.body_mass[1] / (1000 * mesh.convex_hull.volume):.3f} "
              f"of its hull's")
wrong = ratios["ring", ""] > 4 and 1.3 < ratios["L", ""] < 1.5
right = all(abs(ratio - 1) < 1e-3 for (_, rule), ratio in ratios.items() if rule)
raise SystemExit(not (wrong and right))
PYTHON
