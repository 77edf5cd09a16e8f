"""Intersection over union of bodies moved one way and another."""

import numpy as np
import shapely


def placed(outline, centre, motion):
    """Polygons of outlines [M,32,2] about their centres [M,2], moved by motion [M,3]."""
    c, s = np.cos(motion[:, 2:]), np.sin(motion[:, 2:])
    x, y = outline[..., 0], outline[..., 1]
    points = np.stack([c * x - s * y, s * x + c * y], -1) + (centre + motion[:, :2])[:, None]
    polygons = shapely.polygons(points)
    bad = ~shapely.is_valid(polygons)
    if bad.any():
        polygons[bad] = shapely.buffer(polygons[bad], 0)
    return polygons


def iou(outline, centre, motion, truth):
    """One figure per body."""
    a, b = placed(outline, centre, motion), placed(outline, centre, truth)
    common = shapely.area(shapely.intersection(a, b))
    return common / (shapely.area(a) + shapely.area(b) - common)
