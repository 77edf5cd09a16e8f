"""PPN: the value of each push (kind `ppn`, interface 1), seen in the push's own frame."""

import torch
from torch import nn

from .objects import SCALE, Bodies
from .raster import ResNetPyramid, masks, window

INPUTS = ("outline", "centre", "body", "push", "present", "target")
OUTPUTS = ("value",)


class Ppn(nn.Module):
    """Follows the bodies through the push as DIPN does, then looks at the room around the target."""

    def __init__(self, width=64, moments=(0.0, 0.5, 1.0), lanes=8, around=32):
        super().__init__()
        self.bodies = Bodies(width, moments, targets=True, lanes=lanes)
        self.around = nn.Linear(width + 32 + 3, around)
        self.value = nn.Sequential(nn.Linear(width + around, width), nn.ReLU(), nn.Linear(width, 1))

    def logit(self, outline, centre, body, push, present, target):
        motion, h, (_, hi, lo, apart, normal, _) = self.bodies(outline, centre, body, push, present, None, target)
        t = target.unsqueeze(-1)
        # Gaps from the target to every body along 32 directions: where a finger would have to go.
        target_hi = (hi * t).sum(1, keepdim=True)
        gap = (lo - target_hi).clamp(-0.1, 0.1) * SCALE
        separation = (apart * t.unsqueeze(2)).sum(1).clamp(-0.1, 0.1) * SCALE
        facing = (normal * t.unsqueeze(2)).sum(1)
        others = (present - target).unsqueeze(-1)
        around = torch.relu(self.around(torch.cat([h, gap, separation, facing], -1))) * others
        own = (h * t).sum(1)
        return self.value(torch.cat([own, around.sum(1)], -1)).squeeze(-1), motion

    def forward(self, outline, centre, body, push, present, target):
        return torch.sigmoid(self.logit(outline, centre, body, push, present, target)[0])

    def fit(self, body, push):
        given = torch.cat([body, push], -1)
        self.bodies.mean.copy_(given.mean(0))
        self.bodies.deviation.copy_(given.std(0).clamp(min=1e-3))


class ReferencePpn(nn.Module):
    """The dissertation's network: ResNet-34 with a feature pyramid over target mask and label image, turned so that the
    push points to the right, read at the pixel where the push starts. The image is drawn inside the graph."""

    SIZE, PIXEL = 224, 0.002

    def __init__(self):
        super().__init__()
        self.pyramid = ResNetPyramid(2, (3, 4, 6, 3))
        self.head = nn.Sequential(
            nn.Conv2d(256, 256, 3, padding=1, bias=False), nn.BatchNorm2d(256), nn.ReLU(),
            nn.Conv2d(256, 128, 3, padding=1, bias=False), nn.BatchNorm2d(128), nn.ReLU(),
            nn.Conv2d(128, 32, 1, bias=False), nn.BatchNorm2d(32), nn.ReLU(), nn.Conv2d(32, 1, 1))

    def logit(self, outline, centre, body, push, present, target):
        grid = window(self.SIZE, self.PIXEL, outline)
        drawn = masks(outline, centre, grid) * present[..., None, None]
        aim = (drawn * target[..., None, None]).amax(1)
        labels = drawn.amax(1) * 0.5 + aim * 0.5
        q = self.head(self.pyramid(torch.stack([aim, labels], 1)))
        middle = self.SIZE // 8
        return q[:, 0, middle, middle], None

    def forward(self, outline, centre, body, push, present, target):
        return torch.sigmoid(self.logit(outline, centre, body, push, present, target)[0])

    def fit(self, body, push):
        pass


def build(profile="fast", **options):
    return ReferencePpn(**options) if profile == "reference" else Ppn(**options)
