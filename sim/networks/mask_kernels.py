"""What is done with every pixel of a mask, compiled by Numba.

Sums have the order that is written here, so that every processor gives the same bits; those of OpenCV's interpolation
depend on the processor.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval.compiled import jit, popcount

Array = NDArray[np.float64]

_ROUNDS = 1.5 * 2.0**52  # added to a small number, leaves no room for its decimals


@jit
def sample(pixels: NDArray[np.uint8], u: Array, v: Array) -> NDArray[np.uint8]:
    """255 times the pixels at all columns u and rows v, rounded, (V, U); beyond the border as at the border.

    Args:
        pixels: 0 and 1, (H, W), pixel i at i.
        u: px, (U,).
        v: px, (V,).
    """
    found = np.empty((len(v), len(u)), dtype=np.uint8)
    left, across = _places(u, pixels.shape[1])
    top, down = _places(v, pixels.shape[0])
    upper, lower = np.empty(len(u)), np.empty(len(u))
    row = -1
    for i in range(len(v)):
        if top[i] != row:
            row = top[i]
            _between(pixels[row], left, across, upper)
            _between(pixels[min(row + 1, len(pixels) - 1)], left, across, lower)
        for j in range(len(u)):
            value = 255.0 * ((lower[j] - upper[j]) * down[i] + upper[j])
            found[i, j] = np.uint8((value + _ROUNDS) - _ROUNDS)
    return found


@jit
def fill_positive(grid: Array, u: Array, v: Array, mask: NDArray[np.bool_]) -> None:
    """Sets a mask where a grid is above 0, at all columns u and rows v of it; beyond its border as at its border.

    Args:
        grid: (H, W), cell i at i.
        u: cells, (U,).
        v: cells, (V,).
        mask: (V, U); changed.
    """
    left, across = _places(u, grid.shape[1])
    top, down = _places(v, grid.shape[0])
    upper, lower = np.empty(len(u)), np.empty(len(u))
    row = -1
    for i in range(len(v)):
        if top[i] != row:
            row = top[i]
            _between(grid[row], left, across, upper)
            _between(grid[min(row + 1, len(grid) - 1)], left, across, lower)
        for j in range(len(u)):
            mask[i, j] = (lower[j] - upper[j]) * down[i] + upper[j] > 0.0


@jit
def signed(
    to_outside: NDArray[np.float32], to_inside: NDArray[np.float32], samples: int, most: int
) -> NDArray[np.float32]:
    """Signed distance to an outline in cells, positive inside, (H, W), at most `most` cells either way.

    Args:
        to_outside: Distance of each sample to the nearest one outside, (H, W), samples; 0 outside.
        to_inside: The same to the nearest one inside.
        samples: How many samples a cell is wide.
        most: cells.
    """
    height, width = to_outside.shape
    found = np.empty((height, width), dtype=np.float32)
    half, per_cell, limit = np.float32(0.5), np.float32(samples), np.float32(most)
    for i in range(height):
        for j in range(width):
            # The outline lies half a sample before the first one beyond it.
            distance = to_outside[i, j] - half if to_outside[i, j] > 0 else half - to_inside[i, j]
            found[i, j] = min(max(distance / per_cell, -limit), limit)
    return found


@jit
def overlap(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> tuple[np.int64, np.int64, np.int64]:
    """How many pixels the one mask has, the other one, and both, as flat arrays of one size."""
    whole = len(one) // 8 * 8
    ones, others = one[:whole].view(np.uint64), other[:whole].view(np.uint64)
    first = second = both = np.int64(0)
    for i in range(len(ones)):
        first += np.int64(popcount(ones[i]))
        second += np.int64(popcount(others[i]))
        both += np.int64(popcount(ones[i] & others[i]))
    for i in range(whole, len(one)):
        first += one[i]
        second += other[i]
        both += one[i] and other[i]
    return first, second, both


@jit
def histogram(numbers: NDArray[np.int8], mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """How many pixels of a mask have each number from 0 on, (128,), as flat arrays of one size."""
    counts = np.zeros(128, dtype=np.int64)
    words = mask[: len(mask) // 8 * 8].view(np.uint64)
    for i in range(len(words) + 1):
        if i < len(words) and words[i] == 0:
            continue
        for j in range(8 * i, min(8 * i + 8, len(mask))):
            if mask[j] and numbers[j] >= 0:
                counts[numbers[j]] += 1
    return counts


@jit
def _places(places: Array, count: int) -> tuple[NDArray[np.int64], Array]:
    """The whole number below each place, and the share of the way to the next one."""
    below, share = np.empty(len(places), dtype=np.int64), np.empty(len(places))
    for i in range(len(places)):
        below[i] = min(max(math.floor(places[i]), 0), count - 1)
        share[i] = min(max(places[i] - below[i], 0.0), 1.0)
    return below, share


@jit
def _between(line: NDArray[np.generic], below: NDArray[np.int64], share: Array, found: Array) -> None:
    """The values of a line at places between them, linear; at the last one its own."""
    last = len(line) - 1
    for i in range(len(below)):
        value = float(line[below[i]])
        found[i] = (float(line[min(below[i] + 1, last)]) - value) * share[i] + value
