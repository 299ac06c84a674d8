"""The silhouettes of many poses, compiled by Numba; `maskval/rendering/reference.py` is the same in NumPy.

Both give the same integers: every float is computed by the same operations in the same order, and nothing here allows
LLVM to fuse them. All jitted functions stand in this one module, because Numba's cache does not see an edit in a
callee elsewhere; for the same reason it imports no constant. `popcount` alone is from elsewhere: one instruction.
Indices are unsigned where they are read from arrays: a signed one costs a look whether it is negative.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import jit, popcount
from maskval.contour import ContourEdges
from maskval.rendering.views import Views

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Point = tuple[float, float]
Lines = tuple[Floats, Ints]
Contour = tuple[NDArray[np.int8], NDArray[np.uint32]]  # sides and chosen edges

# A row of more crossings is sorted by counting: the squares of insertion sort then cost more than a walk along the row.
BUSY_ROW = 24
# A crossing is one sortable number: its column, and below it what it adds to the winding number, made positive.
DELTA_BITS = 32
DELTA_ZERO = 1 << 31


@jit
def _facing(planes: NDArray[np.float32], eye: NDArray[np.float32]) -> NDArray[np.int8]:
    """The 2 F + 1 sides: the signs of the faces, their negatives, and 0."""
    count = planes.shape[1]
    nx, ny, nz, offset = planes[0], planes[1], planes[2], planes[3]
    x, y, z = eye[0], eye[1], eye[2]
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
    """The edges of the contour: those whose two sides do not cancel."""
    lefts, rights = edges.lefts, edges.rights
    chosen = np.empty(len(lefts), dtype=np.uint32)
    count = 0
    for e in range(len(lefts)):
        # Without a branch: on a crumpled mesh, nobody could predict it.
        chosen[count] = e
        count += sides[lefts[e]] + sides[rights[e]] != 0
    return chosen[:count]


@jit
def _homogeneous(projection: Floats, vertices: Floats, index: np.uint32) -> tuple[float, float, float]:
    x, y, z = vertices[index, 0], vertices[index, 1], vertices[index, 2]
    return (
        projection[0, 0] * x + projection[0, 1] * y + projection[0, 2] * z + projection[0, 3],
        projection[1, 0] * x + projection[1, 1] * y + projection[1, 2] * z + projection[1, 3],
        projection[2, 0] * x + projection[2, 1] * y + projection[2, 2] * z + projection[2, 3],
    )


@jit
def _pixel(projection: Floats, vertices: Floats, index: np.uint32) -> Point:
    u, v, depth = _homogeneous(projection, vertices, index)
    scale = 1.0 / depth
    return u * scale, v * scale


@jit
def _cut(projection: Floats, vertices: Floats, a: np.uint32, b: np.uint32, near: float) -> Point:
    """Where the edge between two vertices meets the near plane; the same number from both faces of the edge."""
    if a > b:
        a, b = b, a
    ua, va, za = _homogeneous(projection, vertices, a)
    ub, vb, zb = _homogeneous(projection, vertices, b)
    share = (near - za) / (zb - za)
    scale = 1.0 / near
    return (ua + (ub - ua) * share) * scale, (va + (vb - va) * share) * scale


@jit
def _draw(lines: Lines, count: int, ends: tuple[Point, Point], winding: int, canvas: Ints) -> int:
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
def _lines(edges: ContourEdges, view: Views, n: int) -> Lines:
    """The contour in the image: u, v and du/dv of each line's upper end, its rows and what it adds below."""
    projection, vertices, canvas = view.projections[n], edges.vertices_M, view.canvas
    sides = _facing(edges.planes_M, view.eyes_M[n])
    chosen = _chosen(sides, edges)
    clipped = view.kinds[n] == 1
    capacity = len(chosen) + (len(edges.faces) if clipped else 0)
    lines = np.empty((capacity, 3)), np.empty((capacity, 3), dtype=np.int64)
    count = 0
    if clipped:
        count = _clipped_lines(edges, view, n, (sides, chosen), lines)
    else:
        for e in chosen:
            winding = sides[edges.lefts[e]] + sides[edges.rights[e]]
            a = _pixel(projection, vertices, edges.tails[e])
            b = _pixel(projection, vertices, edges.heads[e])
            count = _draw(lines, count, (a, b), winding, canvas)
    return lines[0][:count], lines[1][:count]


@jit
def _clipped_lines(edges: ContourEdges, view: Views, n: int, contour: Contour, lines: Lines) -> int:
    """The number of lines of a mesh that the near plane may cut: its contour before the plane, closed by the cuts."""
    projection, vertices, canvas, near = view.projections[n], edges.vertices_M, view.canvas, view.near
    sides, chosen = contour
    before = np.empty(len(vertices), dtype=np.bool_)
    for i in range(len(vertices)):
        before[i] = _homogeneous(projection, vertices, np.uint32(i))[2] >= near
    count = 0
    for e in chosen:
        tail, head = edges.tails[e], edges.heads[e]
        if not before[tail] and not before[head]:
            continue
        winding = sides[edges.lefts[e]] + sides[edges.rights[e]]
        a = _pixel(projection, vertices, tail) if before[tail] else _cut(projection, vertices, tail, head, near)
        b = _pixel(projection, vertices, head) if before[head] else _cut(projection, vertices, tail, head, near)
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
                leaving = _cut(projection, vertices, tail, head, near)
            if before[head] and not before[tail]:
                entering = _cut(projection, vertices, tail, head, near)
        count = _draw(lines, count, (leaving, entering), sides[f], canvas)
    return count


@jit
def _sort_row(keys: Ints, begin: int, end: int) -> int:
    """Sorts the crossings of a row; the end of what is left of them."""
    if end - begin <= BUSY_ROW:
        for i in range(begin + 1, end):
            key = keys[i]
            j = i
            while j > begin and keys[j - 1] > key:
                keys[j] = keys[j - 1]
                j -= 1
            keys[j] = key
        return end
    left = keys[begin:end].min() >> DELTA_BITS
    tally = np.zeros((keys[begin:end].max() >> DELTA_BITS) - left + 1, dtype=np.int64)
    for i in range(begin, end):
        tally[(keys[i] >> DELTA_BITS) - left] += (keys[i] & ((1 << DELTA_BITS) - 1)) - DELTA_ZERO
    kept = begin
    for column in range(len(tally)):
        if tally[column] != 0:
            keys[kept] = ((column + left) << DELTA_BITS) + tally[column] + DELTA_ZERO
            kept += 1
    return kept


@jit
def _crossings(lines: Lines, top: int, bottom: int, canvas: Ints) -> tuple[Ints, Ints]:
    """Where the lines cross the rows, row by row, and where each row ends in that."""
    floats, ints = lines
    change = np.zeros(bottom - top + 1, dtype=np.int64)
    for i in range(len(ints)):
        change[ints[i, 0] - top] += 1
        change[ints[i, 1] - top] -= 1
    ends = np.empty(bottom - top, dtype=np.int64)
    total = crossing = 0
    for row in range(bottom - top):
        crossing += change[row]
        ends[row] = total
        total += crossing
    keys = np.empty(total, dtype=np.int64)
    left, right = float(canvas[0]), float(canvas[2])
    for i in range(len(ints)):
        u, v, slope = floats[i, 0], floats[i, 1], floats[i, 2]
        for row in range(ints[i, 0], ints[i, 1]):
            column = math.ceil(min(max(u + (row - v) * slope, left), right))
            keys[ends[row - top]] = (column << DELTA_BITS) + ints[i, 2] + DELTA_ZERO
            ends[row - top] += 1
    return keys, ends


@jit
def spans(edges: ContourEdges, view: Views, n: int) -> Ints:
    """The silhouette of view n as rows, first columns and columns after the last, (S, 3), on the whole canvas."""
    lines = _lines(edges, view, n)
    if view.kinds[n] == 2 or len(lines[1]) == 0:
        return np.empty((0, 3), dtype=np.int64)
    top, bottom = lines[1][:, 0].min(), lines[1][:, 1].max()
    keys, ends = _crossings(lines, top, bottom, view.canvas)
    found = np.empty((len(keys) // 2, 3), dtype=np.int64)
    count = begin = 0
    for row in range(bottom - top):
        end = ends[row]
        winding = start = 0
        for i in range(begin, _sort_row(keys, begin, end)):
            column = keys[i] >> DELTA_BITS
            if winding == 0:
                start = column
            winding += (keys[i] & ((1 << DELTA_BITS) - 1)) - DELTA_ZERO
            if winding == 0 and column > start:
                found[count, 0], found[count, 1], found[count, 2] = row + top, start, column
                count += 1
        begin = end
    return found[:count]


@jit
def _overlap(found: Ints, words: NDArray[np.uint64]) -> np.int64:
    """Pixels of the spans, which lie inside the image, that are also in a packed mask (H, words)."""
    total = np.uint64(0)
    ones = np.uint64(0xFFFFFFFFFFFFFFFF)
    for i in range(len(found)):
        row, start, last = found[i, 0], found[i, 1], found[i, 2] - 1
        first_word, last_word = start >> 6, last >> 6
        head = ones << np.uint64(start & 63)
        tail = ones >> np.uint64(63 - (last & 63))
        if first_word == last_word:
            total += popcount(words[row, first_word] & head & tail)
        else:
            total += popcount(words[row, first_word] & head) + popcount(words[row, last_word] & tail)
            for word in range(first_word + 1, last_word):
                total += popcount(words[row, word])
    return np.int64(total)


@jit
def _clip(found: Ints, width: int, height: int) -> Ints:
    """The spans inside the image, moved to the front."""
    kept = 0
    for i in range(len(found)):
        row, start, stop = found[i, 0], max(found[i, 1], 0), min(found[i, 2], width)
        if 0 <= row < height and start < stop:
            found[kept, 0], found[kept, 1], found[kept, 2] = row, start, stop
            kept += 1
    return found[:kept]


@jit
def _area(found: Ints) -> int:
    total = 0
    for i in range(len(found)):
        total += found[i, 2] - found[i, 1]
    return total


@jit
def measure(edges: ContourEdges, view: Views, words: NDArray[np.uint64], paired: bool) -> tuple[Ints, Ints]:
    """Areas on the canvas and in the image, (N, 2), and overlaps with the masks, (N, K) or (N, 1) when paired."""
    count = len(view.kinds)
    areas = np.empty((count, 2), dtype=np.int64)
    overlaps = np.empty((count, 1 if paired else len(words)), dtype=np.int64)
    for n in range(count):
        found = spans(edges, view, n)
        areas[n, 0] = _area(found)
        found = _clip(found, view.width, view.height)
        areas[n, 1] = _area(found)
        for k in range(overlaps.shape[1]):
            overlaps[n, k] = _overlap(found, words[n if paired else k])
    return areas, overlaps


@jit
def draw(edges: ContourEdges, view: Views, mask: NDArray[np.bool_]) -> int:
    """Sets the pixels of the first view's silhouette in a mask; its area on the canvas."""
    found = spans(edges, view, 0)
    area = _area(found)
    for row, start, stop in _clip(found, view.width, view.height):
        mask[row, start:stop] = True
    return area
