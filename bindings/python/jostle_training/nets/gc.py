"""GC: can the target be grasped now (kind `gc`, interface 1)."""

import torch
from torch import nn

INPUTS = ("image",)
OUTPUTS = ("probability",)

HEIGHT = 20.0  # metres times this: 5 cm becomes 1


def layer(a, b, kernel=3, stride=1, dilation=1):
    pad = dilation * (kernel // 2)
    return nn.Sequential(nn.Conv2d(a, b, kernel, stride, pad, dilation, bias=False), nn.BatchNorm2d(b), nn.ReLU())


def prepared(image):
    """Height and target, and the height of what is not the target: the obstacles to the fingers."""
    height = image[:, :1] * HEIGHT
    target = image[:, 1:]
    return torch.cat([height, target, height * (1 - target)], 1)


class Gc(nn.Module):
    """A plain network of convolutions. A coarse map (8 mm cells, 16 angles) is an output in training only, where it is
    taught from the grasp map; the probability is read from the best places. Where a place lies in the image matters,
    because the grasp test looks for grasps near the target's centre only."""

    CELLS = 28

    def __init__(self, width=16, middle=24):
        super().__init__()
        w, m = width, middle
        self.stem = nn.Sequential(layer(3, w, 5, 2), layer(w, m, 3, 2))
        at = (torch.arange(self.CELLS) + 0.5) / (self.CELLS / 2) - 1
        x, y = at.expand(self.CELLS, -1), at[:, None].expand(-1, self.CELLS)
        self.register_buffer("at", torch.stack([x, y, x.abs(), y.abs(), x * x + y * y])[None], persistent=False)
        self.place = nn.Conv2d(5, m, 1)
        self.trunk = nn.Sequential(layer(m, m), layer(m, m, 3, 1, 2), layer(m, m), layer(m, m, 3, 1, 2))
        self.map = nn.Conv2d(m, 16, 1)
        self.score = nn.Sequential(nn.Linear(m + 16, 32), nn.ReLU(), nn.Linear(32, 1))

    def logits(self, image):
        x = self.trunk(self.stem(prepared(image)) + self.place(self.at))
        coarse = self.map(x)
        best = torch.cat([x.amax((2, 3)), coarse.amax((2, 3))], 1)
        return self.score(best).squeeze(-1), coarse

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
