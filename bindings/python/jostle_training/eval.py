"""Judges a checkpoint or an exported model on shapes and scenes it never saw, and prints JSON.

    python -m jostle_training.eval models/dipn.onnx --data DATA/push-prism --samples 3000
"""

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np
import onnx
import torch

from . import export, nets, selftest
from .data import TEST, TRAIN, VALIDATION, manifest, manifest_hash
from .shapes import iou
from .tasks import TASKS, arg_max, best_threshold, instances, ranking


class Exported:
    """An ONNX file called like a network."""

    def __init__(self, path):
        model = onnx.load(path)
        self.properties = {p.key: p.value for p in model.metadata_props}
        self.kind, self.session = self.properties["kind"], export.session(str(path))
        self.asked = {i.name for i in self.session.get_inputs()}
        self.config = dict(kind=self.kind)

    def __call__(self, *inputs):
        named = zip(nets.module(self.kind).INPUTS, inputs)
        feed = {name: value.numpy() for name, value in named if name in self.asked}
        out = [torch.from_numpy(v) for v in self.session.run(None, feed)]
        return out if len(out) > 1 else out[0]


def load(path):
    """A callable network and its configuration, from a checkpoint or an ONNX file."""
    if path.suffix == ".onnx":
        net = Exported(path)
        return net, net.config
    found = torch.load(path, weights_only=True)
    config = found["config"]
    net = nets.build(config["kind"], config.get("profile", "fast"), **config.get("net", {}))
    net.load_state_dict(found["net"])
    return net.eval(), config


def pick(rows, count, seed=7):
    order = torch.randperm(len(rows), generator=torch.Generator().manual_seed(seed))
    return rows[order[:count]]


# Lengths about 5 cm and about 10 cm, metres.
BANDS = {"all": (0.0, 1.0), "5cm": (0.04, 0.06), "10cm": (0.09, 0.11)}
MOVED = (1e-3, math.radians(1.0))


def pushes(net, data, rows):
    """1 - IoU per body as the dissertation measures it, and errors of position and rotation of the moved bodies; the
    same of the planar engine, of no motion, and of a motion with the tip of what the tip meets."""
    gathered = {name: [] for name in ("network", "planar", "static", "translate")}
    truth, lengths, outlines, centres = [], [], [], []
    for part in rows.split(200):
        batch = data.batch(part)
        there = batch["present"] > 0
        inputs = [batch[k] for k in nets.module("dipn").INPUTS]
        motion = net(*inputs)
        still = torch.zeros_like(motion)
        for name, m in (("network", motion), ("planar", batch["guess"]), ("static", still), ("translate", along(batch))):
            gathered[name].append(m[there].numpy())
        truth.append(batch["motion"][there].numpy())
        outlines.append(batch["outline"][there].numpy())
        centres.append(batch["centre"][there].numpy())
        lengths.append(batch["push"][:, :1].expand_as(batch["present"])[there].numpy())
    truth, outlines, centres, lengths = map(np.concatenate, (truth, outlines, centres, lengths))
    moved = (np.linalg.norm(truth[:, :2], axis=1) > MOVED[0]) | (np.abs(truth[:, 2]) > MOVED[1])
    out = {"pushes": len(rows), "bodies": len(truth), "moved_bodies": int(moved.sum())}
    for name, parts in gathered.items():
        m = np.concatenate(parts)
        overlap = iou(outlines, centres, m, truth)
        position = np.linalg.norm(m[:, :2] - truth[:, :2], axis=1) * 1e3
        rotation = np.degrees(np.abs((m[:, 2] - truth[:, 2] + np.pi) % (2 * np.pi) - np.pi))
        out[name] = {}
        for band, (low, high) in BANDS.items():
            mine = (lengths >= low) & (lengths <= high)
            some = mine & moved
            if not some.any():
                continue
            out[name][band] = dict(
                one_minus_iou=round(float(1 - overlap[mine].mean()), 4),
                moved_iou=round(float(overlap[some].mean()), 4),
                moved_position_mm=round(float(position[some].mean()), 3),
                moved_position_median_mm=round(float(np.median(position[some])), 3),
                moved_rotation_deg=round(float(rotation[some].mean()), 3),
                rotation_deg=round(float(rotation[mine].mean()), 4))
    return out


def along(batch):
    """The bodies that the tip meets move with it from there on, without turning; all others stay."""
    length, width, thickness = batch["push"][:, :1], batch["push"][:, 1:2], batch["push"][:, 2:3]
    x = batch["outline"][..., 0] + batch["centre"][..., :1]
    y = batch["outline"][..., 1] + batch["centre"][..., 1:]
    before = (y.abs() < width[:, None] / 2) & (x > 0)
    first = torch.where(before, x, torch.full_like(x, 1e3)).amin(2) - thickness / 2
    shift = (length - first).clamp(min=0) * batch["present"]
    return torch.stack([shift, torch.zeros_like(shift), torch.zeros_like(shift)], -1)


def speed(path, kind, repeats=20):
    """Least CPU milliseconds on one thread, of a call and of an item in it, with ten bodies."""
    batch = {"dipn": 64, "ppn": 40}.get(kind, 1)
    model = export.session(str(path))
    asked = {i.name for i in model.get_inputs()}
    feed = {k: v for k, v in selftest.inputs(export.input_shapes(kind, batch, 10), 3).items() if k in asked}
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        model.run(None, feed)
        times.append((time.thread_time() - start) * 1e3)
    return dict(batch=batch, call_ms=round(min(times), 3), item_ms=round(min(times) / batch, 4))


def probability_of(net, data, rows):
    return torch.cat([net(data.images(part)) for part in rows.split(20)])


def graspable(net, data, best, rows, threshold=None, least=0.3, validation=4000):
    """Accuracy at the threshold (chosen on the validation split), and how often each stated probability comes true.
    `best` is the best score of every target."""
    if threshold is None:
        held = pick(data.rows[VALIDATION], validation)
        _, threshold = best_threshold(probability_of(net, data, held), best[held] >= least)
    probability, truth = probability_of(net, data, rows), best[rows] >= least
    said = probability >= threshold
    table = []
    for k in range(10):
        mine = (probability >= k / 10) & (probability < (k + 1) / 10 if k < 9 else probability <= 1)
        if mine.any():
            table.append(dict(stated=round(float(probability[mine].mean()), 3),
                              true=round(float(truth[mine].float().mean()), 3), states=int(mine.sum())))
    near = (best[rows] - least).abs() < 0.05
    rate = lambda hit, of: round(float(hit.sum() / of.sum().clamp(min=1)), 4)
    return dict(
        states=len(rows), threshold=threshold, accuracy=rate(said == truth, torch.ones(len(rows))),
        majority=round(max(float(truth.float().mean()), 1 - float(truth.float().mean())), 4),
        precision=rate(said & truth, said.float()), recall=rate(said & truth, truth.float()),
        accuracy_away_from_limit=rate((said == truth) & ~near, (~near).float()), reliability=table)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("model", type=Path, help="checkpoint (.pt) or exported model (.onnx)")
    p.add_argument("--data", required=True)
    p.add_argument("--samples", type=int, default=3000)
    p.add_argument("--split", choices=("validation", "test"), default="test")
    p.add_argument("--threshold", type=float, help="of gc; without it the best one on the validation split")
    p.add_argument("-o", "--output", type=Path)
    args = p.parse_args()
    torch.set_num_threads(1)
    net, config = load(args.model)
    kind = config["kind"]
    data = TASKS[kind].table(args.data)
    rows = pick(data.rows[TEST if args.split == "test" else VALIDATION], args.samples)
    with torch.no_grad():
        if kind == "dipn":
            figures = pushes(net, data, rows)
            length = data.table["push"][data.rows[TRAIN], 0]
            lengths = [round(float(length.min()), 3), round(float(length.max()), 3)]
        elif kind == "ppn":
            figures = ranking(net, data, rows)
        elif kind == "gc":
            least = config.get("least_score", 0.3)
            figures = graspable(net, data, data.table["score"], rows, args.threshold, least)
            # Where a grasp on the grid counts as well that the test's own search does not know.
            figures["with_grid"] = graspable(net, data, data.best, rows, args.threshold, least)
        elif kind == "segmentation":
            figures = instances(net, data, rows)
        else:
            figures = arg_max(net, data, rows)
            figures["at_least_0.3"] = arg_max(net, data, rows, 0.3)
            # The greatest quality as an answer to whether the target can be grasped; the threshold is that of the map.
            figures["graspable"] = graspable(
                lambda image: net(image).flatten(1).amax(1), data, data.best, rows, args.threshold)
            figures["threshold"] = figures["graspable"]["threshold"]
    found = about(args.data)
    if kind == "dipn":
        found["lengths"] = lengths
    report = dict(kind=kind, split=args.split, metrics=figures, data=found, dataset_sha256=manifest_hash(args.data))
    if args.model.suffix == ".onnx":
        report["speed"] = speed(args.model, kind)
    if "threshold" in figures:
        report["threshold"] = figures["threshold"]
    text = json.dumps(report, indent=1)
    if args.output:
        args.output.write_text(text + "\n")
    print(text)


def about(folder):
    """What the manifest says that the metadata repeats."""
    found = manifest(folder)
    out = dict(count=found.get("count"))
    for part in found.get("configuration", {}).values():
        physics = part.get("physics") if isinstance(part, dict) else None
        if physics:
            out["engine"] = " ".join(physics[k] for k in ("engine", "preset") if physics.get(k))
    return out


if __name__ == "__main__":
    main()
