"""Geometry of bodies and a tip, computed inside the graph, and a network that passes messages between bodies.

Bodies come as outlines of 32 points in the push frame. From them the graph computes extents along 32 directions, the
gap of every pair of bodies along each (the largest is the distance of two convex bodies, or minus their penetration),
the gap to the tip, and the clearance before the tip on lanes across its width. Only operations that the small ONNX
runtimes have are used: no reshapes by computed sizes, no gathers.
"""

import math

import torch
from torch import nn

HALF = 16  # directions over half a turn; the other half follows from them
FAR = 0.15  # metres; distances are cut off here
SCALE = 20.0  # 5 cm becomes 1

# Columns of the node features besides the lanes.
NODE_FEATURES = 4 * HALF + 2 + 1 + 2


class Geometry(nn.Module):
    """Features of a moment: bodies at their poses, the tip at its place on the x axis."""

    def __init__(self, lanes=16):
        super().__init__()
        angles = torch.arange(HALF) * math.pi / HALF
        half = torch.stack([angles.cos(), angles.sin()])
        self.register_buffer("axes", half, persistent=False)
        self.register_buffer("around", torch.cat([half, -half], 1).T.contiguous(), persistent=False)
        self.register_buffer("lanes", (torch.arange(lanes) + 0.5) / lanes - 0.5, persistent=False)

    def forward(self, outline, centre, tip_x, width, thickness):
        """outline [B,N,32,2] about the centre, centre [B,N,2]; tip_x, width, thickness [B,1]: the tip's centre on the
        x axis, its size across and along it.

        Returns node features [B,N,NODE_FEATURES + lanes], extents hi and lo [B,N,32] (along a direction, and where the body
        ends on the other side), separation [B,N,N,1], normals [B,N,N,2] and separation from the tip [B,N,1]."""
        along = outline @ self.axes  # [B,N,32,16]
        upper, lower = along.amax(2), along.amin(2)
        at = centre @ self.axes  # [B,N,16]
        hi = torch.cat([at + upper, -(at + lower)], -1)
        lo = torch.cat([at + lower, -(at + upper)], -1)

        # The tip is a rectangle with its sides along the axes.
        reach = (self.axes[0].abs() * thickness + self.axes[1].abs() * width) / 2  # [B,16]
        on = self.axes[0] * tip_x
        tip_hi = torch.cat([on + reach, reach - on], -1).unsqueeze(1)
        tip_gap = lo - tip_hi  # [B,N,32]
        tip_separation = tip_gap.amax(-1, keepdim=True)
        tip_normal = torch.softmax(tip_gap * 500, -1) @ self.around

        gap = lo.unsqueeze(1) - hi.unsqueeze(2)  # [B,i,j,32]: where j begins, less where i ends
        separation = gap.amax(-1, keepdim=True)
        normal = torch.softmax(gap * 500, -1) @ self.around

        front = self.clearance(outline, centre, tip_x + thickness / 2, width)
        cut = lambda value: value.clamp(-FAR, FAR) * SCALE
        nodes = torch.cat(
            [upper * SCALE, lower * SCALE, cut(tip_gap), cut(tip_separation), tip_normal, front * SCALE,
             centre.clamp(-0.5, 0.5) * SCALE], -1)
        return nodes, hi, lo, separation, normal, tip_separation

    def clearance(self, outline, centre, face, width):
        """Where on each lane across the tip's width a body begins, before the tip's face (negative: inside the tip).

        A lane is a line along x. It cuts the edges of the outline that have their ends on different sides of it."""
        x = outline[..., 0] + centre[..., :1]
        y = outline[..., 1] + centre[..., 1:]
        x2 = torch.cat([x[..., 1:], x[..., :1]], -1)
        y2 = torch.cat([y[..., 1:], y[..., :1]], -1)
        slope = (x2 - x) / torch.where((y2 - y).abs() < 1e-9, torch.full_like(y, 1e-9), y2 - y)
        lane = (self.lanes * width).unsqueeze(1).unsqueeze(1)  # [B,1,1,lanes]
        above, above2 = y.unsqueeze(-1) - lane, y2.unsqueeze(-1) - lane
        cut = x.unsqueeze(-1) - above * slope.unsqueeze(-1)
        cut = torch.where(above * above2 <= 0, cut, torch.full_like(cut, 10.0))
        return (cut.amin(2) - face.unsqueeze(-1)).clamp(-FAR, FAR)


def mlp(*sizes):
    layers = []
    for a, b in zip(sizes, sizes[1:]):
        layers += [nn.Linear(a, b), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


class Round(nn.Module):
    """One round: bodies look at the geometry and at their neighbours, and renew their state."""

    def __init__(self, width, features, reach):
        super().__init__()
        self.reach = reach
        self.sender = nn.Linear(width, width)
        self.receiver = nn.Linear(width, width, bias=False)
        self.gaps = nn.Linear(2 * HALF, width, bias=False)
        self.pair = nn.Linear(3, width, bias=False)
        self.message = nn.Linear(width, width)
        self.see = nn.Linear(features, width)
        self.update = nn.Linear(2 * width, width)
        self.out = nn.Linear(width, width)
        nn.init.normal_(self.out.weight, std=0.3 / math.sqrt(width))

    def forward(self, h, features, pairs, hi, lo, gate):
        """pairs [B,N,N,3]; gate [B,N,N,1]: how much a pair counts, 0 beyond `reach` and on the diagonal."""
        to = self.receiver(h) - self.gaps(hi * SCALE)
        sent = self.sender(h) + self.gaps(lo * SCALE)
        m = torch.relu(to.unsqueeze(2) + sent.unsqueeze(1) + self.pair(pairs))
        m = (torch.relu(self.message(m)) * gate).sum(2)
        x = torch.relu(self.see(features) + self.update(torch.cat([h, m], -1)))
        return h + self.out(x)


class Bodies(nn.Module):
    """Follows bodies through moments of a push and moves them; the common part of DIPN and PPN.

    `moments` are places of the tip as parts of the push's length; in each the geometry is computed anew from where the
    network has put the bodies so far, and one round corrects that. With a guess the first moment is the start (nothing
    is moved) and the others look at the guessed end."""

    def __init__(self, width, moments, guess=False, targets=False, reach=0.03, lanes=16):
        super().__init__()
        self.moments, self.guess, self.targets, self.reach = list(moments), guess, targets, reach
        self.geometry = Geometry(lanes)
        features = NODE_FEATURES + lanes + 3 + 8 + (1 if targets else 0)
        self.start = nn.Linear(features, width)
        self.rounds = nn.ModuleList(Round(width, features, reach) for _ in self.moments)
        self.heads = nn.ModuleList(nn.Linear(width, 3) for _ in self.moments)
        for head in self.heads:
            nn.init.zeros_(head.weight)
            nn.init.zeros_(head.bias)
        self.register_buffer("mean", torch.zeros(8))
        self.register_buffer("deviation", torch.ones(8))

    def forward(self, outline, centre, body, push, present, guess=None, target=None):
        """Motion [B,N,3], states of the bodies [B,N,width], and the last moment's geometry."""
        mask = present.unsqueeze(-1)
        both = mask.unsqueeze(1) * mask.unsqueeze(2)
        length, width, thickness = push[:, :1], push[:, 1:2], push[:, 2:3]
        given = torch.cat([body, push.unsqueeze(1) + torch.zeros_like(body)], -1)
        given = (given - self.mean) / self.deviation
        if self.targets:
            given = torch.cat([given, target.unsqueeze(-1)], -1)
        motion = guess if self.guess else torch.zeros_like(torch.cat([centre, present.unsqueeze(-1)], -1))
        h = None
        for k, (moment, round_, head) in enumerate(zip(self.moments, self.rounds, self.heads)):
            still = self.guess and k == 0
            now = (motion * 0 if still else motion).detach()
            c, s = now[..., 2:].cos(), now[..., 2:].sin()
            x, y = outline[..., 0], outline[..., 1]
            turned = torch.stack([c * x - s * y, s * x + c * y], -1)
            at = centre + now[..., :2]
            nodes, hi, lo, apart, normal, tip = self.geometry(turned, at, length * moment, width, thickness)
            # Only a body itself has its centre where a body has it.
            other = ((at.unsqueeze(1) - at.unsqueeze(2)).square().sum(-1, keepdim=True) > 1e-10).to(at.dtype)
            features = torch.cat([nodes, motion * SCALE if still else now * SCALE, given], -1)
            gate = (1 - apart / self.reach).clamp(0, 1) * both * other
            pairs = torch.cat([apart.clamp(-FAR, FAR) * SCALE, normal], -1)
            if h is None:
                h = self.start(features)
            h = round_(h, features, pairs, hi, lo, gate)
            if not still:
                # What nothing comes near stays where it is.
                touched = (1 - tip / self.reach).clamp(0, 1)
                touched = torch.maximum(touched, gate.amax(2))
                step = head(h) / SCALE
                motion = motion + step * touched * mask
        return motion * mask, h, (nodes, hi, lo, apart, normal, gate)
