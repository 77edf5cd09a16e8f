"""MORE's loop: search generated cases, learn what each push is worth, let that guide the search, and again.

    python -m jostle_training.more_loop OUT --jostle ../../target/release/jostle --rounds 3

Round 0 learns from searches of `mcts`, every later round from searches that the network of the round before guides as well.
After every round the network is tried on problems that no round learns from, and OUT/report.md, report.json and report.svg
are written anew. What is there is kept: the same command goes on where it was stopped, and more rounds add to those done.
"""

import argparse
import hashlib
import json
import math
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from .plot import chart

HERE = Path(__file__).resolve().parent.parent
# Apart from the seeds of the rounds' data, which are `seed` and the numbers after it.
HELD_OUT_SEED = 7_000_000


def parameters():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("output", type=Path)
    p.add_argument("--jostle", type=Path, default=Path("jostle"), help="the command-line tool")
    p.add_argument("--rounds", type=int, default=3)
    p.add_argument("--rows", type=int, default=1500, help="states of round 0")
    p.add_argument("--iterations", type=int, default=300, help="of each of their searches")
    p.add_argument("--guided-rows", type=int, default=500, help="states of every later round")
    p.add_argument("--guided-iterations", type=int, default=100, help="of each of their searches, which a network guides")
    p.add_argument("--minutes", type=float, default=3, help="of training in a round")
    p.add_argument("--steps", type=int, help="of training in a round, instead of minutes")
    p.add_argument("--from", dest="warm", type=Path, help="checkpoint whose weights round 0 starts from (ppn_motion)")
    p.add_argument("--problems", type=int, default=24, help="held out; half of them need at least two pushes")
    p.add_argument("--trials", type=int, default=2, help="of each of them")
    p.add_argument("--budgets", default="50,20,10,5", help="iterations of a decision, the greatest first")
    p.add_argument("--judge", default="rapier", help="engine in which the held-out problems are executed")
    p.add_argument("--seed", type=int, default=100)
    p.add_argument("--threads", type=int, default=1)
    return p.parse_args()


# What results depend on; a folder that was begun with others is refused.
SETTINGS = ("rows", "iterations", "guided_rows", "guided_iterations", "minutes", "steps", "problems", "trials", "budgets",
            "judge", "seed")


class Loop:
    def __init__(self, args):
        self.args, self.out = args, args.output.resolve()
        self.budgets = sorted({int(b) for b in args.budgets.split(",")}, reverse=True)
        found = shutil.which(args.jostle)
        if found is None:
            sys.exit(f"more_loop: there is no {args.jostle}; build it with `make build` and name it with --jostle")
        self.jostle = str(Path(found).resolve())
        self.out.mkdir(parents=True, exist_ok=True)
        self.settings = {name: getattr(args, name) for name in SETTINGS}
        self.settings["from"] = sha256(args.warm) if args.warm else None
        begun = self.out / "settings.json"
        if begun.exists() and (other := json.loads(begun.read_text())) != self.settings:
            names = [k for k in self.settings if self.settings[k] != other.get(k)]
            sys.exit(f"more_loop: {self.out} was begun with other settings ({', '.join(names)}); name another folder")
        write(begun, json.dumps(self.settings, indent=1) + "\n")

    def say(self, text):
        print(f"[{time.strftime('%H:%M:%S')}] {text}", flush=True)

    def tool(self, *parts):
        run([self.jostle, *parts])

    def python(self, module, *parts):
        run([sys.executable, "-m", f"jostle_training.{module}", *parts], cwd=HERE)

    def timed(self, folder, name, product, text, work):
        """Does what makes `product`, unless it is there, and notes how many seconds of a processor it took."""
        times = folder / "cpu-seconds.json"
        known = json.loads(times.read_text()) if times.exists() else {}
        if product.exists() and name in known:
            return known[name]
        self.say(text)
        start = os.times()
        work()
        end = os.times()
        known[name] = round(end.children_user + end.children_system - start.children_user - start.children_system, 1)
        write(times, json.dumps(known))
        return known[name]

    def held_out(self):
        """Problems for judging: half need a push, half at least two."""
        folder = self.out / "held-out"
        done = self.out / "held-out.done"
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)
            half = self.args.problems // 2
            for count, pushes in ((self.args.problems - half, 1), (half, 2)):
                if count:
                    self.say(f"held out: {count} problems that need {pushes} push{'es' if pushes > 1 else ''} or more")
                    part = folder / f"pushes-{pushes}"
                    self.tool("generate", part, "-n", count, "--pushes", pushes, "--seed", HELD_OUT_SEED + pushes)
                    for file in sorted(part.glob("*.json")):
                        file.rename(folder / f"{pushes}-{file.name}")
                    part.rmdir()
            done.touch()
        return folder

    def data(self, number, folder, prior):
        rows, iterations, guide = self.args.rows, self.args.iterations, ()
        if prior:
            rows, iterations, guide = self.args.guided_rows, self.args.guided_iterations, ("--prior", prior)
        self.tool("datagen", "ppn", folder / "data", "-n", rows, "--shard", min(rows, 500), "--seed", self.args.seed + number,
                  "--iterations", iterations, "--threads", self.args.threads, *guide)
        write(folder / "data-done", "")

    def train(self, number, folder):
        """Goes on from the round before, on the data of all rounds so far."""
        gathered = gather([self.out / f"round-{k}" / "data" for k in range(number + 1)], folder / "gathered")
        checkpoint = folder / "training.pt"
        checkpoint.unlink(missing_ok=True)
        start = ()
        if number:
            shutil.copyfile(self.out / f"round-{number - 1}" / "ppn.pt", checkpoint)
        elif self.args.warm:
            start = ("--from", self.args.warm.resolve())
        long = ("--steps", self.args.steps) if self.args.steps else ("--minutes", self.args.minutes)
        self.python("train", "configs/ppn.toml", "--data", gathered, "--checkpoint", checkpoint, *long,
                    "--threads", self.args.threads, "--log", folder / "training.log", *start)
        # Labels of plain searches, in scenes of the test split, are the same measure for every round.
        self.python("eval", checkpoint, "--data", self.out / "round-0" / "data", "--samples", 1000, "-o", folder / "ppn.json")
        self.python("export", checkpoint, "-o", folder / "ppn.part.onnx", "--metrics", folder / "ppn.json")
        os.replace(checkpoint, folder / "ppn.pt")
        os.replace(folder / "ppn.part.onnx", folder / "ppn.onnx")

    def judged(self, file, planner, iterations, network=None):
        """The held-out problems in closed loop."""
        if not file.exists():
            options = ["--iterations", iterations] if iterations else []
            if network:
                options += ["--prior", f"ppn:{network}"]
            part = file.with_suffix(".part")
            self.tool("run", self.out / "held-out", "--planner", planner, *options, "--judge", self.args.judge, "--trials",
                      self.args.trials, "--seed", self.args.seed, "--threads", self.args.threads, "--json", part)
            os.replace(part, file)
        return summary(json.loads(file.read_text()))

    def reference(self):
        folder = self.out / "mcts"
        folder.mkdir(exist_ok=True)
        found = {}
        for budget in self.budgets:
            file = folder / f"mcts-{budget}.json"
            if not file.exists():
                self.say(f"held out: mcts, {budget} iterations")
            found[budget] = self.judged(file, "mcts", budget)
        return found

    def round(self, number):
        folder = self.out / f"round-{number}"
        folder.mkdir(exist_ok=True)
        prior = self.out / f"round-{number - 1}" / "ppn.onnx" if number else None
        by = f"guided by round {number - 1}'s network" if number else "searches of mcts"
        took = {}
        took["data"] = self.timed(folder, "data", folder / "data-done", f"round {number}: data, {by}",
                                  lambda: self.data(number, folder, prior))
        took["training"] = self.timed(folder, "training", folder / "ppn.onnx", f"round {number}: training",
                                      lambda: self.train(number, folder))
        network = folder / "ppn.onnx"
        more = {}
        for budget in self.budgets:
            file = folder / f"more-{budget}.json"
            if not file.exists():
                self.say(f"round {number}: held out, more with {budget} iterations")
            more[budget] = self.judged(file, "more", budget, network)
        ppn = self.judged(folder / "ppn-alone.json", "ppn", None, network)
        manifest = json.loads((folder / "data" / "manifest.json").read_text())
        figures = json.loads((folder / "ppn.json").read_text())["metrics"]
        return dict(round=number, cpu_seconds=took, data=dict(rows=sum(s["count"] for s in manifest["shards"]),
                    searches=searches(manifest)), network=dict(sha256=sha256(network), **figures), more=more, ppn=ppn)

    def run(self):
        self.held_out()
        report = dict(settings=self.settings, mcts=self.reference(), rounds=[])
        for number in range(self.args.rounds):
            report["rounds"].append(self.round(number))
            write(self.out / "report.json", json.dumps(report, indent=1) + "\n")
            text = markdown(report)
            write(self.out / "report.md", text)
            write(self.out / "report.svg", picture(report))
            self.say(f"after round {number}:\n{text}")
        return report


def run(parts, **options):
    parts = [str(part) for part in parts]
    done = subprocess.run(parts, capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"more_loop: {' '.join(parts)} failed:\n{done.stderr[-3000:]}")


def write(path, text):
    part = path.with_name(path.name + ".part")
    part.write_text(text)
    os.replace(part, path)


def sha256(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def gather(folders, into):
    """One folder with the shards of several; its manifest lists them, and what they were made as."""
    shutil.rmtree(into, ignore_errors=True)
    into.mkdir(parents=True)
    manifests = [json.loads((folder / "manifest.json").read_text()) for folder in folders]
    shapes = {m["shapes"]["sha256"] for m in manifests}
    if len(shapes) != 1:
        raise ValueError(f"{folders} were made with different shapes")
    shutil.copyfile(folders[0] / "shapes.safetensors", into / "shapes.safetensors")
    shards = []
    for k, (folder, manifest) in enumerate(zip(folders, manifests)):
        for shard in manifest["shards"]:
            name = f"round-{k}-{shard['file']}"
            shutil.copyfile(folder / shard["file"], into / name)
            shards.append(dict(shard, file=name))
    merged = dict(manifests[0], count=sum(s["count"] for s in shards), shards=shards, statistics={},
                  sources=[dict(seed=m["seed"], configuration=m["configuration"]) for m in manifests])
    write(into / "manifest.json", json.dumps(merged, indent=1) + "\n")
    return into


def searches(manifest):
    s = manifest["statistics"]
    return dict(iterations=s["iterations"] / max(1, s["searches"]), simulations=s["simulations"] / max(1, s["searches"]),
                solved=s["rows_solved"] / max(1, s["rows"]), best_q=s["best_q"] / max(1, s["rows"]))


def mean(values):
    return sum(values) / len(values) if values else 0.0


def summary(report):
    """The figures of a run: quality, and what its searches took. A decision that finds a grasp at once is no search."""
    trials = [t for case in report["cases"] for t in case["trials"]]
    decisions = [d for t in trials for d in t["decisions"]]
    searched = [d for d in decisions if d["simulations"] > 0]
    actions = [t["actions"] for t in trials]
    spread = math.sqrt(mean([(a - mean(actions)) ** 2 for a in actions]) / max(1, len(actions) - 1))
    return dict(
        trials=len(trials), completion=mean([t["end"] == "grasped" for t in trials]), actions=mean(actions),
        actions_error=spread, searches=len(searched), simulations=mean([d["simulations"] for d in searched]),
        simulations_a_case=sum(d["simulations"] for d in searched) / max(1, len(trials)),
        decision_ms=mean([d["milliseconds"] for d in searched]))


def least_equal(wanted, offered):
    """The least budget whose results are as good as `wanted`: not fewer completed, and not more actions. None if there is
    none."""
    good = [b for b, s in offered.items() if s["completion"] >= wanted["completion"] and s["actions"] <= wanted["actions"]]
    return min(good, default=None)


def markdown(report):
    """One row for every planner, budget and round."""
    head = ["", "iterations", "completed", "actions", "pushes simulated a decision", "a case", "ms a decision"]
    rows = [head, ["---"] * len(head)]

    def row(name, budget, s):
        rows.append([name, str(budget), f"{s['completion'] * 100:.0f} %", f"{s['actions']:.2f} ± {s['actions_error']:.2f}",
                     f"{s['simulations']:.1f}", f"{s['simulations_a_case']:.1f}", f"{s['decision_ms']:.1f}"])

    for budget, s in report["mcts"].items():
        row("`mcts`", budget, s)
    for found in report["rounds"]:
        for budget, s in found["more"].items():
            row(f"`more`, round {found['round']}", budget, s)
        row(f"`ppn`, round {found['round']}", "", found["ppn"])
    lines = ["| " + " | ".join(r) + " |" for r in rows]
    most = max(report["mcts"])
    wanted = report["mcts"][most]
    lines += ["", f"`mcts` with {most} iterations takes {wanted['actions']:.2f} actions and simulates "
              f"{wanted['simulations_a_case']:.1f} pushes a case. As good or better with the least effort:", ""]
    for found in report["rounds"]:
        budget = least_equal(wanted, found["more"])
        data, network = found["data"], found["network"]
        says = "no budget" if budget is None else (
            f"`more` with {budget} iterations, {found['more'][budget]['actions']:.2f} actions, "
            f"{found['more'][budget]['simulations_a_case']:.1f} pushes a case")
        lines.append(
            f"- round {found['round']}: {says}. Learned from {data['rows']} more states, {data['searches']['simulations']:.0f} "
            f"simulated pushes each ({found['cpu_seconds']['data']:.0f} s of a processor), in {found['cpu_seconds']['training']:.0f} s; its first push "
            f"is among the three best of a search in {network['top1_in_best3'] * 100:.0f} % of {network['states']} states.")
    return "\n".join(lines) + "\n"


def picture(report):
    line = lambda found: [(max(s["simulations_a_case"], 0.1), s["actions"], str(b)) for b, s in sorted(found.items())]
    series = [("mcts", line(report["mcts"]))]
    for found in report["rounds"]:
        series.append((f"more, round {found['round']}", line(found["more"])))
    for found in report["rounds"]:
        series.append((f"ppn, round {found['round']}", line({"ppn": found["ppn"]})))
    return chart("Effort and quality on held-out problems; numbers are iterations a decision",
                 "pushes simulated a case", "actions a case", series)


def main():
    args = parameters()
    if "ORT_DYLIB_PATH" not in os.environ:
        # The runtime that export was checked with runs the network in the tool as well.
        import onnxruntime

        found = sorted((Path(onnxruntime.__file__).parent / "capi").glob("libonnxruntime.so*"))
        if found:
            os.environ["ORT_DYLIB_PATH"] = str(found[0])
    Loop(args).run()


if __name__ == "__main__":
    main()
