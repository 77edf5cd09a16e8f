"""GC: can the target be grasped now (kind `gc`, interface 1)."""

import math

import torch
from torch import nn
from torch.nn import functional

from .jaw import ANGLES, SIDE

INPUTS = ("image",)
OUTPUTS = ("probability",)

HEIGHT = 20.0  # metres times this: 5 cm becomes 1


def layer(a, b, kernel=3, stride=1, dilation=1):
    pad = dilation * (kernel // 2)
    return nn.Sequential(nn.Conv2d(a, b, kernel, stride, pad, dilation, bias=False), nn.BatchNorm2d(b), nn.ReLU())


class Turned(nn.Module):
    """The image as jaws of 16 directions see it: samples 3 mm apart along the closing direction (u) and along the pads
    (v), rounded to 1 mm. A sample is the image under a tent that falls to 0 within 3 mm."""

    SPACING = 3

    def __init__(self, rows, cols):
        super().__init__()
        self.rows, self.cols = rows, cols
        v, u = ((torch.arange(n) - (n - 1) / 2) * self.SPACING for n in (rows, cols))
        angle = torch.arange(ANGLES)[:, None] * math.pi / ANGLES
        v = v[:, None, None]
        # Millimetres from the image's first corner; pixels have their centres at the odd ones.
        x, y = ((SIDE + p).round().long() for p in (angle.cos() * u - angle.sin() * v, angle.sin() * u + angle.cos() * v))
        self.register_buffer("at", (((y % 2 * 2 + x % 2) * SIDE + y // 2) * SIDE + x // 2).flatten(), persistent=False)
        # Of the pixels before, at and after a place at an even and at an odd millimetre.
        tent = torch.tensor([[0.5, 0.5, 0.0], [0.2, 0.6, 0.2]])
        kernel = (tent[:, None, :, None] * tent[None, :, None, :]).reshape(4, 1, 3, 3)
        self.register_buffer("kernel", kernel.repeat(2, 1, 1, 1), persistent=False)

    def forward(self, image):
        """Everything and the target, [B,1,rows,16 cols] each."""
        there = torch.cat([(image[:, :1] * 100).clamp(max=1), image[:, 1:]], 1)
        planes = functional.conv2d(there, self.kernel, padding=1, groups=2).reshape(-1, 2, 4 * SIDE * SIDE)
        # Gather with an index for each element is many times faster than one that picks along an axis.
        seen = planes.gather(2, self.at.expand(planes.shape[0], 2, -1))
        seen = seen.reshape(-1, 2, self.rows, ANGLES * self.cols)
        return seen[:, :1], seen[:, 1:]


class Gc(nn.Module):
    """Looks at each of 13 x 16 places about the target's middle along 16 closing directions, through filters that are
    products of a profile along the pads and one across: fingers, pads and the room between them are upright rectangles
    to the jaw, which such products describe. What the filters find is judged by the same small network at all places
    and directions; the most that any of them says, feature by feature, is the answer. Whether a place has a grasp is an
    output in training only."""

    ROWS, COLS = 13, 16  # places along the pads, 6 mm apart, and across, 4 mm
    STEP = (6, 4)  # mm
    TAPS, STRIDE, REACH = 10, 2, 57  # samples along the pads; of them between places; mm across

    def __init__(self, obstacles=8, target=16, hidden=24, features=8):
        super().__init__()
        spacing = Turned.SPACING
        across = 2 * math.ceil(((self.COLS - 1) / 2 * self.STEP[1] + self.REACH) / spacing)
        self.turned = Turned((self.ROWS - 1) * self.STRIDE + self.TAPS, across)
        self.along = nn.ModuleList(
            nn.Conv2d(1, n, (self.TAPS, 1), (self.STRIDE, 1), bias=False) for n in (obstacles, target))
        # A profile has a knot every 3 mm; between knots it is a straight line.
        knots = 2 * math.ceil(self.REACH / spacing) + 1
        self.across = nn.ParameterList(nn.Parameter(torch.randn(n, knots) / 6) for n in (obstacles, target))
        sample = (torch.arange(across) - (across - 1) / 2) * spacing
        place = (torch.arange(self.COLS) - (self.COLS - 1) / 2) * self.STEP[1]
        knot = (torch.arange(knots) - knots // 2) * spacing
        off = (sample[None, :, None] - place[None, None, :] - knot[:, None, None]).abs()
        self.register_buffer("lines", (1 - off / spacing).clamp(min=0), persistent=False)  # [knots,across,COLS]
        # The convolution along the pads as one product of matrices: [TAPS,ROWS,rows].
        tap = torch.arange(self.turned.rows) - self.STRIDE * torch.arange(self.ROWS)[:, None]
        self.register_buffer("slide", (torch.arange(self.TAPS)[:, None, None] == tap).float(), persistent=False)
        self.first = nn.Parameter(torch.zeros(obstacles + target))
        self.second, self.third = nn.Linear(obstacles + target, hidden), nn.Linear(hidden, features)
        self.score = nn.Sequential(nn.Linear(features, 16), nn.ReLU(), nn.Linear(16, 1))
        self.profiles = None

    def freeze(self):
        """Works the profiles out for good."""
        self.profiles = [torch.einsum("nk,kac->nac", a, self.lines).detach() for a in self.across]

    def features(self, image):
        """[B,features,13*16*16], short of a constant: places along the pads, directions, places across."""
        # As batches, PyTorch copies less.
        each = lambda w, x: torch.bmm(w.expand(len(x), -1, -1), x) if self.training else w @ x
        found = []
        profiles = self.profiles or [torch.einsum("nk,kac->nac", a, self.lines) for a in self.across]
        for seen, along, profile in zip(self.turned(image), self.along, profiles):
            # PyTorch takes many times longer for a convolution of one channel than for the product.
            slide = lambda w: torch.einsum("nt,trv->nrv", w.flatten(1), self.slide).flatten(0, 1)
            x = each(slide(along.weight), seen.squeeze(1)) if self.training else along(seen)
            found.append(x.reshape(-1, along.out_channels, self.ROWS * ANGLES, self.turned.cols) @ profile)
        x = torch.cat(found, 1).reshape(-1, len(self.first), self.ROWS * ANGLES * self.COLS)
        add = lambda x, bias: x + bias[:, None].to(x.dtype)
        x = add(x, self.first).relu_()
        x = add(each(self.second.weight, x), self.second.bias).relu_()
        return each(self.third.weight, x)

    def logits(self, image):
        """Of the image, and of each place and direction: [B], [B,13*16*16]."""
        found = self.features(image)
        bias = self.third.bias
        return self.score(found.amax(2) + bias).squeeze(-1), found[:, 0] + bias[0]

    def forward(self, image):
        return torch.sigmoid(self.logits(image)[0])

    @classmethod
    def place_of(cls, angle, row, col, cell=4, cells=56):
        """Which of the 13*16*16 places the grasp map's cell belongs to; -1 where none."""
        a = angle * (math.pi / ANGLES)
        x, y = ((p + 0.5 - cells / 2) * cell for p in (col, row))
        v = ((a.cos() * y - a.sin() * x) / cls.STEP[0] + cls.ROWS / 2).floor().long()
        u = ((a.cos() * x + a.sin() * y) / cls.STEP[1] + cls.COLS / 2).floor().long()
        inside = (v >= 0) & (v < cls.ROWS) & (u >= 0) & (u < cls.COLS)
        return torch.where(inside, (v * ANGLES + angle) * cls.COLS + u, -1)


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
