"""The lines of a mesh's contour in the image, compiled by Numba: the first half of `kernels.py`.

Indices are unsigned where they are read from arrays: a signed one costs a look whether it is negative.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import jit
from maskval.contour import ContourEdges
from maskval.rendering import lens as plain_lens
from maskval.rendering import views as plain_views
from maskval.rendering.lens import Box, Rows
from maskval.rendering.views import Frame, View

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Point = tuple[float, float]
Lines = tuple[Floats, Ints]
Contour = tuple[NDArray[np.int8], NDArray[np.uint32]]  # sides and chosen edges

_centred, _projection, _eye = jit(plain_lens.centred), jit(plain_lens.projection), jit(plain_lens.eye)
_kind = jit(plain_views.kind)


@jit
def view(edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats) -> View:
    """How a mesh is seen under a pose."""
    X_CM = _centred(rotation, translation, edges.centre_O)
    return View(_projection(frame.lens, X_CM), _eye(X_CM), _kind(X_CM[2][3], edges.radius, frame.near))


@jit
def _facing(planes: NDArray[np.float32], eye: tuple[float, float, float]) -> NDArray[np.int8]:
    """The 2 F + 1 sides: the signs of the faces, their negatives, and 0."""
    count = planes.shape[1]
    nx, ny, nz, offset = planes[0], planes[1], planes[2], planes[3]
    x, y, z = np.float32(eye[0]), np.float32(eye[1]), np.float32(eye[2])
    sides = np.empty(2 * count + 1, dtype=np.int8)
    front, back = sides[:count], sides[count : 2 * count]
    for f in range(count):
        sign = np.int8(1) if nx[f] * x + ny[f] * y + nz[f] * z + offset[f] > 0 else np.int8(-1)
        front[f] = sign
        back[f] = -sign
    sides[2 * count] = 0
    return sides


@jit
def _chosen(sides: NDArray[np.int8], edges: ContourEdges) -> NDArray[np.uint32]:
    """The edges of the contour: those whose two sides do not cancel; they are few, so eight at a time are skipped."""
    lefts, rights = edges.lefts, edges.rights
    windings = np.zeros((len(lefts) + 7) // 8 * 8, dtype=np.int8)
    for e in range(len(lefts)):
        windings[e] = sides[lefts[e]] + sides[rights[e]]
    eights = windings.view(np.uint64)
    chosen = np.empty(len(windings), dtype=np.uint32)
    count = np.uint64(0)
    for i in range(len(eights)):
        if eights[i] != 0:
            for e in range(8 * i, 8 * i + 8):
                # Without a branch: on a crumpled mesh, nobody could predict it.
                chosen[count] = e
                count += np.uint64(windings[e] != 0)
    return chosen[:count]


@jit
def _homogeneous(rows: Rows, vertices: Floats, index: np.uint32) -> tuple[float, float, float]:
    x, y, z = vertices[index, 0], vertices[index, 1], vertices[index, 2]
    return (
        rows[0][0] * x + rows[0][1] * y + rows[0][2] * z + rows[0][3],
        rows[1][0] * x + rows[1][1] * y + rows[1][2] * z + rows[1][3],
        rows[2][0] * x + rows[2][1] * y + rows[2][2] * z + rows[2][3],
    )


@jit
def _pixel(rows: Rows, vertices: Floats, index: np.uint32) -> Point:
    u, v, depth = _homogeneous(rows, vertices, index)
    scale = 1.0 / depth
    return u * scale, v * scale


@jit
def _cut(rows: Rows, vertices: Floats, a: np.uint32, b: np.uint32, near: float) -> Point:
    """Where the edge between two vertices meets the near plane; the same number from both faces of the edge."""
    if a > b:
        a, b = b, a
    ua, va, za = _homogeneous(rows, vertices, a)
    ub, vb, zb = _homogeneous(rows, vertices, b)
    share = (near - za) / (zb - za)
    scale = 1.0 / near
    return (ua + (ub - ua) * share) * scale, (va + (vb - va) * share) * scale


@jit
def _draw(lines: Lines, count: int, ends: tuple[Point, Point], winding: int, canvas: Box) -> int:
    """The number of lines after one from end to end was added, if it crosses a row of the canvas."""
    floats, ints = lines
    a, b = ends
    if a[1] > b[1]:
        a, b, winding = b, a, -winding
    first = max(math.ceil(a[1]), canvas[1])
    last = min(math.ceil(b[1]), canvas[3])
    if first >= last:
        return count
    floats[count, 0], floats[count, 1] = a
    floats[count, 2] = (b[0] - a[0]) / (b[1] - a[1])
    ints[count, 0], ints[count, 1], ints[count, 2] = first, last, winding
    return count + 1


@jit
def lines(edges: ContourEdges, frame: Frame, seen: View) -> Lines:
    """The contour in the image: u, v and du/dv of each line's upper end, its rows and what it adds below."""
    rows, vertices, canvas = seen.projection, edges.vertices_M, frame.canvas
    sides = _facing(edges.planes_M, seen.eye_M)
    chosen = _chosen(sides, edges)
    clipped = seen.kind == 1
    capacity = len(chosen) + (len(edges.faces) if clipped else 0)
    found = np.empty((capacity, 3)), np.empty((capacity, 3), dtype=np.int64)
    count = 0
    if clipped:
        count = _clipped_lines(edges, frame, rows, (sides, chosen), found)
    else:
        for e in chosen:
            winding = sides[edges.lefts[e]] + sides[edges.rights[e]]
            a = _pixel(rows, vertices, edges.tails[e])
            b = _pixel(rows, vertices, edges.heads[e])
            count = _draw(found, count, (a, b), winding, canvas)
    return found[0][:count], found[1][:count]


@jit
def _clipped_lines(edges: ContourEdges, frame: Frame, rows: Rows, contour: Contour, lines: Lines) -> int:
    """The number of lines of a mesh that the near plane may cut: its contour before the plane, closed by the cuts."""
    vertices, canvas, near = edges.vertices_M, frame.canvas, frame.near
    sides, chosen = contour
    before = np.empty(len(vertices), dtype=np.bool_)
    for i in range(len(vertices)):
        before[i] = _homogeneous(rows, vertices, np.uint32(i))[2] >= near
    count = 0
    for e in chosen:
        tail, head = edges.tails[e], edges.heads[e]
        if not before[tail] and not before[head]:
            continue
        winding = sides[edges.lefts[e]] + sides[edges.rights[e]]
        a = _pixel(rows, vertices, tail) if before[tail] else _cut(rows, vertices, tail, head, near)
        b = _pixel(rows, vertices, head) if before[head] else _cut(rows, vertices, tail, head, near)
        count = _draw(lines, count, (a, b), winding, canvas)
    for f in range(len(edges.faces)):
        corners = edges.faces[f]
        inside = before[corners[0]] + before[corners[1]] + before[corners[2]]
        if inside in (0, 3):
            continue
        leaving = entering = (0.0, 0.0)
        for k in range(3):
            tail, head = corners[k], corners[(k + 1) % 3]
            if before[tail] and not before[head]:
                leaving = _cut(rows, vertices, tail, head, near)
            if before[head] and not before[tail]:
                entering = _cut(rows, vertices, tail, head, near)
        count = _draw(lines, count, (leaving, entering), sides[f], canvas)
    return count
