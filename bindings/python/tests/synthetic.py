"""Small shards in the formats of `jostle datagen`, with plausible but invented labels."""

import json

import numpy as np
from safetensors.numpy import save_file

POINTS = 32


def outline(width, height):
    """32 points evenly along a rectangle, counter-clockwise from its first corner."""
    corners = np.array([[-width, -height], [width, -height], [width, height], [-width, height]]) / 2
    sides = np.roll(corners, -1, 0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    ends = np.concatenate([[0], lengths.cumsum()])
    out = []
    for s in np.arange(POINTS) / POINTS * ends[-1]:
        k = np.searchsorted(ends, s, "right") - 1
        out.append(corners[k] + sides[k] * (s - ends[k]) / lengths[k])
    return np.array(out, np.float32)


def shapes(folder, random):
    sizes = random.uniform(0.02, 0.06, (12, 2))
    save_file({"outline": np.stack([outline(*s) for s in sizes]), "offset": np.zeros((12, 2), np.float32)},
              folder / "shapes.safetensors", {"format": "jostle/shapes/1"})
    return sizes


def states(random, count, bodies):
    n = random.integers(3, bodies + 1, count).astype(np.uint8)
    present = np.arange(bodies) < n[:, None]
    pose = random.uniform(-0.12, 0.12, (count, bodies, 3)).astype(np.float32)
    pose[..., 2] *= 20
    body = np.broadcast_to(np.array([0.1, 0.5, 0.3, 0.045], np.float32), (count, bodies, 4)).copy()
    body[..., 0] += random.uniform(0, 0.1, (count, bodies))
    zero = present[..., None].astype(np.float32)
    split = np.repeat([0, 0, 0, 1, 2], (count + 4) // 5)[:count].astype(np.uint8)
    return dict(n=n, shape=(random.integers(0, 12, (count, bodies)) * present).astype(np.uint16), pose=pose * zero,
                body=body * zero, scene=np.arange(count, dtype=np.int64), split=split)


def pushes(folder, count=400, bodies=5, seed=1):
    random = np.random.default_rng(seed)
    shapes(folder, random)
    s = states(random, count, bodies)
    start = random.uniform(-0.15, 0.15, (count, 2)).astype(np.float32)
    angle = random.uniform(-np.pi, np.pi, count)
    along = np.stack([np.cos(angle), np.sin(angle)], -1)
    end = (start + along * random.uniform(0.03, 0.12, (count, 1))).astype(np.float32)
    pose0 = s.pop("pose")
    away = pose0[..., :2] - end[:, None]
    close = np.linalg.norm(away, axis=-1) < 0.04
    motion = np.zeros_like(pose0)
    motion[..., :2] = along[:, None] * 0.03 * close[..., None]
    motion[..., 2] = 0.3 * close
    motion *= (np.arange(bodies) < s["n"][:, None])[..., None]
    tip = np.tile(np.array([0.02, 0.01, 0.3], np.float32), (count, 1))
    save_file(dict(s, pose0=pose0, pose1=(pose0 + motion).astype(np.float32),
                   push=np.concatenate([start, end], 1), tip=tip, guess=(motion * 0.8).astype(np.float32)),
              folder / "push-00000.safetensors", {"format": "jostle/push/1"})
    manifest(folder, "push", count)


def values(folder, count=60, bodies=5, seed=2):
    random = np.random.default_rng(seed)
    shapes(folder, random)
    s = states(random, count, bodies)
    counts = random.integers(4, 9, count)
    total = counts.sum()
    push = random.uniform(-0.15, 0.15, (total, 4)).astype(np.float32)
    save_file(dict(s, target=np.zeros(count, np.uint8),
                   push_start=np.concatenate([[0], counts.cumsum()]).astype(np.int64), push=push,
                   q=np.clip(1 - np.linalg.norm(push[:, 2:], axis=1) * 5, 0, 1).astype(np.float32),
                   visits=random.integers(1, 30, total).astype(np.uint32),
                   tip=np.tile(np.array([0.02, 0.01, 0.3], np.float32), (count, 1))),
              folder / "ppn-00000.safetensors", {"format": "jostle/ppn/1"})
    manifest(folder, "ppn", count)


def grasps(folder, count=80, bodies=5, seed=3):
    random = np.random.default_rng(seed)
    shapes(folder, random)
    s = states(random, count, bodies)
    label = np.zeros((count, 112, 112), np.uint8)
    cells, starts, values = [], [0], []
    for k in range(count):
        label[k, 46:66, 50:62] = 1
        free = k % 2
        if not free:
            label[k, 46:66, 64:80] = 2
        mine = [(8 * 56 + r) * 56 + 28 for r in range(24, 32)] if free else []
        cells += mine
        values += [0.8] * len(mine)
        starts.append(len(cells))
    save_file(dict(s, target=np.zeros(count, np.uint8), label_map=label,
                   heights=np.full((count, bodies), 0.045, np.float32),
                   score=(np.arange(count) % 2 * 0.8).astype(np.float32), cell_start=np.array(starts, np.int64),
                   cell=np.array(cells, np.uint32), cell_score=np.array(values, np.float32)),
              folder / "grasp-00000.safetensors", {"format": "jostle/grasp/1"})
    manifest(folder, "grasp", count)


def scenes(folder, count=40, bodies=5, seed=4):
    random = np.random.default_rng(seed)
    shapes(folder, random)
    s = states(random, count, bodies)
    label = np.zeros((count, 224, 224), np.uint8)
    for k in range(count):
        for body in range(int(s["n"][k])):
            row, col = random.integers(20, 200, 2)
            label[k, row - 10 : row + 10, col - 8 : col + 8] = body + 1
            s["pose"][k, body, :2] = ((col - 112) * 0.002 + 0.5, (row - 112) * 0.002)
    save_file(dict(s, label_map=label, heights=np.full((count, bodies), 0.045, np.float32)),
              folder / "segment-00000.safetensors", {"format": "jostle/segment/1"})
    manifest(folder, "segment", count)


def manifest(folder, kind, count):
    (folder / "manifest.json").write_text(json.dumps(dict(kind=kind, count=count, seed=0)))


MAKE = dict(dipn=pushes, ppn=values, gc=grasps, gn=grasps, segmentation=scenes)
