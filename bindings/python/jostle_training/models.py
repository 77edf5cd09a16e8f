"""Puts an exported network among those that are built into the library: models/NAME.onnx and its entry in MODELS.toml.

    python -m jostle_training.models ../../models gc DIR/gc.onnx --metrics DIR/gc-metrics.json
"""

import argparse
import hashlib
import json
import re
import shutil
from pathlib import Path

import onnx

HEAD = "[[model]]"


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    return json.dumps(str(value))


# Of figures by group and length of push; the rest is in the file's metadata.
LISTED = ("one_minus_iou", "moved_iou", "moved_rotation_deg")


def flat(figures, prefix=""):
    """Nested figures as one table of numbers."""
    out = {}
    for name, value in figures.items():
        name = prefix + str(name).replace(".", "_")
        if isinstance(value, dict):
            out.update(flat(value, name + "_"))
        elif isinstance(value, (int, float)) and (prefix.count("_") < 2 or name.endswith(LISTED)):
            out[name] = round(value, 4)
    return out


def entry(name, path, metrics):
    properties = {p.key: p.value for p in onnx.load(path).metadata_props}
    lines = [
        HEAD, f"name = {toml(name)}", f"kind = {toml(properties['kind'])}", f"interface = {properties['interface']}",
        f"file = {toml(name + '.onnx')}", f"sha256 = {toml(hashlib.sha256(path.read_bytes()).hexdigest())}",
        f"dataset_sha256 = {toml(properties['dataset_sha256'])}", f"train_commit = {toml(properties['train_commit'])}",
        f"card = {toml(f'CARD-{name}.md')}", "[model.metrics]",
    ]
    return "\n".join(lines + [f"{k} = {toml(v)}" for k, v in flat(metrics).items()]) + "\n"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folder", type=Path, help="models/ of the library")
    p.add_argument("name")
    p.add_argument("model", type=Path)
    p.add_argument("--metrics", type=Path, required=True, help="JSON of jostle_training.eval")
    args = p.parse_args()
    target = args.folder / f"{args.name}.onnx"
    if args.model.resolve() != target.resolve():
        shutil.copyfile(args.model, target)
    table = args.folder / "MODELS.toml"
    text = table.read_text() if table.exists() else "# The networks that are built into the library.\n"
    head, *entries = re.split(rf"^{re.escape(HEAD)}", text, flags=re.MULTILINE)
    kept = [e.rstrip() + "\n" for e in entries if f'name = "{args.name}"' not in e]
    mine = entry(args.name, target, json.loads(args.metrics.read_text())["metrics"])
    entries = sorted([HEAD + e for e in kept] + [mine])
    table.write_text(head.rstrip() + "\n\n" + "\n".join(entries))


if __name__ == "__main__":
    main()
