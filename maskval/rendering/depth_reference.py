"""The nearest of many triangles at each pixel, in NumPy: the definition that `depth_kernels.py` repeats faster."""

import numpy as np
from numpy.typing import NDArray

from maskval.contour import ContourEdges
from maskval.rendering.lens import Box, Floats, Layers, View, centred, eye, projection
from maskval.rendering.reference import homogeneous, steps

Indices = NDArray[np.uint32]


def draw(edges: ContourEdges, view: View, number: int, box: Box, layers: Layers) -> Box:
    """See `depth_kernels.draw`."""
    points, triangles = _visible(edges, view, cut_open=False)
    left, top, right, bottom = found = _bounds(points, triangles, box)
    own = _nearest(points, triangles, found)
    window = (slice(top - layers.top, bottom - layers.top), slice(left - layers.left, right - layers.left))
    nearer = own > layers.inverse[window]
    layers.inverse[window][nearer] = own[nearer]
    layers.numbers[window][nearer] = number
    return found


def depth(edges: ContourEdges, view: View, size: tuple[int, int], whole: bool) -> tuple[NDArray[np.float32], int, int]:
    """See `depth_kernels.depth`."""
    points, triangles = _visible(edges, view, cut_open=True)
    left, top, right, bottom = box = _bounds(points, triangles, (0, 0, *size))
    found = invert(_nearest(points, triangles, box))
    if not whole:
        return found, left, top
    image = np.zeros(size[::-1], dtype=np.float32)
    image[top:bottom, left:right] = found
    return image, 0, 0


def invert(inverse: Floats) -> NDArray[np.float32]:
    """See `depth_kernels.invert`."""
    return np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0).astype(np.float32)


def _visible(edges: ContourEdges, view: View, *, cut_open: bool) -> tuple[Floats, Indices]:
    """u, v and inverse depth of corners, (V, 3), and the triangles that may be seen, (F, 3)."""
    X_CM, near = centred(view.rotation, view.translation, edges.centre_O), view.near
    corners, triangles = homogeneous(projection(view.lens, X_CM), edges.vertices_M), edges.faces
    before = corners[:, 2] >= near
    if not before.any():
        return np.empty((0, 3)), triangles[:0]
    if view.is_solid and (before.all() or not cut_open):
        nx, ny, nz, offset = edges.planes_M
        x, y, z = np.array(eye(X_CM), dtype=np.float32)
        triangles = triangles[nx * x + ny * y + nz * z + offset > 0]
    if not before.all():
        corners, triangles = _cut(corners, triangles, near)
    scale = 1.0 / corners[:, 2:]
    return np.concatenate((corners[:, :2] * scale, scale), axis=1), triangles


def _cut(corners: Floats, triangles: Indices, near: float) -> tuple[Floats, Indices]:
    """The triangles' parts before the near plane, with corners of their own."""
    soup = corners[triangles]
    before = soup[..., 2] >= near
    parts = [soup[before.all(axis=1)]]
    for triangle, inside in zip(soup, before, strict=True):
        if inside.all() or not inside.any():
            continue
        # Turn the triangle so that its first corner is alone on its side.
        lone = int(np.argmax(inside == (inside.sum() == 1)))
        a, b, c = np.roll(triangle, -lone, axis=0)
        ab, ac = (a + (other - a) * ((near - a[2]) / (other[2] - a[2])) for other in (b, c))
        ab[2] = ac[2] = near
        parts.append(np.array([[a, ab, ac]] if inside.sum() == 1 else [[ab, b, c], [ab, c, ac]]))
    kept = np.concatenate(parts)
    return kept.reshape(-1, 3), np.arange(3 * len(kept), dtype=np.uint32).reshape(-1, 3)


def _bounds(points: Floats, triangles: Indices, box: Box) -> Box:
    """The box around the corners, within another one; empty if there are no triangles."""
    left, top, right, bottom = box
    if len(triangles) == 0:
        return left, top, left, top
    (low_u, low_v), (high_u, high_v) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    left, top = int(np.ceil(np.clip(low_u, left, right))), int(np.ceil(np.clip(low_v, top, bottom)))
    right, bottom = int(np.ceil(np.clip(high_u, left, right))), int(np.ceil(np.clip(high_v, top, bottom)))
    return left, top, right, bottom


def _nearest(points: Floats, triangles: Indices, box: Box) -> Floats:
    """The greatest inverse depth of the triangles at each pixel of a box, 0 where none is."""
    left, top, right, bottom = box
    inverse = np.zeros((bottom - top, right - left))
    soup = points[triangles]
    soup = np.take_along_axis(soup, np.argsort(soup[..., 1], axis=1, kind="stable")[..., None], axis=1)
    a, b, c = np.moveaxis(soup, 1, 0)
    first, last = (np.ceil(np.clip(corner[:, 1], top, bottom)).astype(np.int64) for corner in (a, c))
    row, face = steps(first, np.maximum(first, last))
    one = a[face, 0] + (row - a[face, 1]) * _slope(a, c)[face]
    upper = a[face, 0] + (row - a[face, 1]) * _slope(a, b)[face]
    lower = b[face, 0] + (row - b[face, 1]) * _slope(b, c)[face]
    other = np.where(row < np.ceil(b[face, 1]), upper, lower)
    begin = np.ceil(np.maximum(np.minimum(one, other), left)).astype(np.int64)
    end = np.ceil(np.minimum(np.maximum(one, other), right)).astype(np.int64)

    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    scale = np.divide(1.0, area, out=np.zeros_like(area), where=area != 0)
    per_column = ((b[:, 2] - a[:, 2]) * (c[:, 1] - a[:, 1]) - (c[:, 2] - a[:, 2]) * (b[:, 1] - a[:, 1])) * scale
    per_row = ((c[:, 2] - a[:, 2]) * (b[:, 0] - a[:, 0]) - (b[:, 2] - a[:, 2]) * (c[:, 0] - a[:, 0])) * scale
    base = a[face, 2] + (row - a[face, 1]) * per_row[face]
    column, span = steps(begin, np.maximum(begin, end))
    row, face = row[span], face[span]
    # The inverse depth is what is linear in the image. A sliver's slope may be anything: no pixel lies beyond corners.
    value = base[span] + (column - a[face, 0]) * per_column[face]
    value = np.clip(value, soup[..., 2].min(axis=1)[face], soup[..., 2].max(axis=1)[face])
    np.maximum.at(inverse, (row - top, column - left), value)
    return inverse


def _slope(upper: Floats, lower: Floats) -> Floats:
    rise = lower[:, 1] - upper[:, 1]
    crosses = np.ceil(upper[:, 1]) < np.ceil(lower[:, 1])
    return np.divide(lower[:, 0] - upper[:, 0], rise, out=np.zeros_like(rise), where=crosses)
