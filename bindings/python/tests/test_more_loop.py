"""MORE's loop with a tool that invents data and results: what is kept, what is made anew, and what the report says."""

import json
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

try:
    import numpy
    import safetensors
    import torch
except ImportError as missing:
    raise unittest.SkipTest(f"{missing}; bindings/python/README.md says what training needs") from None

from jostle_training import more_loop
from jostle_training.plot import chart

# Speaks as `jostle` does, and writes down what it was asked.
TOOL = f"""#!{sys.executable}
import json, sys
from pathlib import Path
sys.path.insert(0, {str(HERE)!r})
import synthetic
args = sys.argv[1:]
value = lambda name: args[args.index(name) + 1]
with open(Path(__file__).with_suffix(".log"), "a") as log:
    log.write(" ".join(args) + "\\n")
if args[0] == "generate":
    folder = Path(args[1])
    folder.mkdir(parents=True)
    for k in range(int(value("-n"))):
        (folder / f"case-{{k}}.json").write_text("{{}}")
elif args[0] == "datagen":
    folder = Path(args[2])
    folder.mkdir(parents=True, exist_ok=True)
    synthetic.values(folder, 40, seed=int(value("--seed")))
    rows = dict(rows=40.0, searches=50.0, iterations=3000.0, simulations=6000.0, rows_solved=39.0, best_q=36.0)
    shard = dict(file="ppn-00000.safetensors", count=40, sha256="0", statistics=rows)
    (folder / "manifest.json").write_text(json.dumps(dict(
        kind="ppn", seed=int(value("--seed")), configuration=dict(prior="--prior" in args), shards=[shard], statistics=rows,
        shapes=dict(sha256="0"))))
elif args[0] == "run":
    guided = "--prior" in args
    simulations = 4 if guided else 2 * int(value("--iterations"))
    decision = dict(simulations=simulations, milliseconds=1.5)
    grasp = dict(simulations=0, milliseconds=0.1)
    trial = dict(end="grasped", actions=2, decisions=[decision, grasp])
    Path(value("--json")).write_text(json.dumps(dict(cases=[dict(trials=[trial, dict(trial, actions=3)])])))
else:
    sys.exit(2)
"""


def trial(actions, end="grasped", simulations=(6, 0)):
    return dict(end=end, actions=actions, decisions=[dict(simulations=s, milliseconds=2.0 * s) for s in simulations])


class Loop(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.tool = self.folder / "jostle"
        self.tool.write_text(TOOL)
        self.tool.chmod(0o755)

    def loop(self, *more):
        return subprocess.run(
            [sys.executable, "-m", "jostle_training.more_loop", str(self.folder / "out"), "--jostle", str(self.tool), "--steps",
             "4", "--problems", "4", "--budgets", "10,5", *more], cwd=HERE.parent, capture_output=True, text=True)

    def asked(self):
        log = self.tool.with_suffix(".log")
        lines = log.read_text().splitlines()
        log.unlink()
        return lines

    def test_rounds_follow_each_other_and_what_is_done_is_kept(self):
        done = self.loop("--rounds", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        first = self.asked()
        self.assertEqual(sum(line.startswith("datagen") for line in first), 1)
        self.assertFalse(any("--prior" in line for line in first if line.startswith("datagen")))
        # mcts and more at two budgets, and ppn alone.
        self.assertEqual(sum(line.startswith("run") for line in first), 5)

        done = self.loop("--rounds", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        second = self.asked()
        self.assertEqual([line.split()[0] for line in second], ["datagen", "run", "run", "run"])
        self.assertIn(f"--prior {(self.folder / 'out' / 'round-0' / 'ppn.onnx').resolve()}", second[0])
        out = self.folder / "out"
        report = json.loads((out / "report.json").read_text())
        self.assertEqual([r["round"] for r in report["rounds"]], [0, 1])
        gathered = json.loads((out / "round-1" / "gathered" / "manifest.json").read_text())
        self.assertEqual([s["file"] for s in gathered["shards"]],
                         ["round-0-ppn-00000.safetensors", "round-1-ppn-00000.safetensors"])
        steps = [torch.load(out / f"round-{k}" / "ppn.pt", weights_only=True)["done"]["step"] for k in (0, 1)]
        self.assertEqual(steps, [4, 8], "a round goes on from the one before")
        text = (out / "report.md").read_text()
        self.assertIn("| `mcts` | 10 | 100 % | 2.50", text)
        self.assertIn("- round 1: `more` with 5 iterations, 2.50 actions, 4.0 pushes a case.", text)
        xml.parse(out / "report.svg")

        self.assertEqual(self.loop("--rounds", "2").returncode, 0)
        self.assertFalse(self.tool.with_suffix(".log").exists(), "nothing is left to do")
        other = self.loop("--rounds", "2", "--trials", "5")
        self.assertNotEqual(other.returncode, 0)
        self.assertIn("other settings (trials)", other.stderr)


class Report(unittest.TestCase):
    def test_a_run_is_summed_up_by_its_trials_and_searches(self):
        s = more_loop.summary(dict(cases=[dict(trials=[trial(2), trial(4, "action_cap", (10, 20))])]))
        self.assertEqual((s["trials"], s["completion"], s["actions"], s["searches"]), (2, 0.5, 3, 3))
        self.assertEqual((s["simulations"], s["simulations_a_case"], s["decision_ms"]), (12, 18, 24))

    def test_the_least_budget_that_is_as_good_is_named(self):
        quality = lambda completion, actions: dict(completion=completion, actions=actions)
        wanted = quality(1.0, 2.5)
        offered = {50: quality(1.0, 2.4), 20: quality(1.0, 2.5), 10: quality(0.9, 2.1), 5: quality(1.0, 2.6)}
        self.assertEqual(more_loop.least_equal(wanted, offered), 20)
        self.assertIsNone(more_loop.least_equal(quality(1.0, 2.0), offered))

    def test_every_point_of_a_chart_lies_in_it(self):
        text = chart("a < b", "x", "y", [("one", [(0.5, 2.0, "5"), (700.0, 3.7, "50")]), ("two", [(3.0, 2.0, "")])])
        root = xml.fromstring(text)
        circles = [e for e in root.iter() if e.tag.endswith("circle")]
        self.assertEqual(len(circles), 3)
        for circle in circles:
            self.assertTrue(70 <= float(circle.get("cx")) <= 460 and 40 <= float(circle.get("cy")) <= 340)


if __name__ == "__main__":
    unittest.main()
