"""Each network takes ten steps on invented data, is written as ONNX, read back, and gives what torch gives."""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import onnx
import torch

import synthetic
from jostle_training import export, nets, selftest
from jostle_training.data import ANGLES, Pushes, mirrored, symmetric
from jostle_training.eval import Exported
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
        got = export.run(str(model), selftest.inputs(shapes, test["seed"]))
        for output, expected in test["expected"].items():
            np.testing.assert_allclose(got[output].reshape(-1)[:8], expected, atol=test["atol"])
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

    def test_segmentation_takes_steps_and_exports(self):
        net = nets.build("segmentation", width=8)
        optimiser = torch.optim.AdamW(net.parameters())
        image = torch.zeros(2, 1, 224, 224)
        image[:, :, 80:120, 90:130] = 0.045
        for _ in range(10):
            foreground, centre, offset = net(image)
            loss = (foreground - (image[:, 0] > 0).float()).square().mean() + centre.mean() + offset.square().mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        checkpoint = dict(config=dict(kind="segmentation", net=dict(width=8)), net=net.state_dict())
        self.assertLess(export.write(checkpoint, self.folder / "net.onnx"), 1e-4)


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
