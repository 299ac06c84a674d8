"""The nearest of many triangles at each pixel, compiled by Numba; `depth_reference.py` is the same in NumPy."""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import jit
from maskval.contour import ContourEdges
from maskval.rendering import lens as plain
from maskval.rendering.lens import Box, Floats, Layers, Point, Row, View

Indices = NDArray[np.uint32]

_centred, _projection, _eye = jit(plain.centred), jit(plain.projection), jit(plain.eye)


@jit
def draw(edges: ContourEdges, view: View, number: int, box: Box, layers: Layers) -> Box:
    """Draws a mesh where it is nearer than what is there; a solid one is seen from outside only.

    Args:
        edges: The mesh.
        view: How it is seen.
        number: Its number.
        box: Pixels that may be drawn.
        layers: What is nearest; changed.

    Returns:
        A box around what was drawn, within the given one.
    """
    points, triangles = _visible(edges, view, False)
    box = _bounds(points, len(triangles), box)
    for i in range(len(triangles)):
        _draw(points, triangles[i], number, box, layers)
    return box


@jit
def depth(edges: ContourEdges, view: View, size: tuple[int, int], whole: bool) -> tuple[NDArray[np.float32], int, int]:
    """The z-depth of a mesh, metres, 0 where it is not, and the first column and row of it.

    Args:
        edges: The mesh.
        view: How it is seen; of a solid that the near plane cuts, the inside is seen, too.
        size: Width and height of the image, pixels.
        whole: Whether in the whole image; else in a box around the mesh.
    """
    points, triangles = _visible(edges, view, True)
    left, top, right, bottom = box = _bounds(points, len(triangles), (0, 0, size[0], size[1]))
    inverse = np.zeros((bottom - top, right - left))
    layers = Layers(inverse, np.empty((0, 0), dtype=np.int8), left, top)
    for i in range(len(triangles)):
        _draw(points, triangles[i], 0, box, layers)
    if not whole:
        return invert(inverse), left, top
    found = np.empty((size[1], size[0]), dtype=np.float32)
    found[:top] = 0.0
    found[bottom:] = 0.0
    for row in range(top, bottom):
        found[row, :left] = 0.0
        found[row, right:] = 0.0
        _invert(inverse[row - top], found[row, left:right])
    return found, 0, 0


@jit
def invert(inverse: Floats) -> NDArray[np.float32]:
    """The depth of an inverse depth, metres; 0 where nothing is."""
    found = np.empty(inverse.shape, dtype=np.float32)
    for row in range(len(inverse)):
        _invert(inverse[row], found[row])
    return found


@jit
def _invert(inverse: Floats, found: NDArray[np.float32]) -> None:
    for column in range(len(inverse)):
        value = inverse[column]
        found[column] = 1.0 / value if value > 0 else 0.0


@jit
def _homogeneous(row: Row, vertices: Floats, index: int) -> float:
    value: float = row[0] * vertices[index, 0] + row[1] * vertices[index, 1] + row[2] * vertices[index, 2] + row[3]
    return value


@jit
def _visible(edges: ContourEdges, view: View, cut_open: bool) -> tuple[Floats, Indices]:
    """u, v and inverse depth of corners, (V, 3), and the triangles that may be seen, (F, 3).

    Args:
        edges: The mesh.
        view: How it is seen.
        cut_open: Whether the inside of a solid is seen where the near plane cuts it.
    """
    X_CM = _centred(view.rotation, view.translation, edges.centre_O)
    rows, eye, near = _projection(view.lens, X_CM), _eye(X_CM), view.near
    vertices, faces = edges.vertices_M, edges.faces
    points = np.empty((len(vertices), 3))
    behind = 0
    for i in range(len(vertices)):
        for axis in range(3):
            points[i, axis] = _homogeneous(rows[axis], vertices, i)
        behind += points[i, 2] < near
    one_sided = view.is_solid and not (cut_open and behind)
    triangles = np.empty((0 if behind == len(vertices) else len(faces), 3), dtype=np.uint32)
    count = 0
    planes, x, y, z = edges.planes_M, np.float32(eye[0]), np.float32(eye[1]), np.float32(eye[2])
    for i in range(len(triangles)):
        facing = planes[0, i] * x + planes[1, i] * y + planes[2, i] * z + planes[3, i] > 0
        for corner in range(3):
            triangles[count, corner] = faces[i, corner]
        count += facing or not one_sided
    triangles = triangles[:count]
    if behind:
        points, triangles = _cut(points, triangles, near)
    for i in range(len(points)):
        scale = 1.0 / points[i, 2]
        points[i, 0] *= scale
        points[i, 1] *= scale
        points[i, 2] = scale
    return points, triangles


@jit
def _cut(corners: Floats, triangles: Indices, near: float) -> tuple[Floats, Indices]:
    """The triangles' parts before the near plane, with corners of their own."""
    parts = np.empty((6 * len(triangles), 3))
    count = 0
    for i in range(len(triangles)):
        inside = 0
        for corner in range(3):
            inside += corners[triangles[i, corner], 2] >= near
        if inside == 0:
            continue
        if inside == 3:
            for corner in range(3):
                parts[count + corner] = corners[triangles[i, corner]]
            count += 3
            continue
        # Turn the triangle so that its first corner is alone on its side.
        lone = 0
        while (corners[triangles[i, lone], 2] >= near) != (inside == 1):
            lone += 1
        a = corners[triangles[i, lone]]
        b, c = corners[triangles[i, (lone + 1) % 3]], corners[triangles[i, (lone + 2) % 3]]
        to_b, to_c = (near - a[2]) / (b[2] - a[2]), (near - a[2]) / (c[2] - a[2])
        first, second = (count + 1, count + 2) if inside == 1 else (count, count + 5)
        for axis in range(3):
            ab = near if axis == 2 else a[axis] + (b[axis] - a[axis]) * to_b
            ac = near if axis == 2 else a[axis] + (c[axis] - a[axis]) * to_c
            parts[first, axis], parts[second, axis] = ab, ac
            if inside == 1:
                parts[count, axis] = a[axis]
            else:
                parts[count + 1, axis], parts[count + 2, axis] = b[axis], c[axis]
                parts[count + 3, axis], parts[count + 4, axis] = ab, c[axis]
        count += 3 if inside == 1 else 6
    return parts[:count], np.arange(count).astype(np.uint32).reshape(-1, 3)


@jit
def _bounds(points: Floats, triangles: int, box: Box) -> Box:
    """The box around the corners, within another one; empty if there are no triangles."""
    left, top, right, bottom = box
    if triangles == 0:
        return left, top, left, top
    low_u = low_v = np.inf
    high_u = high_v = -np.inf
    for i in range(len(points)):
        low_u, high_u = min(low_u, points[i, 0]), max(high_u, points[i, 0])
        low_v, high_v = min(low_v, points[i, 1]), max(high_v, points[i, 1])
    left, top = math.ceil(min(max(low_u, left), right)), math.ceil(min(max(low_v, top), bottom))
    right, bottom = math.ceil(min(max(high_u, left), right)), math.ceil(min(max(high_v, top), bottom))
    return left, top, right, bottom


@jit
def _point(points: Floats, index: np.uint32) -> Point:
    return points[index, 0], points[index, 1], points[index, 2]


@jit
def _slope(upper: Point, lower: Point) -> float:
    """du/dv of a side; the same number for both triangles at the side, and nothing where it crosses no row."""
    return (lower[0] - upper[0]) / (lower[1] - upper[1]) if math.ceil(upper[1]) < math.ceil(lower[1]) else 0.0


@jit
def _draw(points: Floats, triangle: Indices, number: int, box: Box, layers: Layers) -> None:
    """Draws a triangle, given by its corners' indices; its number only where there are numbers."""
    a, b, c = _point(points, triangle[0]), _point(points, triangle[1]), _point(points, triangle[2])
    if a[1] > b[1]:
        a, b = b, a
    if b[1] > c[1]:
        b, c = c, b
        if a[1] > b[1]:
            a, b = b, a
    left, top, right, bottom = box
    first = math.ceil(min(max(a[1], float(top)), float(bottom)))
    last = math.ceil(min(max(c[1], float(top)), float(bottom)))
    if first >= last:
        return
    middle = math.ceil(min(max(b[1], float(top)), float(bottom)))
    long, above, below = _slope(a, c), _slope(a, b), _slope(b, c)
    area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    scale = 1.0 / area if area != 0 else 0.0
    # The inverse depth is what is linear in the image.
    per_column = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) * scale
    per_row = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) * scale
    farthest, closest = min(a[2], b[2], c[2]), max(a[2], b[2], c[2])
    for row in range(first, last):
        one = a[0] + (row - a[1]) * long
        other = a[0] + (row - a[1]) * above if row < middle else b[0] + (row - b[1]) * below
        begin = math.ceil(max(min(one, other), float(left)))
        end = math.ceil(min(max(one, other), float(right)))
        base = a[2] + (row - a[1]) * per_row
        line = layers.inverse[row - layers.top]
        for column in range(begin, end):
            # A sliver's slope may be anything: no pixel lies beyond the corners.
            value = min(max(base + (column - a[0]) * per_column, farthest), closest)
            if value > line[column - layers.left]:
                line[column - layers.left] = value
                if layers.numbers.size:
                    layers.numbers[row - layers.top, column - layers.left] = number
