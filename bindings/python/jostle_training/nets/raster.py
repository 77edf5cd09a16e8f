"""Images drawn inside a graph, and the residual networks of the `reference` profiles."""

import torch
from torch import nn


def window(size, pixel, like):
    """Pixel centres [size, size, 2] of an image about the origin: columns along x, rows along y."""
    at = (torch.arange(size, dtype=like.dtype, device=like.device) + 0.5 - size / 2) * pixel
    y, x = torch.meshgrid(at, at, indexing="ij")
    return torch.stack([x, y], -1)


def masks(outline, centre, grid):
    """1 where a pixel lies in a body (even-odd rule): outline [B,N,P,2], centre [B,N,2], grid [H,W,2]."""
    points = outline + centre.unsqueeze(2)
    odd = torch.zeros_like(points[:, :, 0, :1].unsqueeze(-1) + grid[..., 0])
    for k in range(points.shape[2]):
        a = points[:, :, k, :, None, None]
        b = points[:, :, k - 1, :, None, None]
        spans = (a[:, :, 1] > grid[..., 1]) != (b[:, :, 1] > grid[..., 1])
        rise = b[:, :, 1] - a[:, :, 1]
        rise = torch.where(rise.abs() < 1e-9, torch.full_like(rise, 1e-9), rise)
        cross = (b[:, :, 0] - a[:, :, 0]) * (grid[..., 1] - a[:, :, 1]) / rise + a[:, :, 0]
        hit = (spans & (grid[..., 0] < cross)).to(odd.dtype)
        odd = odd + hit - 2 * odd * hit
    return odd


def conv(a, b, stride=1, kernel=3):
    return nn.Sequential(nn.Conv2d(a, b, kernel, stride, kernel // 2, bias=False), nn.BatchNorm2d(b))


class Block(nn.Module):
    def __init__(self, a, b, stride):
        super().__init__()
        self.first, self.second = conv(a, b, stride), conv(b, b)
        self.skip = nn.Identity() if stride == 1 and a == b else conv(a, b, stride, 1)

    def forward(self, x):
        return torch.relu(self.second(torch.relu(self.first(x))) + self.skip(x))


class Trunk(nn.Module):
    """The residual stages of a ResNet of basic blocks; returns the output of each stage."""

    def __init__(self, channels, blocks):
        super().__init__()
        self.stem = nn.Sequential(conv(channels, 64, 2, 7), nn.ReLU(), nn.MaxPool2d(3, 2, 1))
        stages, a = [], 64
        for k, count in enumerate(blocks):
            b = 64 << k
            stages.append(nn.Sequential(*(Block(a if i == 0 else b, b, 2 if i == 0 and k else 1) for i in range(count))))
            a = b
        self.stages = nn.ModuleList(stages)

    def forward(self, x):
        x = self.stem(x)
        out = []
        for stage in self.stages:
            x = stage(x)
            out.append(x)
        return out


class ResNet(nn.Module):
    def __init__(self, channels, blocks, out):
        super().__init__()
        self.trunk, self.out = Trunk(channels, blocks), nn.Linear(512, out)

    def forward(self, x):
        return self.out(self.trunk(x)[-1].mean((2, 3)))


class ResNetPyramid(nn.Module):
    """Feature pyramid; returns its finest level, 256 channels at a quarter of the image's size."""

    def __init__(self, channels, blocks):
        super().__init__()
        self.trunk = Trunk(channels, blocks)
        self.side = nn.ModuleList(nn.Conv2d(64 << k, 256, 1) for k in range(4))
        self.smooth = nn.Conv2d(256, 256, 3, padding=1)

    def forward(self, x):
        levels = self.trunk(x)
        top = self.side[3](levels[3])
        for k in (2, 1, 0):
            top = self.side[k](levels[k]) + nn.functional.interpolate(top, size=levels[k].shape[-2:], mode="nearest")
        return self.smooth(top)
