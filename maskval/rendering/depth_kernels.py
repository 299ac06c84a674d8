"""The nearest of many triangles at each pixel, compiled by Numba; `depth_reference.py` is the same in NumPy."""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.rendering.compiled import jit

Floats = NDArray[np.float64]
Point = tuple[float, float, float]


@jit
def _point(points: Floats, index: np.uint32) -> Point:
    return points[index, 0], points[index, 1], points[index, 2]


@jit
def _slope(upper: Point, lower: Point) -> float:
    """du/dv of a side; the same number for both triangles at the side, and nothing where it crosses no row."""
    return (lower[0] - upper[0]) / (lower[1] - upper[1]) if math.ceil(upper[1]) < math.ceil(lower[1]) else 0.0


@jit
def nearest(points: Floats, triangles: NDArray[np.uint32], left: int, top: int, depth: NDArray[np.float32]) -> None:
    """Writes the least depth of the triangles over each pixel of a region.

    Args:
        points: u, v (pixels, sampled at whole numbers) and inverse depth of each corner, (V, 3).
        triangles: Corners, (F, 3).
        left: First column of the region.
        top: First row of the region.
        depth: Depths of the region, (h, w), metres; 0 where nothing is.
    """
    height, width = depth.shape
    # The inverse depth is what is linear in the image.
    inverse = np.zeros((height, width))
    for i in range(len(triangles)):
        a, b, c = _point(points, triangles[i, 0]), _point(points, triangles[i, 1]), _point(points, triangles[i, 2])
        if a[1] > b[1]:
            a, b = b, a
        if b[1] > c[1]:
            b, c = c, b
            if a[1] > b[1]:
                a, b = b, a
        first, middle, last = max(math.ceil(a[1]), top), math.ceil(b[1]), min(math.ceil(c[1]), top + height)
        if first >= last:
            continue
        long, above, below = _slope(a, c), _slope(a, b), _slope(b, c)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        scale = 1.0 / area if area != 0 else 0.0
        per_column = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) * scale
        per_row = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) * scale
        farthest, closest = min(a[2], b[2], c[2]), max(a[2], b[2], c[2])
        for row in range(first, last):
            one = a[0] + (row - a[1]) * long
            other = a[0] + (row - a[1]) * above if row < middle else b[0] + (row - b[1]) * below
            begin = math.ceil(max(min(one, other), float(left)))
            end = math.ceil(min(max(one, other), float(left + width)))
            base = a[2] + (row - a[1]) * per_row
            line = inverse[row - top]
            for column in range(begin, end):
                # A sliver's slope may be anything: no pixel lies beyond the corners.
                value = min(max(base + (column - a[0]) * per_column, farthest), closest)
                line[column - left] = max(line[column - left], value)
    for row in range(height):
        for column in range(width):
            value = inverse[row, column]
            depth[row, column] = 1.0 / value if value > 0 else 0.0
