"""DIPN: what a push does to every body (kind `dipn`, interface 1)."""

import torch
from torch import nn

from .objects import Bodies
from .raster import ResNet, masks, window

INPUTS = ("outline", "centre", "body", "push", "guess", "present")
OUTPUTS = ("motion",)


class Dipn(nn.Module):
    """`guess="planar"`: learns what is missing in the planar engine's prediction. `guess="none"`: predicts the motion."""

    def __init__(self, width=96, moments=(0.0, 1.0, 1.0), guess="planar", lanes=16):
        super().__init__()
        self.guess = guess == "planar"
        self.bodies = Bodies(width, moments, guess=self.guess, lanes=lanes)

    def forward(self, outline, centre, body, push, guess, present):
        motion, _, _ = self.bodies(outline, centre, body, push, present, guess)
        return motion

    def fit(self, body, push):
        """Takes the normalisation from rows of bodies [M,4] and pushes [M,4]."""
        given = torch.cat([body, push], -1)
        self.bodies.mean.copy_(given.mean(0))
        self.bodies.deviation.copy_(given.std(0).clamp(min=1e-3))


class ReferenceDipn(nn.Module):
    """The dissertation's network (chapter on VFT): residual networks over the whole image and over each body's mask,
    encoders of the centre and the action, a direct path, the sum of the interactions, a decoder. Images are drawn
    inside the graph from the outlines; normalisation is batch normalisation, which export folds."""

    SCENE, MASK, PIXEL = 224, 60, 0.002

    def __init__(self, width=256, guess="none"):
        super().__init__()
        self.guess = guess == "planar"
        blocks = (1, 1, 1, 1)
        self.scene = ResNet(2, blocks, 512)
        self.mask = ResNet(1, blocks, 64)
        self.centre = nn.Sequential(nn.Linear(2, 8), nn.ReLU(), nn.Linear(8, 16), nn.ReLU())
        self.action = nn.Sequential(nn.Linear(4, 8), nn.ReLU(), nn.Linear(8, 16), nn.ReLU())
        one, two = 16 + 64 + 16, 16 + 2 * (64 + 16)
        self.direct = nn.Sequential(nn.Linear(one, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.interaction = nn.Sequential(
            nn.Linear(two, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.decoder = nn.Sequential(
            nn.Linear(512 + width, 256), nn.ReLU(), nn.Linear(256, 64), nn.ReLU(), nn.Linear(64, 16), nn.ReLU(),
            nn.Linear(16, 3))

    def forward(self, outline, centre, body, push, guess, present):
        b, n = centre.shape[:2]
        mask = present.unsqueeze(-1)
        shapes = masks(outline, torch.zeros_like(centre), window(self.MASK, self.PIXEL, outline))
        shape = self.mask(shapes.reshape(-1, 1, self.MASK, self.MASK)).reshape(b, -1, 64)
        grid = window(self.SCENE, self.PIXEL, outline) + torch.tensor([0.144, 0.0])
        foreground = (masks(outline, centre, grid) * mask.unsqueeze(-1)).amax(1)
        inside = (grid[..., 0] > -push[:, 2:3, None] / 2) & (grid[..., 0] < push[:, :1, None] + push[:, 2:3, None] / 2)
        inside = inside & (grid[..., 1].abs() < push[:, 1:2, None] / 2)
        scene = self.scene(torch.stack([foreground, inside.to(foreground.dtype)], 1))
        node = torch.cat([shape, self.centre(centre * 20)], -1)
        action = self.action(push * 20).unsqueeze(1) + torch.zeros_like(node[..., :1])
        own = self.direct(torch.cat([action, node], -1))
        this, that = node.unsqueeze(2), node.unsqueeze(1)
        zero = torch.zeros_like(this[..., :1] + that[..., :1])
        pairs = torch.cat([action.unsqueeze(2) + zero, this + zero, that + zero], -1)
        near = self.interaction(pairs) * present.unsqueeze(1).unsqueeze(-1)
        near = near.sum(2) - self.interaction(torch.cat([action, node, node], -1))
        code = scene.unsqueeze(1) + torch.zeros_like(own[..., :1])
        motion = self.decoder(torch.cat([code, own + near], -1)) / 20
        return (motion + guess if self.guess else motion) * mask

    def fit(self, body, push):
        pass


def build(profile="fast", **options):
    return ReferenceDipn(**options) if profile == "reference" else Dipn(**options)
