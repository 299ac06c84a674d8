"""The silhouettes of many poses in NumPy: the definition that `maskval/rendering/kernels.py` repeats faster."""

import numpy as np
from numpy.typing import NDArray

from maskval.contour import ContourEdges
from maskval.rendering.lens import Box, Rows, centred, eye, projection
from maskval.rendering.views import CLIPPED, UNSEEN, Frame, View, kind

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def spans(edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats) -> Ints:
    """See `kernels.spans`."""
    X_CM = centred(rotation, translation, edges.centre_O)
    view = View(projection(frame.lens, X_CM), eye(X_CM), kind(X_CM[2][3], edges.radius, frame.near))
    if view.kind == UNSEEN:
        return np.empty((0, 3), dtype=np.int64)
    return _sweep(*_lines(edges, frame, view), frame.canvas)


def measure(
    edges: ContourEdges,
    frame: Frame,
    poses: tuple[Floats, Floats],
    masks: tuple[NDArray[np.uint64], Ints],
    paired: bool,
) -> tuple[Floats, Floats]:
    """See `kernels.measure`."""
    words, areas = masks
    iou = np.empty((len(poses[0]), 1 if paired else len(words)))
    visibility = np.empty(len(iou))
    for n, (rotation, translation) in enumerate(zip(*poses, strict=True)):
        whole = spans(edges, frame, rotation, translation)
        seen = _clip(whole, frame)
        chosen = slice(n, n + 1) if paired else slice(None)
        overlaps = _overlaps(seen, words[chosen])
        iou[n] = overlaps / np.maximum(_area(seen) + areas[chosen] - overlaps, 1)
        visibility[n] = _area(seen) / max(_area(whole), 1)
    return iou, visibility


def areas(edges: ContourEdges, frame: Frame, poses: tuple[Floats, Floats]) -> Ints:
    """See `kernels.areas`."""
    wholes = [spans(edges, frame, rotation, translation) for rotation, translation in zip(*poses, strict=True)]
    return np.array([(_area(whole), _area(_clip(whole, frame))) for whole in wholes], dtype=np.int64).reshape(-1, 2)


def draw(edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats, mask: NDArray[np.bool_]) -> int:
    """See `kernels.draw`."""
    whole = spans(edges, frame, rotation, translation)
    row, start, stop = _clip(whole, frame).T
    pixel, owner = steps(start, stop)
    mask[row[owner], pixel] = True
    return _area(whole)


def _lines(edges: ContourEdges, frame: Frame, view: View) -> tuple[Floats, Floats, Ints]:
    """Both ends (u, v) of the contour's lines, (L, 2) each, and what each adds to the winding number."""
    nx, ny, nz, offset = edges.planes_M
    x, y, z = np.array(view.eye_M, dtype=np.float32)
    front = np.where(nx * x + ny * y + nz * z + offset > 0, 1, -1).astype(np.int8)
    sides = np.concatenate((front, -front, np.zeros(1, dtype=np.int8)))
    windings = sides[edges.lefts] + sides[edges.rights]
    chosen = np.flatnonzero(windings)
    tails, heads, windings = edges.tails[chosen], edges.heads[chosen], windings[chosen].astype(np.int64)
    if view.kind == CLIPPED:
        return _clipped_lines(edges, (view.projection, frame.near), (tails, heads, windings), front)
    ends = homogeneous(view.projection, edges.vertices_M[np.concatenate((tails, heads))])
    pixels = ends[:, :2] * (1.0 / ends[:, 2:])
    return pixels[: len(tails)], pixels[len(tails) :], windings


def _clipped_lines(
    edges: ContourEdges,
    cut: tuple[Rows, float],
    contour: tuple[NDArray[np.uint32], NDArray[np.uint32], Ints],
    front: NDArray[np.int8],
) -> tuple[Floats, Floats, Ints]:
    """The lines of a mesh that the near plane may cut: its contour before the plane, closed by the cuts."""
    rows, near = cut
    points = homogeneous(rows, edges.vertices_M)
    before = points[:, 2] >= near

    def end(vertices: NDArray[np.uint32], others: NDArray[np.uint32]) -> Floats:
        """Pixels of the vertices, or where the edges to the others meet the plane."""
        a, b = points[np.minimum(vertices, others)], points[np.maximum(vertices, others)]
        with np.errstate(divide="ignore", invalid="ignore"):  # an edge that is not cut has no share
            share = (near - a[:, 2:]) / (b[:, 2:] - a[:, 2:])
            cut = (a[:, :2] + (b[:, :2] - a[:, :2]) * share) * (1.0 / near)
            whole = points[vertices, :2] * (1.0 / points[vertices, 2:])
        return np.where(before[vertices, None], whole, cut)

    tails, heads, windings = contour
    seen = before[tails] | before[heads]
    tails, heads, windings = tails[seen], heads[seen], windings[seen]

    straddling = np.flatnonzero(np.isin(before[edges.faces].sum(axis=1), (1, 2)))
    starts, stops = edges.faces[straddling], np.roll(edges.faces[straddling], -1, axis=1)
    leaving = before[starts] & ~before[stops]
    entering = ~before[starts] & before[stops]
    return (
        np.concatenate((end(tails, heads), end(stops[leaving], starts[leaving]))),
        np.concatenate((end(heads, tails), end(starts[entering], stops[entering]))),
        np.concatenate((windings, front[straddling])),
    )


def homogeneous(rows: Rows, vertices_M: Floats) -> Floats:
    """Vertices in homogeneous pixels, (V, 3)."""
    # Written out, because a matrix product may fuse or reorder what the other kernel does not.
    x, y, z = vertices_M.T
    return np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in rows], axis=1)


def _sweep(a: Floats, b: Floats, windings: Ints, canvas: Box) -> Ints:
    """The spans over which the lines' winding number is not zero."""
    left, top, right, bottom = canvas
    down = a[:, 1] <= b[:, 1]
    upper, lower = np.where(down[:, None], a, b), np.where(down[:, None], b, a)
    first = np.maximum(np.ceil(upper[:, 1]).astype(np.int64), top)
    last = np.minimum(np.ceil(lower[:, 1]).astype(np.int64), bottom)
    crossing = np.flatnonzero(first < last)
    upper, lower, down, windings = upper[crossing], lower[crossing], down[crossing], windings[crossing]
    slope = (lower[:, 0] - upper[:, 0]) / (lower[:, 1] - upper[:, 1])

    row, owner = steps(first[crossing], last[crossing])
    u = upper[owner, 0] + (row - upper[owner, 1]) * slope[owner]
    column = np.ceil(np.clip(u, left, right)).astype(np.int64)
    order = np.argsort(row * (right - left + 1) + column - left)
    row, column = row[order], column[order]
    # The windings of a row add up to nothing, so that the sum over all rows starts each of them at zero.
    winding = np.cumsum(np.where(down, windings, -windings)[owner[order]])
    inside = np.flatnonzero((winding[:-1] != 0) & (column[1:] > column[:-1]))
    return np.stack((row[inside], column[inside], column[inside + 1]), axis=1)


def steps(start: Ints, stop: Ints) -> tuple[Ints, Ints]:
    """All whole numbers of each range [start, stop), one range after the other, and the range that each is of."""
    lengths = stop - start
    owner = np.repeat(np.arange(len(start)), lengths)
    before = np.cumsum(lengths) - lengths
    return np.arange(len(owner)) - (before - start)[owner], owner


def _clip(found: Ints, frame: Frame) -> Ints:
    row = found[:, 0]
    start, stop = np.maximum(found[:, 1], 0), np.minimum(found[:, 2], frame.width)
    seen = (row >= 0) & (row < frame.height) & (start < stop)
    return np.stack((row[seen], start[seen], stop[seen]), axis=1)


def _area(found: Ints) -> int:
    return int((found[:, 2] - found[:, 1]).sum())


def _overlaps(found: Ints, words: NDArray[np.uint64]) -> Ints:
    """Pixels of the spans, which lie inside the image, that are also in each packed mask, (K,)."""
    row, start, stop = found.T
    word, owner = steps(start >> 6, ((stop - 1) >> 6) + 1)
    ones = np.uint64(0xFFFFFFFFFFFFFFFF)
    head = np.maximum(start[owner] - 64 * word, 0).astype(np.uint64)
    tail = np.maximum(64 * word + 64 - stop[owner], 0).astype(np.uint64)
    bits = (ones << head) & (ones >> tail)
    overlaps: Ints = np.bitwise_count(words[:, row[owner], word] & bits).sum(axis=1, dtype=np.int64)
    return overlaps
