"""GN: how well a grasp does at each place and angle (kind `gn`, interface 1)."""

import math

import torch
from torch import nn
from torch.nn import functional

from .gc import HEIGHT, layer
from .jaw import ANGLES, Judge, Window
from .raster import ResNetPyramid

INPUTS = ("image",)
OUTPUTS = ("quality",)


class Gn(nn.Module):
    """One window at each cell of 4 mm within 4 cm of the target's middle and at each angle, judged by the same weights
    (`jaw.py`). A little of the neighbours' quality is mixed in: the best place is in the middle of good ones. Farther out
    the quality is 0."""

    CELLS, HALF = 56, 10
    MIXED = 0.2  # of a cell's quality, relative to the one in the middle
    # Directions that are judged together. The windows of all are more than a cache holds, and a runtime can end a call
    # between two nodes only, so these are to be short.
    AT_ONCE = 2

    def __init__(self, obstacles=32, target=64, both=(64, 32)):
        super().__init__()
        # The far rows show where the body ends.
        target_taps = (42, 21, (26.0, 34.0, 42.0))
        self.window = Window(cell=4, step=1, spacing=3, half=self.HALF, obstacles=(60, 15), target=target_taps)
        self.judge = Judge(self.window.sizes, obstacles, target, both, 1)
        nn.init.constant_(self.judge.out.bias, -2.0)
        mixed = torch.tensor([self.MIXED, 1.0, self.MIXED]) / (1 + 2 * self.MIXED)
        self.register_buffer("mixed", (mixed[:, None] * mixed)[None, None], persistent=False)

    def forward(self, image):
        side, edge = 2 * self.HALF, self.CELLS // 2 - self.HALF
        slid, parts = self.window.slid(image), range(0, ANGLES, self.AT_ONCE)
        judged = [self.judge.columns(*self.window.shows(slid, first, self.AT_ONCE)) for first in parts]
        quality = torch.cat([torch.sigmoid(part) for part in judged], 1)
        quality = functional.conv2d(quality.reshape(-1, 1, side, side), self.mixed, padding=1)
        return functional.pad(quality.reshape(-1, ANGLES, side, side), (edge, edge, edge, edge))


class ReferenceGn(nn.Module):
    """The dissertation's network: ResNet-18 with a feature pyramid, heads that end in two kernels of a gripper's shape,
    and one pass for each of 16 rotations of the image, turned back afterwards. A parallel gripper is the same after
    half a turn, so 16 angles over half a turn take 16 passes here."""

    def __init__(self):
        super().__init__()
        self.pyramid = ResNetPyramid(2, (2, 2, 2, 2))
        self.head = nn.Sequential(
            layer(256, 256), layer(256, 128, 1), nn.Upsample(scale_factor=2, mode="bilinear"), layer(128, 64),
            layer(64, 32, 1), nn.Conv2d(32, 1, (13, 63), padding=(6, 31)), nn.ReLU(),
            nn.Conv2d(1, 1, (13, 63), padding=(6, 31)), nn.ReLU(), nn.Conv2d(1, 1, 1))

    @staticmethod
    def turned(x, angle):
        c, s = math.cos(angle), math.sin(angle)
        matrix = torch.tensor([[c, -s, 0.0], [s, c, 0.0]], device=x.device).expand(x.shape[0], 2, 3)
        grid = nn.functional.affine_grid(matrix, list(x.shape), align_corners=False)
        return nn.functional.grid_sample(x, grid, align_corners=False)

    def logits(self, image):
        x = torch.cat([image[:, :1] * HEIGHT, image[:, 1:]], 1)
        maps = []
        for k in range(ANGLES):
            angle = math.pi * k / ANGLES
            maps.append(self.turned(self.head(self.pyramid(self.turned(x, angle))), -angle))
        return torch.cat(maps, 1)

    def forward(self, image):
        return torch.sigmoid(self.logits(image))


def build(profile="fast", **options):
    return ReferenceGn(**options) if profile == "reference" else Gn(**options)
