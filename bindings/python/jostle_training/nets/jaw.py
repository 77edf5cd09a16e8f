"""What a jaw finds about itself, for GN.

Whether a grasp holds depends on what lies about the jaw: obstacles where the fingers and the space between them come
down, and the target's outline between the pads. So the network looks at the image through one window, laid at each cell
and turned to each of 16 closing directions, and judges what it shows by the same weights: what is learned at one place and
angle is known at all of them. A window is a grid of taps, each the image averaged over about the taps' spacing.

The taps of a direction are fixed shifts, rounded to a step finer than a cell. They are read from copies of the image at
these steps, which one convolution makes. Besides it there are only slices, gathers with fixed indices and products of
matrices, which the small runtimes have.
"""

import math

import torch
from torch import nn
from torch.nn import functional

ANGLES = 16
SIDE, PIXEL = 112, 2  # pixels, and mm of each


def seen(image):
    """[B,2,112,112]: obstacles and the target, each 0 or 1."""
    there = (image[:, :1] * 100).clamp(max=1)
    target = image[:, 1:]
    return torch.cat([there * (1 - target), target], 1)


def taps(spacing, across, along, beyond=()):
    """[U,V,2], mm: `across` is how far they reach along the closing direction, `along` how far along the pads; single
    rows lie `beyond` on both sides."""
    u = torch.arange(-across + spacing / 2, across, spacing)
    v = torch.arange(-along + spacing / 2, along, spacing)
    v = torch.cat([-torch.tensor(beyond).flip(0), v, torch.tensor(beyond)])
    return torch.stack(torch.meshgrid(u, v, indexing="ij"), -1)


class Window(nn.Module):
    """Reads what the taps of 16 directions show at the cells about the image's middle.

    mm: `cell` is a cell's side, `step` what taps are rounded to, `spacing` how far apart they are, `obstacles` and
    `target` how far those two windows reach. `half` is the number of cells on each side of the middle."""

    def __init__(self, cell, step, spacing, half, obstacles, target):
        super().__init__()
        self.cell, self.step, self.half, self.phases = cell, step, half, cell // step
        self.rows, self.stride = SIDE * PIXEL // cell, cell // PIXEL
        # The image at `b * step` from each cell's corner: pixels weighted by a tent as wide as two spacings. They are
        # seen from the corner at odd mm, from `low` on.
        low = 1 - spacing
        count = ((self.phases - 1) * step - 2 * low) // PIXEL + 1
        place = low + PIXEL * torch.arange(count)
        weight = (1 - (torch.arange(self.phases)[:, None] * step - place).abs() / spacing).clamp(min=0)
        weight = weight / weight.sum(1, keepdim=True)
        tents = (weight[:, None, :, None] * weight[None, :, None, :]).flatten(0, 1)
        kernel = torch.zeros(2, len(tents), 2, count, count)
        kernel[0, :, 0], kernel[1, :, 1] = tents, tents
        self.register_buffer("kernel", kernel.flatten(0, 1), persistent=False)
        before = (1 - low) // PIXEL
        after = (self.rows - 1) * self.stride + count - SIDE - before
        self.pad = (before, after, before, after)

        grids = [taps(spacing, *obstacles), taps(spacing, *target)]
        self.grids = [tuple(g.shape[:2]) for g in grids]
        self.sizes = [a * b for a, b in self.grids]
        found = [self.shifts_of(g) for g in grids]
        self.reach = max(int(shift.abs().max()) for _, *shifts in found for shift in shifts)
        self.shown = 2 * (half + self.reach)  # rows and columns that the windows come to
        if half + self.reach > self.rows // 2:
            raise ValueError("the windows leave the image")
        for channel, (phase, y, x) in enumerate(found):
            first = (channel * self.phases**2 + phase) * self.rows + y
            # Of the row in `forward`'s copies; 32 bits, as the index is read from memory as often as the rows are.
            at = ((x + self.reach) * 2 * self.phases**2 + channel * self.phases**2 + phase) * self.shown + y + self.reach
            self.register_buffer(f"at{channel}", at.flatten(1).int(), persistent=False)
            self.register_buffer(f"flat{channel}", (first * self.rows + x).flatten(1), persistent=False)

    def shifts_of(self, grid):
        """Phase, row shift and column shift of each tap in each direction: three of [16,U,V]."""
        angle = torch.arange(ANGLES)[:, None, None] * math.pi / ANGLES
        c, s, (u, v) = angle.cos(), angle.sin(), grid.unbind(-1)
        y, x = (torch.round((p + self.cell / 2) / self.step).long() for p in (s * u + c * v, c * u - s * v))
        return y % self.phases * self.phases + x % self.phases, y // self.phases, x // self.phases

    def planes(self, image):
        """The image at finer steps: [B,2 phases^2,rows,rows]."""
        return functional.conv2d(functional.pad(seen(image), self.pad), self.kernel, stride=self.stride)

    def forward(self, image):
        """What the taps show at each of (2 half)^2 cells: obstacles and the target, [B,16,T,cells] each."""
        return self.shows(self.slid(image), 0, ANGLES)

    def slid(self, image):
        """What `shows` reads: a copy of the planes for each shift of the columns, in which the rows that a tap shows lie one
        after another: they are most of what is read."""
        side, begin = 2 * self.half, self.rows // 2 - self.half - self.reach
        x = self.planes(image)[..., begin : begin + self.shown, :]
        slid = torch.stack([x[..., begin + k : begin + k + side] for k in range(2 * self.reach + 1)], 1)
        return slid.reshape(-1, (2 * self.reach + 1) * 2 * self.phases**2 * self.shown, side)

    def shows(self, slid, first, count):
        """The same as `forward` of `count` directions from the `first` on: [B,count,T,cells] each."""
        side, out = 2 * self.half, []
        for at, size in zip((self.at0, self.at1), self.sizes):
            index = (at[first : first + count].unsqueeze(-1) + torch.arange(side, dtype=torch.int32)).reshape(-1)
            out.append(slid.index_select(1, index).reshape(-1, count, size, side * side))
        return out

    def places(self, planes, image, angle, row, col):
        """The same at single places [n] of some images' planes: [n,T] each."""
        corner = (image * planes.shape[1] * self.rows + row) * self.rows + col
        out = []
        for flat, size in zip((self.flat0, self.flat1), self.sizes):
            index = corner[:, None] + flat[angle]
            out.append(planes.reshape(-1).index_select(0, index.reshape(-1)).reshape(-1, size))
        return out


class Judge(nn.Module):
    """What is said of a window: two layers of features, of obstacles and target apart, then of both."""

    def __init__(self, sizes, obstacles, target, both, outputs):
        super().__init__()
        self.obstacles, self.target = nn.Linear(sizes[0], obstacles), nn.Linear(sizes[1], target)
        wide = [obstacles + target, *both]
        self.both = nn.ModuleList(nn.Linear(a, b) for a, b in zip(wide, wide[1:]))
        self.out = nn.Linear(wide[-1], outputs)

    def forward(self, obstacles, target):
        """[..., T] each to [..., outputs]."""
        x = torch.cat([self.obstacles(obstacles), self.target(target)], -1).relu()
        for layer in self.both:
            x = layer(x).relu()
        return self.out(x)

    def columns(self, obstacles, target):
        """[..., T, cells] each to [..., outputs, cells]."""
        layer = lambda l, x: l.weight @ x + l.bias[:, None]
        x = torch.cat([layer(self.obstacles, obstacles), layer(self.target, target)], -2).relu()
        for l in self.both:
            x = layer(l, x).relu()
        return layer(self.out, x)
