#!/usr/bin/env bash
# trimesh 5.2.0, 2026-11-30.
# One would guess: compute_stable_poses lists few poses of a 40 mm cylinder 50 mm high, the likeliest first: on its side.
# What is so: every facet of the mantle is a pose of its own (34 in all), so the likeliest in the list is standing, at 11 %,
# though the cylinder lies on its side with 78 %. A sphere has 1 280 poses of 0.1 %.
# Why it matters: "take the first stable pose" stands round objects upright. Poses that differ by a turn about the vertical
# or about the axis must be merged (by height and normal) before the likeliest is taken.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy scipy networkx shapely
cd "$folder"
venv/bin/python - <<'PYTHON'
import numpy as np
import trimesh

mesh = trimesh.creation.cylinder(radius=0.02, height=0.05)
poses, chances = trimesh.poses.compute_stable_poses(mesh)
upright = [abs(pose[2, 2]) > 0.999 for pose in poses]
standing = sum(chance for chance, up in zip(chances, upright) if up)
print(f"trimesh {trimesh.__version__}: {len(poses)} poses; the first stands: {upright[0]}, with {chances[0]:.3f}; "
      f"standing {standing:.2f}, lying {sum(chances) - standing:.2f}")
raise SystemExit(not (upright[0] and sum(chances) - standing > 0.7 and len(poses) > 20))
PYTHON
