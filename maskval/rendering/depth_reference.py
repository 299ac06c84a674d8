"""The nearest of many triangles at each pixel, in NumPy: the definition that `depth_kernels.py` repeats faster."""

import numpy as np
from numpy.typing import NDArray

from maskval.rendering.reference import steps

Floats = NDArray[np.float64]


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
    soup = points[triangles]
    soup = np.take_along_axis(soup, np.argsort(soup[..., 1], axis=1, kind="stable")[..., None], axis=1)
    a, b, c = np.moveaxis(soup, 1, 0)
    first = np.maximum(np.ceil(a[:, 1]).astype(np.int64), top)
    last = np.minimum(np.ceil(c[:, 1]).astype(np.int64), top + height)
    row, face = steps(first, np.maximum(first, last))
    one = a[face, 0] + (row - a[face, 1]) * _slope(a, c)[face]
    upper = a[face, 0] + (row - a[face, 1]) * _slope(a, b)[face]
    lower = b[face, 0] + (row - b[face, 1]) * _slope(b, c)[face]
    other = np.where(row < np.ceil(b[face, 1]), upper, lower)
    begin = np.ceil(np.maximum(np.minimum(one, other), left)).astype(np.int64)
    end = np.ceil(np.minimum(np.maximum(one, other), left + width)).astype(np.int64)

    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    scale = np.divide(1.0, area, out=np.zeros_like(area), where=area != 0)
    per_column = ((b[:, 2] - a[:, 2]) * (c[:, 1] - a[:, 1]) - (c[:, 2] - a[:, 2]) * (b[:, 1] - a[:, 1])) * scale
    per_row = ((c[:, 2] - a[:, 2]) * (b[:, 0] - a[:, 0]) - (b[:, 2] - a[:, 2]) * (c[:, 0] - a[:, 0])) * scale
    base = a[face, 2] + (row - a[face, 1]) * per_row[face]
    column, span = steps(begin, np.maximum(begin, end))
    row, face = row[span], face[span]
    value = base[span] + (column - a[face, 0]) * per_column[face]
    value = np.clip(value, soup[..., 2].min(axis=1)[face], soup[..., 2].max(axis=1)[face])
    # The inverse depth is what is linear in the image.
    inverse = np.zeros(depth.shape)
    np.maximum.at(inverse, (row - top, column - left), value)
    depth[...] = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0)


def _slope(upper: Floats, lower: Floats) -> Floats:
    rise = lower[:, 1] - upper[:, 1]
    crosses = np.ceil(upper[:, 1]) < np.ceil(lower[:, 1])
    return np.divide(lower[:, 0] - upper[:, 0], rise, out=np.zeros_like(rise), where=crosses)
