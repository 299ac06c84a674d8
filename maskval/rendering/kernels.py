"""The silhouettes of many poses, compiled by Numba; `maskval/rendering/reference.py` is the same in NumPy.

Both give the same integers: every float is computed by the same operations in the same order, and nothing here allows
LLVM to fuse them. Numba's cache does not see an edit in a callee elsewhere (`lines.py`, `lens.py`, `views.py`): delete
`__pycache__` after one. For the same reason this imports no constant.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import jit, popcount
from maskval.contour import ContourEdges
from maskval.rendering.lens import Box, Floats
from maskval.rendering.lines import Ints, Lines, lines, view
from maskval.rendering.views import Frame

# A row of more crossings is sorted by counting: the squares of insertion sort then cost more than a walk along the row.
BUSY_ROW = 24
# A crossing is one sortable number: its column, and below it what it adds to the winding number, made positive.
DELTA_BITS = 32
DELTA_ZERO = 1 << 31


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
def _crossings(contour: Lines, top: int, bottom: int, canvas: Box) -> tuple[Ints, Ints]:
    """Where the lines cross the rows, row by row, and where each row ends in that."""
    floats, ints = contour
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
def spans(edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats) -> Ints:
    """The silhouette of a mesh as rows, first columns and columns after the last, (S, 3), on the whole canvas.

    Args:
        edges: The mesh.
        frame: The camera.
        rotation: R_CO, (3, 3).
        translation: p_CO, (3,), metres.
    """
    seen = view(edges, frame, rotation, translation)
    contour = lines(edges, frame, seen)
    if seen.kind == 2 or len(contour[1]) == 0:
        return np.empty((0, 3), dtype=np.int64)
    top, bottom = contour[1][:, 0].min(), contour[1][:, 1].max()
    keys, ends = _crossings(contour, top, bottom, frame.canvas)
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
def _clip(found: Ints, frame: Frame) -> tuple[Ints, int, int]:
    """The spans inside the image, moved to the front; the pixels of all, and of these."""
    kept = whole = seen = 0
    for i in range(len(found)):
        row, start, stop = found[i, 0], found[i, 1], found[i, 2]
        whole += stop - start
        start, stop = max(start, 0), min(stop, frame.width)
        if 0 <= row < frame.height and start < stop:
            seen += stop - start
            found[kept, 0], found[kept, 1], found[kept, 2] = row, start, stop
            kept += 1
    return found[:kept], whole, seen


@jit
def measure(
    edges: ContourEdges,
    frame: Frame,
    poses: tuple[Floats, Floats],
    masks: tuple[NDArray[np.uint64], Ints],
    paired: bool,
) -> tuple[Floats, Floats]:
    """Intersections over union of silhouettes and masks, (N, K) or (N, 1) when paired, and visibilities, (N,).

    Args:
        edges: The mesh.
        frame: The camera.
        poses: R_CO, (N, 3, 3), and p_CO, (N, 3), metres.
        masks: Words, (K, H, words), and areas, (K,), of packed masks.
        paired: Compare pose i with mask i only.
    """
    (rotations, translations), (words, areas) = poses, masks
    iou = np.empty((len(rotations), 1 if paired else len(words)))
    visibility = np.empty(len(rotations))
    for n in range(len(rotations)):
        found, whole, seen = _clip(spans(edges, frame, rotations[n], translations[n]), frame)
        visibility[n] = seen / max(whole, 1)
        for i in range(iou.shape[1]):
            k = n if paired else i
            overlap = _overlap(found, words[k])
            iou[n, i] = overlap / max(seen + areas[k] - overlap, 1)
    return iou, visibility


@jit
def areas(edges: ContourEdges, frame: Frame, poses: tuple[Floats, Floats]) -> Ints:
    """Pixels of silhouettes on the canvas, and of their parts in the image, (N, 2); arguments as of `measure`."""
    rotations, translations = poses
    counts = np.empty((len(rotations), 2), dtype=np.int64)
    for n in range(len(rotations)):
        _, counts[n, 0], counts[n, 1] = _clip(spans(edges, frame, rotations[n], translations[n]), frame)
    return counts


@jit
def draw(edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats, mask: NDArray[np.bool_]) -> int:
    """Sets the pixels of a silhouette in a mask; its area on the canvas."""
    found, whole, _ = _clip(spans(edges, frame, rotation, translation), frame)
    for row, start, stop in found:
        mask[row, start:stop] = True
    return whole
