#!/usr/bin/env bash
# trimesh 5.2.0, 2026-11-30.
# One would guess: negative indices in an OBJ file count back from the vertices read so far, as the format says, since
# exporters that write relative indices are common.
# What is so: they count back from the last vertex of the whole file. A file of one object whose faces come last is
# read right; of two cubes, each with its faces behind its vertices, both become the second one, without a word.
# Why it matters: a scene of several bodies in one file comes in as the last body several times. Look at the bounds of
# what was read, or write positive indices.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import io
import trimesh

CORNERS = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
FACES = [(4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]

def cubes(relative):
    lines = []
    for k in range(2):
        lines += [f"o cube{k}"] + [f"v {x + 3 * k} {y} {z}" for x, y, z in CORNERS]
        lines += ["f " + " ".join(str(i - 9 if relative else i + 8 * k) for i in face) for face in FACES]
    return trimesh.load(io.StringIO("\n".join(lines)), file_type="obj", force="mesh")

bounds = {}
for name, relative in (("positive", False), ("relative", True)):
    mesh = cubes(relative)
    bounds[name] = mesh.bounds[:, 0].tolist()
    print(f"trimesh {trimesh.__version__}, {name} indices: two cubes of x = 0 to 1 and 3 to 4 are read as {len(mesh.faces)} faces "
          f"from x = {bounds[name][0]} to {bounds[name][1]}, volume {mesh.volume:.1f}")
raise SystemExit(bounds != {"positive": [0.0, 4.0], "relative": [3.0, 4.0]})
PYTHON
