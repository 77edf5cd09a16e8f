"""Path queries a second: jostle beside Python with shapely and the `ompl` wheel's RRT-Connect, on the same queries.

    python3 -m venv venv && venv/bin/pip install shapely ompl
    venv/bin/python bench/path_queries.py target/release/jostle [-n 200] [--seconds 1.0]

Both sides run on one thread, one after the other on the same machine; times are of the processor's clock, so that other
work on the machine hardly counts. jostle answers all queries once and ROUNDS times more, with nothing kept from round to
round; the difference is its time, and has the preparation of the scenes in it. The Python side prepares each query's
obstacles beforehand, as is fair: buffered by the clearance, in one prepared multipolygon. A motion is checked at the
resolution that is OMPL's default (1 % of the space's extent); jostle's checks are exact. Both shorten their paths.
Prints one JSON object.
"""

import argparse
import json
import math
import resource
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import shapely
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou
from shapely.affinity import affine_transform


def polygon(shape):
    """A shapely polygon of a shape as scene files write it."""
    (kind, value), = shape.items()
    if kind in ("convex_polygon", "polygon"):
        return shapely.Polygon(value)
    if kind == "disc":
        return shapely.Point(0, 0).buffer(value["radius"])
    raise ValueError(kind)


def at(shape, x, y, theta):
    c, s = math.cos(theta), math.sin(theta)
    return affine_transform(shape, [c, -s, s, c, x, y])


class Query:
    def __init__(self, query, clearance, turn_weight):
        body = query["body"]
        shapes = [polygon(b["shape"]) for b in query["bodies"]]
        poses = [(p["x"], p["y"], p.get("theta", 0.0)) for p in query["poses"]]
        self.shape = shapes[body]
        others = [at(s, *p).buffer(clearance) for i, (s, p) in enumerate(zip(shapes, poses)) if i != body]
        self.others = shapely.unary_union(others)
        shapely.prepare(self.others)
        low, high = query["workspace"]["min"], query["workspace"]["max"]
        self.low, self.high = low, high
        self.table = shapely.box(low[0] - 1e-6, low[1] - 1e-6, high[0] + 1e-6, high[1] + 1e-6)
        shapely.prepare(self.table)
        self.start = poses[body]
        goal = query["to"]
        self.goal = (goal["x"], goal["y"], goal.get("theta", 0.0))
        self.turn_weight = turn_weight

    def free(self, state):
        moved = at(self.shape, state.getX(), state.getY(), state.getYaw())
        return self.table.contains(moved) and not self.others.intersects(moved)

    def solve(self, seconds):
        """Seconds of the processor, and the path's length or none."""
        begin = time.thread_time()
        space = ob.SE2StateSpace()
        bounds = ob.RealVectorBounds(2)
        for axis in range(2):
            bounds.setLow(axis, self.low[axis])
            bounds.setHigh(axis, self.high[axis])
        space.setBounds(bounds)
        space.setSubspaceWeight(1, self.turn_weight)
        setup = og.SimpleSetup(space)
        setup.setStateValidityChecker(self.free)
        start, goal = space.allocState(), space.allocState()
        for state, (x, y, theta) in ((start, self.start), (goal, self.goal)):
            state.setX(x)
            state.setY(y)
            state.setYaw(math.remainder(theta, math.tau))
        setup.setStartAndGoalStates(start, goal)
        setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
        solved = setup.solve(seconds)
        length = None
        if solved and setup.haveExactSolutionPath():
            setup.simplifySolution()
            length = setup.getSolutionPath().length()
        return time.thread_time() - begin, length


def processor_seconds(jostle, queries, folder, rounds):
    """Seconds of the processor that jostle takes to answer the queries once."""
    file = Path(folder) / "some.json"
    file.write_text(json.dumps(queries))
    used = []
    for times in (1, 1 + rounds):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([jostle, "bench", "path", file, "--rounds", str(times)], check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return (used[1] - used[0]) / rounds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("jostle", help="the command-line tool")
    parser.add_argument("-n", type=int, default=200, help="queries")
    parser.add_argument("--seconds", type=float, default=1.0, help="limit of one query in Python")
    parser.add_argument("--rounds", type=int, default=20, help="times that jostle answers each query")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    ou.RNG.setSeed(args.seed + 1)

    with tempfile.TemporaryDirectory() as folder:
        file, report = Path(folder) / "queries.json", Path(folder) / "report.json"
        subprocess.run(
            [args.jostle, "bench", "path", file, "-n", str(args.n), "--seed", str(args.seed), "--json", report],
            check=True, stdout=subprocess.DEVNULL,
        )
        queries = json.loads(file.read_text())
        ours = json.loads(report.read_text())

        times, lengths = [], []
        for query in queries["queries"]:
            seconds, length = Query(query, queries["clearance"], queries["turn_weight"]).solve(args.seconds)
            times.append(seconds)
            lengths.append(length)

        solved_by_both = [i for i, (a, b) in enumerate(zip(ours["lengths"], lengths)) if a is not None and b is not None]
        ours_all = processor_seconds(args.jostle, queries, folder, args.rounds)
        some = {**queries, "queries": [queries["queries"][i] for i in solved_by_both]}
        ours_both = processor_seconds(args.jostle, some, folder, args.rounds)

    both = [(ours["lengths"][i], lengths[i]) for i in solved_by_both]
    n = len(times)

    def side(seconds, lengths):
        return {
            "queries_per_second": n / seconds,
            "solved": sum(x is not None for x in lengths),
        }

    solved = [i for i, length in enumerate(lengths) if length is not None]
    print(json.dumps({
        "queries": n,
        "machine": ours["machine"],
        "limit_s": args.seconds,
        "jostle": {**side(ours_all, ours["lengths"]), "answers": ours["answers"]},
        "python": {
            **side(sum(times), lengths),
            "median_ms": statistics.median(times) * 1e3,
            "median_ms_solved": statistics.median(times[i] for i in solved) * 1e3 if solved else None,
        },
        "ratio_queries_per_second": sum(times) / ours_all,
        "ratio_solved_by_both": sum(times[i] for i in solved_by_both) / ours_both,
        "solved_by_both": len(solved_by_both),
        "mean_length_m": {
            "jostle": statistics.mean(a for a, _ in both) if both else None,
            "python": statistics.mean(b for _, b in both) if both else None,
        },
        "only_jostle_solved": sum(a is not None and b is None for a, b in zip(ours["lengths"], lengths)),
        "only_python_solved": sum(a is None and b is not None for a, b in zip(ours["lengths"], lengths)),
        "enclosed_by_jostle_but_solved_by_python": sum(
            k == "enclosed" and b is not None for k, b in zip(ours["kinds"], lengths)
        ),
    }, indent=1))


if __name__ == "__main__":
    main()
