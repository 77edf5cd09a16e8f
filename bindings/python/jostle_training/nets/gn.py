"""GN: how well a grasp does at each place and angle (kind `gn`, interface 1)."""

import math

import torch
from torch import nn

from .gc import HEIGHT, layer, prepared
from .raster import ResNetPyramid

INPUTS = ("image",)
OUTPUTS = ("quality",)

ANGLES = 16


class Gn(nn.Module):
    """A U-Net in one pass: 16 angles are 16 channels, at half of the image's resolution."""

    def __init__(self, width=16):
        super().__init__()
        w = width
        self.stem = nn.Sequential(layer(3, w, 5, 2), layer(w, w))
        self.down1 = nn.Sequential(layer(w, 3 * w // 2, 3, 2), layer(3 * w // 2, 3 * w // 2))
        self.down2 = nn.Sequential(layer(3 * w // 2, 2 * w, 3, 2), layer(2 * w, 2 * w), layer(2 * w, 2 * w, 3, 1, 2))
        self.up1 = nn.ConvTranspose2d(2 * w, 3 * w // 2, 2, 2)
        self.join1 = nn.Sequential(layer(3 * w, 3 * w // 2), layer(3 * w // 2, 3 * w // 2))
        self.up2 = nn.ConvTranspose2d(3 * w // 2, w, 2, 2)
        self.join2 = nn.Sequential(layer(2 * w, w), layer(w, w))
        self.out = nn.Conv2d(w, ANGLES, 1)
        # A grasp of the target has its centre within 2 cm of it: it lies between fingers 85 mm apart.
        self.near = nn.Sequential(nn.MaxPool2d((22, 1), (2, 1), (10, 0)), nn.MaxPool2d((1, 22), (1, 2), (0, 10)))
        nn.init.constant_(self.out.bias, -3.0)

    def logits(self, image):
        a = self.stem(prepared(image))
        b = self.down1(a)
        c = self.down2(b)
        b = self.join1(torch.cat([self.up1(c), b], 1))
        a = self.join2(torch.cat([self.up2(b), a], 1))
        return self.out(a) - 12 * (1 - self.near(image[:, 1:]))

    def forward(self, image):
        return torch.sigmoid(self.logits(image))


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
