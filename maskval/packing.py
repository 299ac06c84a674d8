"""Masks packed to bits in one pass, compiled by Numba; `maskval/masks.py` does the same in NumPy."""

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import above, jit, popcount


@jit
def pack(pixels: NDArray[np.uint8], shape: tuple[int, int, int]) -> tuple[NDArray[np.uint64], NDArray[np.int64], bool]:
    """The words and areas of masks, see `PackedMasks`, and whether all pixels are 0 or 1.

    Args:
        pixels: One after the other, row by row; what is not 0 is counted as 1.
        shape: K, H and W.
    """
    count, height, width = shape
    words = np.empty((count, height, (width + 63) // 64), dtype=np.uint64)
    areas = np.empty(count, dtype=np.int64)
    whole, rest = width // 64, width % 64
    begin, others = 0, np.uint64(0)
    for k in range(count):
        area = np.uint64(0)
        for row in range(height):
            for w in range(whole):
                word = above(pixels, begin + 64 * w, 0)
                others |= above(pixels, begin + 64 * w, 1)
                words[k, row, w] = word
                area += popcount(word)
            if rest:
                word, other = _rest(pixels, begin + width, rest)
                words[k, row, whole] = word
                others |= other
                area += popcount(word)
            begin += width
        areas[k] = area
    return words, areas, others == 0


@jit
def _rest(pixels: NDArray[np.uint8], end: int, count: int) -> tuple[np.uint64, np.uint64]:
    """Which of the pixels before the end, fewer than 64, are not 0, and which are greater than 1."""
    if end >= 64:  # what lies before them is read, too, and pushed out
        shift = np.uint64(64 - count)
        return above(pixels, end - 64, 0) >> shift, above(pixels, end - 64, 1) >> shift
    word = other = np.uint64(0)
    for j in range(count):
        pixel = pixels[end - count + j]
        word |= np.uint64(pixel > 0) << np.uint64(j)
        other |= np.uint64(pixel > 1) << np.uint64(j)
    return word, other
