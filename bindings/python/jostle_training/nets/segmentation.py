"""Segmentation: from a height image to what a caller groups into bodies (kind `segmentation`, interface 1).

`reference` is torchvision's Mask R-CNN as in the dissertation; it is kind `segmentation`, interface 2, and needs
torchvision."""

import torch
from torch import nn

from .gc import HEIGHT, layer

INPUTS = ("image",)
OUTPUTS = ("foreground", "centre", "offset")

REACH = 0.1  # metres; no offset to a centre is longer
# What stands out of the table is there: this much evidence for each metre above so many.
EVIDENCE, TABLE = 400.0, 0.01


class Segmentation(nn.Module):
    """A U-Net: foreground, heat of the centres, and the way from each pixel to its body's centre."""

    def __init__(self, width=16):
        super().__init__()
        w = width
        self.stem = layer(1, w, 5, 2)
        self.down = nn.ModuleList(
            nn.Sequential(layer(w << k, 2 * w << k, 3, 2), layer(2 * w << k, 2 * w << k)) for k in range(3))
        self.up = nn.ModuleList(nn.ConvTranspose2d(2 * w << k, w << k, 2, 2) for k in range(3))
        # Levels are added, which costs half of what joining them by channels does.
        self.join = nn.ModuleList(layer(w << k, w << k) for k in range(3))
        self.out = nn.ConvTranspose2d(w, 4, 2, 2)

    def maps(self, image, phase=None):
        """Logits of foreground and heat [B,224,224], and the way to the centre in metres [B,2,224,224]; of the pixels
        [i::2, j::2] alone where `phase` is (i, j), which is how it learns cheaply."""
        levels = [self.stem(image * HEIGHT)]
        for down in self.down:
            levels.append(down(levels[-1]))
        x = levels[-1]
        for k in (2, 1, 0):
            x = self.join[k](self.up[k](x) + levels[k])
        seen = image[:, 0]
        if phase is None:
            x = self.out(x)
        else:
            seen = seen[:, phase[0] :: 2, phase[1] :: 2]
            weight = self.out.weight[:, :, phase[0], phase[1]]
            x = nn.functional.conv2d(x, weight.t()[:, :, None, None], self.out.bias)
        return x[:, 0] + (seen - TABLE) * EVIDENCE, x[:, 1], torch.tanh(x[:, 2:]) * REACH

    def forward(self, image):
        foreground, heat, offset = self.maps(image)
        return torch.sigmoid(foreground), torch.sigmoid(heat), offset


SPREAD, VOTES = 2.0, 1.0  # pixels; spread votes from which on a pixel may be a middle


def group(foreground, heat, offset, least=0.5, score=0.3, radius=6, pixel=0.002, pixels=20):
    """Labels of one image [224,224] as the library makes them of the outputs (src/net/segmentation.rs): 0 is the table.
    Every pixel votes for the place that it points to; the middles are where the votes gather, and a pixel belongs to the
    middle next to its vote. The heat is not asked."""
    side = foreground.shape[-1]
    there, at = foreground >= least, torch.arange(side)
    x = (at + offset[0] / pixel).clamp(0, side - 1)[there]
    y = (at[:, None] + offset[1] / pixel).clamp(0, side - 1)[there]
    votes = torch.zeros(side * side).index_add_(0, y.round().long() * side + x.round().long(), torch.ones(len(x)))
    kernel = torch.exp(-torch.arange(-6, 7.0).square() / (2 * SPREAD**2))
    kernel = kernel / kernel.sum()
    votes = nn.functional.conv2d(votes.reshape(1, 1, side, side), kernel[None, None, :, None], padding=(6, 0))
    votes = nn.functional.conv2d(votes, kernel[None, None, None], padding=(0, 6))
    most = nn.functional.max_pool2d(votes, 2 * radius + 1, 1, radius)[0, 0]
    row, col = torch.nonzero((votes[0, 0] >= most) & (votes[0, 0] >= VOTES), as_tuple=True)
    labels = torch.zeros(foreground.shape, dtype=torch.long)
    if len(row):
        distance, own = ((x[:, None] - col) ** 2 + (y[:, None] - row) ** 2).min(1)
        labels[there] = own + 1
        counts = torch.bincount(own, minlength=len(row))
        close = torch.bincount(own[distance <= radius**2], minlength=len(row))
        keep = (counts >= pixels) & (close >= score * counts)
        labels = labels * torch.cat([torch.zeros(1, dtype=torch.bool), keep])[labels]
    return labels


def build(profile="fast", **options):
    if profile == "reference":
        from torchvision.models.detection import maskrcnn_resnet50_fpn

        return maskrcnn_resnet50_fpn(weights=None, weights_backbone=None, num_classes=2)
    return Segmentation(**options)
