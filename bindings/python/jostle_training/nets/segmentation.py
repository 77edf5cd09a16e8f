"""Segmentation: from a height image to what a caller groups into bodies (kind `segmentation`, interface 1).

`reference` is torchvision's Mask R-CNN as in the dissertation; it is kind `segmentation`, interface 2, and needs
torchvision."""

import torch
from torch import nn

from .gc import HEIGHT, layer

INPUTS = ("image",)
OUTPUTS = ("foreground", "centre", "offset")

REACH = 0.1  # metres; no offset to a centre is longer


class Segmentation(nn.Module):
    """A U-Net: foreground, heat of the centres, and the way from each pixel to its body's centre."""

    def __init__(self, width=16):
        super().__init__()
        w = width
        self.stem = nn.Sequential(layer(1, w, 5, 2), layer(w, w))
        self.down = nn.ModuleList(
            nn.Sequential(layer(w << k, 2 * w << k, 3, 2), layer(2 * w << k, 2 * w << k)) for k in range(3))
        self.up = nn.ModuleList(nn.ConvTranspose2d(2 * w << k, w << k, 2, 2) for k in range(3))
        self.join = nn.ModuleList(layer(2 * w << k, w << k) for k in range(3))
        self.out = nn.ConvTranspose2d(w, 4, 2, 2)

    def maps(self, image):
        """Logits of foreground and heat [B,224,224], and the way to the centre in metres [B,2,224,224]."""
        levels = [self.stem(image * HEIGHT)]
        for down in self.down:
            levels.append(down(levels[-1]))
        x = levels[-1]
        for k in (2, 1, 0):
            x = self.join[k](torch.cat([self.up[k](x), levels[k]], 1))
        x = self.out(x)
        return x[:, 0], x[:, 1], torch.tanh(x[:, 2:]) * REACH

    def forward(self, image):
        foreground, heat, offset = self.maps(image)
        return torch.sigmoid(foreground), torch.sigmoid(heat), offset


def group(foreground, heat, offset, least=0.5, score=0.3, radius=4, pixel=0.002, pixels=20):
    """Labels of one image [224,224] as the library makes them of the outputs: 0 is the table. The centres are where the
    heat is greatest within `radius`; a pixel belongs to the centre that it points to."""
    there = foreground >= least
    most = nn.functional.max_pool2d(heat[None, None], 2 * radius + 1, 1, radius)[0, 0]
    row, col = torch.nonzero((heat >= most) & (heat >= score) & there, as_tuple=True)
    labels = torch.zeros(heat.shape, dtype=torch.long)
    if len(row):
        at = torch.arange(heat.shape[-1])
        x, y = at + offset[0] / pixel, at[:, None] + offset[1] / pixel
        distance = (x[..., None] - col) ** 2 + (y[..., None] - row) ** 2
        labels = torch.where(there, distance.argmin(-1) + 1, 0)
        counts = torch.bincount(labels.flatten(), minlength=len(row) + 1)
        labels = torch.where(counts[labels] >= pixels, labels, 0)
    return labels


def build(profile="fast", **options):
    if profile == "reference":
        from torchvision.models.detection import maskrcnn_resnet50_fpn

        return maskrcnn_resnet50_fpn(weights=None, weights_backbone=None, num_classes=2)
    return Segmentation(**options)
