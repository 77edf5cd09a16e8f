"""Shards of `jostle datagen` as tensors.

A folder holds `shapes.safetensors`, shards (`*.safetensors`) and `manifest.json`. Everything is metres and radians.
Splits are 0 train, 1 validation, 2 test; they differ in shapes and in scenes.
"""

import hashlib
import json
import math
from pathlib import Path

import numpy as np
import torch
from safetensors import SafetensorError, safe_open

TRAIN, VALIDATION, TEST = 0, 1, 2
POINTS = 32
CROP, CELLS, ANGLES = 112, 56, 16


def shard_paths(folder):
    return sorted(p for p in Path(folder).glob("*.safetensors") if p.name != "shapes.safetensors")


def manifest_hash(folder):
    """SHA-256 of the manifest, which lists the hash of every shard; None where there is none yet."""
    path = Path(folder) / "manifest.json"
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else None


def manifest(folder):
    path = Path(folder) / "manifest.json"
    return json.loads(path.read_text()) if path.exists() else {}


def read(path, names=None):
    """The tensors of one file; None where it cannot be read (yet)."""
    try:
        with safe_open(path, "pt") as f:
            return {name: f.get_tensor(name) for name in (names or f.keys())}
    except (SafetensorError, OSError):
        return None


def turn(vector, angle):
    """vector [..., 2] turned by angle [...]."""
    c, s = angle.cos(), angle.sin()
    x, y = vector[..., 0], vector[..., 1]
    return torch.stack([c * x - s * y, s * x + c * y], -1)


def mirrored(inputs, sign):
    """Inputs of an object network seen in a mirror where sign [B] is -1: y and angles change their sign."""
    flip = torch.stack([torch.ones_like(sign), sign], -1)
    out = dict(inputs)
    # A mirrored outline runs clockwise; reversed it runs counter-clockwise again.
    outline = inputs["outline"] * flip[:, None, None]
    out["outline"] = torch.where((sign < 0)[:, None, None, None], outline.flip(2), outline)
    out["centre"] = inputs["centre"] * flip[:, None]
    for name in ("guess", "motion"):
        if name in inputs:
            out[name] = inputs[name] * torch.cat([flip, sign[:, None]], -1)[:, None]
    return out


class Shards:
    """All shards of a folder as one table, and those that arrive later."""

    columns = ()

    def __init__(self, folder, limit=None):
        self.folder, self.limit, self.seen = Path(folder), limit, set()
        self.outline = read(self.folder / "shapes.safetensors", ["outline"])["outline"]
        self.table = {}
        self.refresh()
        if not self.table:
            raise FileNotFoundError(f"{folder} has no shards")

    def __len__(self):
        return len(self.table["split"])

    def refresh(self):
        """Takes in shards that were not there before; says whether there were any."""
        fresh = []
        for path in shard_paths(self.folder):
            if path in self.seen or self.limit and self.table and len(self) >= self.limit:
                continue
            shard = read(path)
            if shard is not None:
                self.seen.add(path)
                fresh.append(self.prepare(shard))
        if fresh:
            parts = ([self.table] if self.table else []) + fresh
            self.table = self.join(parts)
            self.index()
        return bool(fresh)

    @staticmethod
    def join(parts):
        return {name: torch.cat([padded(p[name], parts, name) for p in parts]) for name in parts[0]}

    def prepare(self, shard):
        raise NotImplementedError

    def index(self):
        self.rows = {s: torch.nonzero(self.table["split"] == s).squeeze(1) for s in (TRAIN, VALIDATION, TEST)}


def padded(tensor, parts, name):
    """Grows the axis of bodies, so that shards of fewer bodies join those of more."""
    if tensor.dim() < 2:
        return tensor
    most = max(p[name].shape[1] for p in parts)
    if tensor.shape[1] == most:
        return tensor
    grown = tensor.new_zeros(tensor.shape[:1] + (most,) + tensor.shape[2:])
    grown[:, : tensor.shape[1]] = tensor
    return grown


def in_push_frame(push, centre, heading):
    """Push [..., 4] in the world; centre and heading with one more axis (bodies). Frame: origin at the start, +x along
    the push. Returns centres, headings, length and the push's angle."""
    along = push[..., 2:] - push[..., :2]
    angle = torch.atan2(along[..., 1], along[..., 0])
    at = turn(centre - push[..., None, :2], -angle[..., None].expand(heading.shape))
    return at, heading - angle[..., None], along.norm(dim=-1), angle


class Pushes(Shards):
    """format jostle/push/1. Rows are kept in the push frame; bodies near the push come first."""

    MOVED = 2e-4  # metres or radians
    NEAR = 0.09  # metres from the push's line to a centre: what lies farther and does not move may be left out

    def prepare(self, shard):
        n, push = shard["n"].long(), shard["push"]
        start = shard["pose0"]
        slots = start.shape[1]
        present = torch.arange(slots) < n[:, None]
        centre, heading, length, angle = in_push_frame(push, start[..., :2], start[..., 2])
        wide = angle[:, None].expand(heading.shape)
        difference = shard["pose1"] - start
        motion = torch.cat([turn(difference[..., :2], -wide), difference[..., 2:]], -1)
        guess = shard["guess"]
        guess = torch.cat([turn(guess[..., :2], -wide), guess[..., 2:]], -1)
        nearest = torch.minimum(centre[..., 0].clamp(min=0), length[:, None])
        distance = (centre - torch.stack([nearest, torch.zeros_like(nearest)], -1)).norm(dim=-1)
        moved = ((motion.abs() > self.MOVED) | (guess.abs() > self.MOVED)).any(-1)
        distance = torch.where(moved, distance * 0.01, distance)
        distance = torch.where(present, distance, torch.full_like(distance, 1e3))
        near = (distance < self.NEAR).sum(1).clamp(min=1)
        order = distance.argsort(1)
        take = lambda t: torch.gather(t, 1, order.reshape(order.shape + (1,) * (t.dim() - 2)).expand(t.shape))
        present = take(present)
        zero = lambda t: take(t) * present.reshape(present.shape + (1,) * (t.dim() - 2))
        return dict(
            n=n, near=near, shape=take(shard["shape"].long()) * present, centre=zero(centre), heading=zero(heading),
            motion=zero(motion), guess=zero(guess), body=zero(shard["body"]), split=shard["split"].long(),
            push=torch.cat([length[:, None], shard["tip"]], -1), scene=shard["scene"])

    def batch(self, rows, bodies=None):
        """Inputs and the label `motion` of rows, with the first `bodies` bodies of each."""
        t = self.table
        bodies = int(bodies or t["n"][rows].max())
        present = (torch.arange(bodies) < t["n"][rows][:, None]).float()
        pick = lambda name: t[name][rows, :bodies]
        outline = turn(self.outline[pick("shape")], pick("heading")[..., None].expand(-1, -1, POINTS))
        return dict(
            outline=outline * present[..., None, None], centre=pick("centre"), body=pick("body"),
            push=t["push"][rows], guess=pick("guess"), present=present, motion=pick("motion"))

    def groups(self, split):
        """Rows by how many bodies they need (rounded up to an even number)."""
        rows = self.rows[split]
        need = (self.table["near"][rows] + 1) // 2 * 2
        return {int(k): rows[need == k] for k in need.unique()}


class Values(Shards):
    """format jostle/ppn/1: states with the value of each push."""

    def prepare(self, shard):
        start = shard["push_start"]
        return dict(
            n=shard["n"].long(), shape=shard["shape"].long(), pose=shard["pose"], body=shard["body"],
            tip=shard["tip"], target=shard["target"].long(), split=shard["split"].long(), scene=shard["scene"],
            count=start[1:] - start[:-1], push=shard["push"], q=shard["q"], visits=shard["visits"].float())

    @staticmethod
    def join(parts):
        long = ("push", "q", "visits")
        table = Shards.join([{k: v for k, v in p.items() if k not in long} for p in parts])
        table.update({name: torch.cat([p[name] for p in parts]) for name in long})
        return table

    def index(self):
        # A state with fewer than two pushes has nothing to compare.
        count = self.table["count"]
        self.first = torch.cat([count.new_zeros(1), count.cumsum(0)])
        self.rows = {s: torch.nonzero((self.table["split"] == s) & (count > 1)).squeeze(1)
                     for s in (TRAIN, VALIDATION, TEST)}

    def batch(self, states):
        """One row per push of the states; `state` says of which."""
        t = self.table
        pushes = torch.cat([torch.arange(int(self.first[s]), int(self.first[s + 1])) for s in states.tolist()])
        counts = t["count"][states]
        which = torch.repeat_interleave(torch.arange(len(states)), counts)
        rows = states[which]
        bodies = int(t["n"][states].max())
        present = (torch.arange(bodies) < t["n"][rows][:, None]).float()
        pose, push = t["pose"][rows, :bodies], t["push"][pushes]
        centre, heading, length, _ = in_push_frame(push, pose[..., :2], pose[..., 2])
        outline = turn(self.outline[t["shape"][rows, :bodies]], heading[..., None].expand(-1, -1, POINTS))
        return dict(
            outline=outline * present[..., None, None], centre=centre * present[..., None],
            body=t["body"][rows, :bodies], push=torch.cat([length[:, None], t["tip"][rows]], -1), present=present,
            target=torch.nn.functional.one_hot(t["target"][rows], bodies).float(), q=t["q"][pushes],
            visits=t["visits"][pushes], state=which)


class Grasps(Shards):
    """format jostle/grasp/1: target-centred crops, the best score, and the map of scores."""

    def prepare(self, shard):
        start = shard["cell_start"].long()
        return dict(
            split=shard["split"].long(), score=shard["score"].float(), target=shard["target"].long(),
            label_map=shard["label_map"].reshape(len(start) - 1, -1), heights=shard["heights"].float(),
            scene=shard["scene"], count=start[1:] - start[:-1],
            cell=shard["cell"].long().to(torch.int32), cell_score=shard["cell_score"].half())

    @staticmethod
    def join(parts):
        long = ("cell", "cell_score")
        table = Shards.join([{k: v for k, v in p.items() if k not in long} for p in parts])
        table.update({name: torch.cat([p[name] for p in parts]) for name in long})
        return table

    def index(self):
        super().index()
        t = self.table
        count = t["count"]
        self.first = torch.cat([count.new_zeros(1), count.cumsum(0)])
        # The best grasp that is known: that of the test's own search, or one on the grid.
        row = torch.repeat_interleave(torch.arange(len(count)), count)
        self.best = t["score"].scatter_reduce(0, row, t["cell_score"].float(), "amax")

    def images(self, rows):
        """[B,2,112,112]: height of everything; 1 at the target."""
        t = self.table
        label = t["label_map"][rows].long()
        heights = torch.cat([torch.zeros(len(rows), 1), t["heights"][rows]], 1)
        image = torch.stack([heights.gather(1, label), (label == t["target"][rows][:, None] + 1).float()], 1)
        return image.reshape(-1, 2, CROP, CROP)

    def maps(self, rows):
        """[B,16,56,56]: score of a grasp at each cell and angle."""
        t = self.table
        out = torch.zeros(len(rows), ANGLES * CELLS * CELLS)
        for i, row in enumerate(rows.tolist()):
            a, b = int(self.first[row]), int(self.first[row + 1])
            out[i, t["cell"][a:b].long()] = t["cell_score"][a:b].float()
        return out.reshape(-1, ANGLES, CELLS, CELLS)


class Scenes(Shards):
    """format jostle/segment/1: which body each pixel of a scene shows."""

    SIDE, PIXEL = 224, 0.002
    MIDDLE = (0.5, 0.0)  # of the image in the world, metres

    def prepare(self, shard):
        return dict(
            split=shard["split"].long(), scene=shard["scene"], label_map=shard["label_map"].flatten(1),
            heights=shard["heights"].float(), centre=shard["pose"][..., :2] - torch.tensor(self.MIDDLE))

    def batch(self, rows, which=0, phase=None):
        """image [B,1,224,224], labels [B,224,224], and the way from each pixel to its body's centre, metres
        [B,2,224,224], all laid down in one of the eight ways; the last two of the pixels [i::2, j::2] alone where `phase`
        is (i, j)."""
        t = self.table
        label, centre = t["label_map"][rows].long(), t["centre"][rows]
        label = label.reshape(-1, self.SIDE, self.SIDE)
        mirror_x, mirror_y, swap = SYMMETRIES[which]
        if mirror_x:
            label, centre = label.flip(-1), centre * torch.tensor([-1.0, 1.0])
        if mirror_y:
            label, centre = label.flip(-2), centre * torch.tensor([1.0, -1.0])
        if swap:
            label, centre = label.transpose(-1, -2), centre.flip(-1)
        flat = label.flatten(1)
        heights = torch.cat([torch.zeros(len(rows), 1), t["heights"][rows]], 1)
        image = heights.gather(1, flat).reshape(-1, 1, self.SIDE, self.SIDE)
        at = (torch.arange(self.SIDE) + 0.5 - self.SIDE / 2) * self.PIXEL
        i, j, step = (*phase, 2) if phase else (0, 0, 1)
        label, x, y = label[:, i::step, j::step].contiguous(), at[j::step], at[i::step]
        index = (label - 1).clamp(min=0).flatten(1)
        own = torch.stack([centre[..., k].gather(1, index).reshape(label.shape) for k in (0, 1)], 1)
        here = torch.stack([x.expand(len(y), -1), y[:, None].expand(-1, len(x))])
        return dict(image=image, label=label, offset=(own - here) * (label > 0)[:, None])


# The eight ways to lay a square on itself: mirror x, mirror y, swap x and y.
SYMMETRIES = [(x, y, s) for x in (0, 1) for y in (0, 1) for s in (0, 1)]


def symmetric(image, quality, which):
    """An image [..., H, W] and its grasp map, laid down another way. Columns are x and rows y; angle k is k*pi/16."""
    mirror_x, mirror_y, swap = SYMMETRIES[which]
    for flip, axis in ((mirror_x, -1), (mirror_y, -2)):
        if flip:
            image = image.flip(axis)
            if quality is not None:
                quality = quality.flip(axis).index_select(-3, (ANGLES - torch.arange(ANGLES)) % ANGLES)
    if swap:
        image = image.transpose(-1, -2)
        if quality is not None:
            quality = quality.transpose(-1, -2).index_select(-3, (ANGLES // 2 - torch.arange(ANGLES)) % ANGLES)
    return image, quality
