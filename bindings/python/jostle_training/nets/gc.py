"""GC: can the target be grasped now (kind `gc`, interface 1)."""

import torch
from torch import nn

from .jaw import Judge, Window

INPUTS = ("image",)
OUTPUTS = ("probability",)

HEIGHT = 20.0  # metres times this: 5 cm becomes 1


def layer(a, b, kernel=3, stride=1, dilation=1):
    pad = dilation * (kernel // 2)
    return nn.Sequential(nn.Conv2d(a, b, kernel, stride, pad, dilation, bias=False), nn.BatchNorm2d(b), nn.ReLU())


class Gc(nn.Module):
    """Looks at the image as GN does (`jaw.py`), but coarsely: cells of 8 mm within 4 cm of the target's middle. The most
    that any place and angle says, feature by feature, is the answer. Whether a cell has a grasp is an output in training
    only."""

    HALF = 5

    def __init__(self, obstacles=16, target=24, both=(24,), features=8):
        super().__init__()
        target_taps = (48, 24, (30.0, 42.0))
        self.window = Window(cell=8, step=2, spacing=6, half=self.HALF, obstacles=(60, 15), target=target_taps)
        self.judge = Judge(self.window.sizes, obstacles, target, both, features)
        self.score = nn.Sequential(nn.Linear(features, 16), nn.ReLU(), nn.Linear(16, 1))

    def logits(self, image):
        """Of the image, and of each angle and cell: [B], [B,16,10,10]."""
        found = self.judge.columns(*self.window(image))
        return self.score(found.amax((1, 3))).squeeze(-1), found[:, :, 0].unflatten(-1, (2 * self.HALF, 2 * self.HALF))

    def forward(self, image):
        return torch.sigmoid(self.logits(image)[0])


class Squeeze(nn.Module):
    def __init__(self, channels, inner):
        super().__init__()
        self.down, self.up = nn.Conv2d(channels, inner, 1), nn.Conv2d(inner, channels, 1)

    def forward(self, x):
        s = self.down(x.mean((2, 3), keepdim=True))
        return x * torch.sigmoid(self.up(s * torch.sigmoid(s)))


class Inverted(nn.Module):
    """The inverted bottleneck of EfficientNet."""

    def __init__(self, a, b, expand, kernel, stride):
        super().__init__()
        w = a * expand
        self.skip = stride == 1 and a == b
        grown = [nn.Conv2d(a, w, 1, bias=False), nn.BatchNorm2d(w), nn.SiLU()] if expand > 1 else []
        self.body = nn.Sequential(
            *grown, nn.Conv2d(w, w, kernel, stride, kernel // 2, groups=w, bias=False), nn.BatchNorm2d(w), nn.SiLU(),
            Squeeze(w, max(1, a // 4)), nn.Conv2d(w, b, 1, bias=False), nn.BatchNorm2d(b))

    def forward(self, x):
        return x + self.body(x) if self.skip else self.body(x)


class ReferenceGc(nn.Module):
    """EfficientNet-b0, as in the dissertation (there with one channel; the target's mask is added here)."""

    STAGES = ((1, 16, 1, 3, 1), (6, 24, 2, 3, 2), (6, 40, 2, 5, 2), (6, 80, 3, 3, 2), (6, 112, 3, 5, 1),
              (6, 192, 4, 5, 2), (6, 320, 1, 3, 1))

    def __init__(self):
        super().__init__()
        layers, a = [nn.Conv2d(2, 32, 3, 2, 1, bias=False), nn.BatchNorm2d(32), nn.SiLU()], 32
        for expand, b, count, kernel, stride in self.STAGES:
            for k in range(count):
                layers.append(Inverted(a, b, expand, kernel, 1 if k else stride))
                a = b
        layers += [nn.Conv2d(a, 1280, 1, bias=False), nn.BatchNorm2d(1280), nn.SiLU()]
        self.trunk, self.out = nn.Sequential(*layers), nn.Linear(1280, 1)

    def logits(self, image):
        x = torch.cat([image[:, :1] * HEIGHT, image[:, 1:]], 1)
        return self.out(self.trunk(x).mean((2, 3))).squeeze(-1), None

    def forward(self, image):
        return torch.sigmoid(self.logits(image)[0])


def build(profile="fast", **options):
    return ReferenceGc(**options) if profile == "reference" else Gc(**options)
