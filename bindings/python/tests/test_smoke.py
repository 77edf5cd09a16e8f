"""Each network takes ten steps on invented data, is written as ONNX, read back, and gives what torch gives."""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

try:
    import numpy as np
    import onnx
    import onnxruntime
    import safetensors
    import shapely
    import torch
except ImportError as missing:
    raise unittest.SkipTest(f"{missing}; bindings/python/README.md says what training needs") from None

import synthetic
from jostle_training import export, nets, selftest, tasks
from jostle_training.data import ANGLES, Pushes, mirrored, symmetric
from jostle_training.eval import Exported
from jostle_training.nets.jaw import Window
from jostle_training.shapes import iou

CONFIGS = HERE.parent / "configs"


def command(*parts):
    done = subprocess.run([sys.executable, "-m", *map(str, parts)], cwd=HERE.parent, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, parts))}:\n{done.stderr[-3000:]}")
    return done.stdout


class Smoke(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def through(self, name, kind):
        data = self.folder / "data"
        data.mkdir()
        synthetic.MAKE[kind](data)
        checkpoint, model, metrics = (self.folder / f for f in ("net.pt", "net.onnx", "metrics.json"))
        train = ("jostle_training.train", CONFIGS / f"{name}.toml", "--data", data, "--checkpoint", checkpoint)
        command(*train, "--steps", 7)
        command(*train, "--steps", 3)
        self.assertEqual(torch.load(checkpoint, weights_only=True)["done"]["step"], 10, "training goes on where it ended")
        command("jostle_training.eval", checkpoint, "--data", data, "--samples", 20, "-o", metrics)
        command("jostle_training.export", checkpoint, "-o", model, "--metrics", metrics)

        net = Exported(model)
        self.assertEqual(net.properties["kind"], kind)
        test = json.loads(net.properties["selftest"])
        shapes = {k: v for k, v in export.input_shapes(kind, test["batch"], test["num_objects"]).items() if k in net.asked}
        got = export.run(str(model), selftest.inputs(shapes, test["seed"], test["inputs"] == "scene"))
        for output, expected in test["expected"].items():
            np.testing.assert_allclose(got[output].reshape(-1)[test["at"][output]], expected, atol=test["atol"])
            self.assertEqual(len(set(expected)), len(expected), "values that differ")
        self.assertEqual(net.properties["train_commit"], torch.load(checkpoint, weights_only=True)["commit"])
        self.assertNotIn(str(HERE.parent.parent.parent), onnx.load(model).SerializeToString().decode("latin1"))

    def test_dipn_with_a_guess_learns_and_exports(self):
        self.through("dipn", "dipn")

    def test_dipn_without_a_guess_learns_and_exports(self):
        self.through("dipn_pure", "dipn")

    def test_ppn_learns_and_exports(self):
        self.through("ppn", "ppn")

    def test_gc_learns_and_exports(self):
        self.through("gc", "gc")

    def test_gn_learns_and_exports(self):
        self.through("gn", "gn")

    def test_segmentation_learns_and_exports(self):
        self.through("segmentation", "segmentation")


class Source(unittest.TestCase):
    """A network says which state of the source it was trained with."""

    def test_a_file_that_differs_from_its_commit_is_said(self):
        repository = Path(self.enterContext(tempfile.TemporaryDirectory()))
        package = repository / "python" / "jostle_training"
        package.mkdir(parents=True)
        shutil.copy(HERE.parent / "jostle_training" / "source.py", package)
        git = lambda *a: subprocess.run(["git", "-C", repository, "-c", "user.name=a", "-c", "user.email=a", *a],
                                        check=True, capture_output=True, text=True).stdout.strip()
        found = lambda: subprocess.run([sys.executable, "-c", "import source; print(source.commit_of_source())"],
                                       cwd=package, capture_output=True, text=True, check=True,
                                       env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}).stdout.strip()
        git("init", "-q")
        self.assertEqual(found(), "", "not in the repository")
        git("add", ".")
        git("commit", "-qm", "first")
        commit = git("rev-parse", "HEAD")
        self.assertEqual(found(), commit)
        (repository / "elsewhere").write_text("is no part of the training")
        self.assertEqual(found(), commit)
        # A configuration is.
        (repository / "python" / "new.toml").write_text("")
        self.assertEqual(found(), commit + "-dirty")


class SelfTest(unittest.TestCase):
    def test_positions_are_of_values_that_differ(self):
        values = np.zeros(1000, np.float32)
        values[[700, 20, 301]] = 0.5, 0.2, 0.2001
        self.assertEqual(selftest.telling(values), [0, 20, 700])
        many = selftest.telling(np.linspace(0, 1, 1000))
        self.assertEqual((len(many), many[0], many[-1]), (8, 0, 999))

    def test_a_picture_has_its_target_in_the_middle(self):
        image = selftest.inputs({"image": [2, 2, 112, 112]}, 42, scene=True)["image"]
        self.assertTrue((image[:, 1, 46:69, 46:69] == 1).all())
        self.assertEqual(int(image[:, 1].sum()), 2 * 23 * 23)
        self.assertEqual(set(np.unique(image[:, 0])), {np.float32(0), np.float32(0.045)})
        # 0.568, 0.225 and 0.413 are the first numbers, and the second alone is small.
        self.assertEqual(image[0, 0, 0, [0, 22, 23, 45, 46]].tolist(), np.float32([0, 0, 0.045, 0.045, 0]).tolist())


class Networks(unittest.TestCase):
    def batch(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        synthetic.pushes(folder, 60)
        data = Pushes(folder)
        return data.batch(torch.arange(20))

    def random_net(self, kind, **options):
        torch.manual_seed(5)
        net = nets.build(kind, **options).eval()
        for p in net.parameters():
            torch.nn.init.normal_(p, std=0.1)
        return net

    def test_padding_changes_nothing(self):
        batch = self.batch()
        for guess in ("planar", "none"):
            net = self.random_net("dipn", width=16, guess=guess)
            names = nets.module("dipn").INPUTS
            grow = lambda v: torch.cat([v, torch.zeros_like(v[:, :2])], 1)
            with torch.no_grad():
                motion = net(*(batch[k] for k in names))
                wider = net(*(batch[k] if k == "push" else grow(batch[k]) for k in names))
            self.assertLess(float((motion - wider[:, : motion.shape[1]]).abs().max()), 1e-5)
            self.assertEqual(float(wider[:, motion.shape[1] :].abs().max()), 0.0)

    def test_a_mirror_twice_is_no_mirror(self):
        batch = self.batch()
        sign = -torch.ones(len(batch["push"]))
        again = mirrored(mirrored(batch, sign), sign)
        for name in ("outline", "centre", "motion", "guess"):
            self.assertTrue(torch.equal(batch[name], again[name]), name)

    def test_outlines_stay_counter_clockwise_in_the_mirror(self):
        batch = self.batch()
        seen = mirrored(batch, -torch.ones(len(batch["push"])))
        for b in (batch, seen):
            x, y = b["outline"][..., 0], b["outline"][..., 1]
            area = (x * y.roll(-1, -1) - x.roll(-1, -1) * y).sum(-1)
            self.assertTrue(bool((area[b["present"] > 0] > 0).all()))

    def test_a_grasp_turns_with_its_image(self):
        # A bar of pixels along an angle, and the map that marks that angle, must stay together.
        at = (torch.arange(112) + 0.5 - 56) * 0.002
        y, x = torch.meshgrid(at, at, indexing="ij")
        k = 3
        angle = torch.tensor(k * torch.pi / ANGLES)
        bar = ((x * angle.sin() - y * angle.cos()).abs() < 0.004).float()
        quality = torch.zeros(1, ANGLES, 56, 56)
        quality[:, k] = 1
        for which in range(8):
            image, moved = symmetric(bar[None, None], quality, which)
            marked = int(moved[0, :, 0, 0].argmax())
            a = torch.tensor(marked * torch.pi / ANGLES)
            expected = ((x * a.sin() - y * a.cos()).abs() < 0.004).float()
            self.assertTrue(torch.equal(image[0, 0], expected), f"symmetry {which}")

    def test_a_window_shows_the_same_at_every_angle(self):
        # A bar across the jaw, turned with it: what the taps show is what they show at angle 0, give or take rounding.
        window = Window(cell=4, step=1, spacing=4, half=4, obstacles=(60, 16), target=(48, 24))
        at = (torch.arange(112) + 0.5 - 56) * 2
        y, x = torch.meshgrid(at, at, indexing="ij")
        seen = []
        for k in range(ANGLES):
            c, s = math.cos(math.pi * k / ANGLES), math.sin(math.pi * k / ANGLES)
            # The cell that is looked at has its middle 2 mm off the image's.
            u, v = c * (x - 2) + s * (y - 2), c * (y - 2) - s * (x - 2)
            bar = ((u.abs() < 15) & (v.abs() < 40)).float()
            finger = ((u - 48).abs() < 8).float() * (v.abs() < 12)
            obstacles, target = window(torch.stack([bar * 0.05 + finger * 0.05, bar])[None])
            # Cell (4, 4) of 8 by 8 has its middle at (2, 2) mm.
            seen.append(torch.cat([obstacles[0, k, :, 36], target[0, k, :, 36]]))
        for k in range(ANGLES):
            self.assertLess(float((seen[k] - seen[0]).abs().mean()), 0.03, f"angle {k}")
        self.assertGreater(float(seen[0].std()), 0.3)

    def test_single_places_show_what_the_whole_window_shows(self):
        window = Window(cell=8, step=2, spacing=6, half=5, obstacles=(60, 15), target=(48, 24))
        random = torch.Generator().manual_seed(3)
        image = torch.stack([torch.rand(2, 112, 112, generator=random) * 0.05,
                             (torch.rand(2, 112, 112, generator=random) < 0.3).float()], 1)
        whole = window(image)
        which, angle = torch.tensor([0, 1, 1]), torch.tensor([0, 5, 15])
        row, col = torch.tensor([0, 4, 9]), torch.tensor([9, 2, 0])
        first = window.rows // 2 - window.half
        single = window.places(window.planes(image), which, angle, row + first, col + first)
        for w, s in zip(whole, single):
            self.assertTrue(torch.equal(w[which, angle, :, row * 10 + col], s))

    def test_mirrored_taps_are_the_taps_of_the_mirrored_image(self):
        task = tasks.GnTask.__new__(tasks.GnTask)
        task.net = types.SimpleNamespace(window=Window(cell=4, step=1, spacing=4, half=2, obstacles=(60, 16), target=(48, 24)))
        image = (torch.rand(1, 2, 112, 112, generator=torch.Generator().manual_seed(3)) < 0.3).float()
        # At angle 0, at the cell before the middle and its mirror images.
        shown = []
        for flips, row, col in (((), 1, 1), ((-1,), 1, 2), ((-2,), 2, 1), ((-1, -2), 2, 2)):
            taps = task.net.window(image.flip(flips))
            shown.append(torch.cat([t[0, 0, :, row * 4 + col] for t in taps]))
        self.assertLess(float((task.mirrored(torch.stack(shown[:1] * 4)) - torch.stack(shown)).abs().max()), 1e-6)

    def test_gc_sees_a_grasp_at_the_place_that_its_cell_belongs_to(self):
        # A square of pixels about a cell of the grasp map shows where that cell's place looks, whatever the angle.
        net = nets.build("gc")
        for angle in range(ANGLES):
            for row, col in ((24, 30), (31, 22), (28, 28)):
                image = torch.zeros(1, 2, 112, 112)
                image[0, 1, 2 * row : 2 * row + 2, 2 * col : 2 * col + 2] = 1
                seen = net.turned(image)[1].reshape(net.turned.rows, ANGLES, net.turned.cols)[:, angle]
                v, u = ((torch.arange(n) - (n - 1) / 2) * net.turned.SPACING for n in (net.turned.rows, net.turned.cols))
                v, u = float((seen.sum(1) * v).sum() / seen.sum()), float((seen.sum(0) * u).sum() / seen.sum())
                place = int(net.place_of(*map(torch.tensor, (angle, row, col))))
                along, across = place // (ANGLES * net.COLS), place % net.COLS
                self.assertEqual(place // net.COLS % ANGLES, angle)
                self.assertLess(abs(v - (along - (net.ROWS - 1) / 2) * net.STEP[0]), net.STEP[0] / 2 + 1, f"angle {angle}")
                self.assertLess(abs(u - (across - (net.COLS - 1) / 2) * net.STEP[1]), net.STEP[1] / 2 + 1, f"angle {angle}")

    def test_gc_answers_in_training_as_in_use(self):
        net = nets.build("gc")
        image = torch.rand(2, 2, 112, 112, generator=torch.Generator().manual_seed(3))
        with torch.no_grad():
            self.assertTrue(torch.allclose(net.train().features(image), net.eval().features(image), atol=1e-5))

    def test_iou_of_a_body_with_itself_is_one(self):
        outline = np.stack([synthetic.outline(0.04, 0.02)] * 2)
        truth = np.array([[0.01, 0.0, 0.3], [0.01, 0.0, 0.3]])
        motion = np.array([[0.01, 0.0, 0.3], [0.5, 0.0, 0.3]])
        np.testing.assert_allclose(iou(outline, np.zeros((2, 2)), motion, truth), [1, 0], atol=1e-9)

    def test_reference_networks_have_the_sizes_of_the_dissertation(self):
        millions = {k: sum(p.numel() for p in nets.build(k, "reference").parameters()) / 1e6
                    for k in ("dipn", "ppn", "gc", "gn")}
        for kind, least, most in (("dipn", 9, 12), ("ppn", 20, 26), ("gc", 3.5, 5.5), ("gn", 11, 15)):
            self.assertTrue(least < millions[kind] < most, f"{kind}: {millions[kind]:.1f} million weights")


if __name__ == "__main__":
    unittest.main()
