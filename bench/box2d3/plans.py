#!/usr/bin/env python3
"""Pushes of plans on suites in Box2D 3 beside jostle's engines: how far apart the pushed bodies end.

    cargo build --release --manifest-path bench/box2d3/Cargo.toml --target-dir target/box2d3
    python3 bench/box2d3/plans.py target/release/jostle target/release/libjostle.so target/box2d3/release/box2d3

The arguments are jostle's tool and its shared library, built with the features cli and bullet, the program beside this
script, and scenes whose bodies are blocks of the library (without any, suites/own-hard and suites/own-confined). Needs
numpy. Prints the tables of docs/which-engine-says-what.md, section "Box2D 3", which says what they mean.

Each scene is planned by `jostle plan` with the planner `hedge`, a budget of iterations and each of the seeds. Each push of
a plan begins where the plan has the bodies then, in every engine. Metres, radians, seconds, kilograms.
"""

import argparse
import ctypes
import json
import math
import statistics
import subprocess
import sys
import tempfile
from itertools import combinations
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
from which_engine import (GRAVITY, PUSH, PUSHED, SETTLE, SPEED, Action, BodyPose, Jostle,  # noqa: E402
                          SimulatorOptions)

# The tip of the suites' gripper: along the push, across it.
TIP = [0.022, 0.030]
# What counts as moved, as in `jostle fidelity`.
MOVED, TURNED = 0.002, math.radians(2)

OURS = {"Bullet": ("bullet", "reference"), "prism": ("prism", "fine"), "planar": ("planar", "fine"),
        "rapier": ("rapier", "fine")}
# `ground`: one motor joint at the centre of mass with this torque; feet, each a motor joint that has a share of the force,
# so far out that they have this torque together; or no joint.
JOINT = {"scale": 10, "length_units": 1, "step": 1 / 240, "substeps": 4, "ground": ("joint", "uniform")}
BOX2D = {
    "joint": JOINT,
    "joint, torque 1.5 radii of gyration": JOINT | {"ground": ("joint", "gyration")},
    "joint, no torque": JOINT | {"ground": ("joint", "none")},
    "feet": JOINT | {"ground": ("feet", "uniform")},
    "feet, torque 1.5 radii of gyration": JOINT | {"ground": ("feet", "gyration")},
    "damping 41 /s": JOINT | {"ground": None, "damping": 41},
    "damping 5 /s": JOINT | {"ground": None, "damping": 5},
    "joint, steps of 1/60 s": JOINT | {"step": 1 / 60},
    "joint, steps of 1/960 s": JOINT | {"step": 1 / 960},
    "joint, contacts made anew": JOINT | {"no_recycling": True},
    "joint, lengths times 100": JOINT | {"scale": 100},
    "joint, metres of 0.01 units": JOINT | {"scale": 1, "length_units": 0.01},
}
# Box2D welds corners nearer than 20 mm there, so the notched block is refused.
METRES = JOINT | {"scale": 1}


# ---- blocks ---------------------------------------------------------------------------------------------------------

def arc_pieces(radius, count=16):
    """The notched block of 90 x 45 mm: a piece from each segment of the notch out to the block's edge, along rays from
    the notch's centre. (Slabs would have sides that Box2D welds.)"""
    def out(angle):
        x, y = math.cos(angle), math.sin(angle)
        reach = min(0.045 / abs(x) if abs(x) > 1e-9 else math.inf, 0.045 / -y if y < -1e-9 else math.inf)
        return x * reach, y * reach + 0.0225

    pieces = []
    for k in range(count):
        a, b = (math.pi * (1 + i / count) for i in (k, k + 1))
        inner = [(radius * math.cos(angle), radius * math.sin(angle) + 0.0225) for angle in (a, b)]
        pieces.append([inner[0], out(a), out(b), inner[1]])
    return pieces


def box(x, y):
    return [[(-x / 2, -y / 2), (x / 2, -y / 2), (x / 2, y / 2), (-x / 2, y / 2)]]


BLOCKS = {"cube": box(0.045, 0.045), "half_cube": box(0.0225, 0.045), "rect": box(0.045, 0.090),
          "triangle": [[(0.0225, 0.045), (-0.0225, 0.0), (0.0225, -0.045)]], "concave": arc_pieces(0.0235),
          "cylinder": [[(0.022 * math.cos(math.tau * k / 256), 0.022 * math.sin(math.tau * k / 256))
                        for k in range(256)]]}


class Block:
    """Pieces and moments of a block of unit mass, and what its friction on the ground may be."""

    def __init__(self, name):
        self.pieces = BLOCKS[name]
        self.disc = 0.022 if name == "cylinder" else None
        cells = [point for piece in self.pieces for point in grid(piece)]
        area = sum(a for a, _, _ in cells)
        self.centre = [sum(a * x for a, x, _ in cells) / area, sum(a * y for a, _, y in cells) / area]
        distances = [(a, math.hypot(x - self.centre[0], y - self.centre[1])) for a, x, y in cells]
        self.inertia = sum(a * d * d for a, d in distances) / area
        corners = [p for piece in self.pieces for p in piece][::32 if self.disc else 1]
        if name == "concave":
            corners = [(x, y) for x in (-0.045, 0.045) for y in (-0.0225, 0.0225)]
        self.corners = [(x - self.centre[0], y - self.centre[1]) for x, y in corners]
        # Greatest torque over greatest force.
        self.radius = {"uniform": sum(a * d for a, d in distances) / area, "gyration": 1.5 * math.sqrt(self.inertia),
                       "none": 0.0}

    def feet(self, ground, force):
        if ground is None:
            return []
        kind, torque = ground
        if kind == "joint":
            return [{"at": self.centre, "force": force, "torque": force * self.radius[torque]}]
        out = self.radius[torque] / statistics.mean(math.hypot(*c) for c in self.corners)
        return [{"at": [self.centre[0] + out * x, self.centre[1] + out * y], "force": force / len(self.corners),
                 "torque": 0.0} for x, y in self.corners]


def grid(piece, n=24):
    """Area and centre of small triangles that a convex piece is cut into."""
    (ax, ay), cells = piece[0], []
    for (bx, by), (cx, cy) in zip(piece[1:], piece[2:]):
        area = abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)) / 2 / n**2
        for i in range(n):
            for j in range(n - i):
                for t, (u, v) in enumerate(((i + 1 / 3, j + 1 / 3), (i + 2 / 3, j + 2 / 3))):
                    if t == 0 or i + j < n - 1:
                        u, v = u / n, v / n
                        cells.append((area, ax + u * (bx - ax) + v * (cx - ax), ay + u * (by - ay) + v * (cy - ay)))
    return cells


KNOWN = {name: Block(name) for name in BLOCKS}


# ---- the pushes of plans --------------------------------------------------------------------------------------------

def pushes_of(tool, path, seed, iterations):
    """Of one plan: (scene with the bodies where the plan has them, start, end of the tip)."""
    command = [tool, "plan", path, "--planner", "hedge", "--seed", str(seed), "--iterations", str(iterations),
               "--threads", "1", "--json"]
    plan = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    scene, found = json.loads(Path(path).read_text()), []
    for action in plan["actions"]:
        if action["kind"] != "push":
            break
        found.append((json.loads(json.dumps(scene)), action["start"], action["end"]))
        for body, pose in zip(scene["bodies"], action["predicted"]):
            body["pose"] = pose
    return found


def ours(push, engine, preset):
    """Poses after the push by an engine of jostle; None where it does not execute the push."""
    scene, start, end = push
    handle, target = ctypes.c_void_p(), ctypes.c_uint64()
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        # Bodies that an engine has left in each other by more than the suite's 6 mm are taken as they are.
        json.dump(scene | {"overlap_tolerance": 0.02}, file)
        file.flush()
        Jostle.call("scene_read", Jostle.context, file.name.encode(), ctypes.byref(handle), ctypes.byref(target))
    options = SimulatorOptions()
    Jostle.call("simulator_options_init", ctypes.byref(options), ctypes.c_size_t(ctypes.sizeof(options)))
    options.engine, options.preset = engine.encode(), preset.encode()
    simulator = ctypes.c_void_p()
    Jostle.call("simulator_new", Jostle.context, handle, ctypes.c_uint64(0), ctypes.byref(options),
                ctypes.byref(simulator))
    Jostle.library.jostle_scene_free(handle)
    action, effect = Action(kind=PUSH), ctypes.c_int32()
    action.push[:] = [*start, *end]
    Jostle.call("simulator_execute", simulator, ctypes.byref(action), ctypes.byref(effect))
    poses, count = (BodyPose * len(scene["bodies"]))(), ctypes.c_size_t()
    Jostle.call("simulator_poses", simulator, poses, ctypes.c_size_t(len(poses)), ctypes.byref(count))
    Jostle.library.jostle_simulator_free(simulator)
    return [tuple(p.pose) for p in poses] if effect.value == PUSHED else None


def box2d(program, pushes, settings, still=False, left=0.0):
    """Poses after each push by Box2D; `still`: nothing is pushed; `left`: the tip moved so far to its left."""
    lines = [json.dumps(settings)]
    for scene, (ax, ay), (bx, by) in pushes:
        bodies, long = [], math.dist((ax, ay), (bx, by))
        dx, dy = left * (ay - by) / long, left * (bx - ax) / long
        path = None if still else [[ax + dx, ay + dy], [bx + dx, by + dy]]
        for body in scene["bodies"]:
            block, mass, friction = KNOWN[body["block"]], body.get("mass", 0.1), body.get("friction", 0.5)
            force = scene["friction"]["ground"] * friction * mass * GRAVITY
            pose = [body["pose"].get(key, 0.0) for key in ("x", "y", "theta")]
            bodies.append({"pose": pose, "pieces": [] if block.disc else block.pieces, "disc": block.disc, "mass": mass,
                           "centre": block.centre, "inertia": mass * block.inertia, "friction": friction,
                           "feet": block.feet(settings["ground"], force)})
        lines.append(json.dumps({"bodies": bodies, "path": path, "tip": TIP, "tip_friction": scene["friction"]["tip"],
                                 "speed": SPEED, "settle": SETTLE}))
    done = subprocess.run([program], input="\n".join(lines) + "\n", check=True, stdout=subprocess.PIPE, text=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


# ---- tables ---------------------------------------------------------------------------------------------------------

def apart(before, after):
    return math.dist(before[:2], after[:2]), abs(math.remainder(after[2] - before[2], math.tau))


def differences(pushes, a, b):
    """Of bodies that moved by either engine: mm and degrees between the two."""
    found = []
    for (scene, _, _), pa, pb in zip(pushes, a, b):
        for body, qa, qb in zip(scene["bodies"], pa, pb):
            start = [body["pose"].get(key, 0.0) for key in ("x", "y", "theta")]
            if any(way > MOVED or turn > TURNED for way, turn in (apart(start, qa), apart(start, qb))):
                way, turn = apart(qa, qb)
                found.append((1e3 * way, math.degrees(turn)))
    return found


def share(values, of):
    values = sorted(values)
    return values[min(len(values) - 1, math.ceil(of * len(values)) - 1)]


def cell(found):
    """Median and 90 % of position, median turn."""
    return (f"{statistics.median(w for w, _ in found):.1f}, {share([w for w, _ in found], 0.9):.1f} mm, "
            f"{statistics.median(t for _, t in found):.1f}°")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tool")
    parser.add_argument("library")
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=512)
    args = parser.parse_args()
    scenes = args.scenes or sorted(map(str, (ROOT / "suites").glob("own-[hc]*/*.json")))
    Jostle.load(args.library)
    pushes, seen = [], set()
    for path in scenes:
        for seed in range(args.seeds):
            for push in pushes_of(args.tool, path, seed, args.iterations):
                if (key := json.dumps(push)) not in seen:
                    seen.add(key)
                    pushes.append(push)
    results = {name: [ours(push, *engine) for push in pushes] for name, engine in OURS.items()}
    whole = [i for i in range(len(pushes)) if all(r[i] is not None for r in results.values())]
    convex = [all(b["block"] != "concave" for b in push[0]["bodies"]) for push in pushes]
    print(f"{Jostle.library.jostle_version().decode()}: {len(scenes)} scenes, "
          f"{sum('concave' not in Path(path).read_text() for path in scenes)} without concave bodies; {len(pushes)} "
          f"pushes, of which every engine of ours executes {len(whole)}; {sum(convex[i] for i in whole)} of these among "
          "convex bodies alone")
    pick = lambda values, among: [values[i] for i in among]
    for name, settings in BOX2D.items():
        results[name] = box2d(args.program, pushes, settings)
    names = list(OURS)
    print(f"\n| engine | {' | '.join(names)} |\n|---|{'---|' * len(names)}")
    counts = []
    for name in results:
        cells = []
        for other in names:
            found = differences(pick(pushes, whole), pick(results[name], whole), pick(results[other], whole))
            cells.append(cell(found) if other != name else "")
            counts.append(len(found))
        print(f"| {name} | {' | '.join(cells)} |")
    among = [i for i in whole if convex[i]]
    print(f"\nBodies compared: {min(counts)} to {max(counts)}")
    flat = [pushes[i] for i in among]
    chosen = {name: pick(results[name], among) for name in (*names, "joint", "feet", "damping 41 /s")}
    chosen["joint, metres"] = box2d(args.program, flat, METRES)
    print("\nConvex bodies alone:")
    for a, b in [*combinations(names, 2), *((a, b) for a in list(chosen)[len(names):] for b in names)]:
        found = differences(flat, chosen[a], chosen[b])
        print(f"{a} and {b}: {cell(found)} ({len(found)} bodies)")
    print("\nAgainst Box2D's first row:")
    results["joint, the tip 0.1 mm to the left"] = box2d(args.program, pushes, JOINT, left=1e-4)
    for name in list(results)[len(names) + 1:]:
        found = differences(pick(pushes, whole), pick(results["joint"], whole), pick(results[name], whole))
        print(f"{name}: {cell(found)} ({len(found)} bodies)")
    for name, among, settings in (("joint", pushes, JOINT), ("joint, metres", flat, METRES)):
        ways = [1e3 * apart([b["pose"][k] for k in ("x", "y", "theta")], pose)[0]
                for (scene, _, _), poses in zip(among, box2d(args.program, among, settings, still=True))
                for b, pose in zip(scene["bodies"], poses)]
        print(f"\nWith nothing pushed ({name}) bodies move by {statistics.median(ways):.2f} mm in the median, "
              f"{share(ways, 0.9):.2f} (90 %), {max(ways):.2f} at most")


if __name__ == "__main__":
    main()
