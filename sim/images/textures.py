"""Random pictures: surfaces for bodies and rooms, and heterogeneous backgrounds to paste bodies over."""

import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

Picture = NDArray[np.uint8]
Pattern = NDArray[np.float32]  # (H, W) in [0, 1], how far a pixel is from one colour to another

_PATCHES = (8, 40)  # things in a background
_SOFT_PATCH = 0.3  # share of them that are out of focus
_GRAIN_PX = 256  # of the longer side: grain is no finer than a 64th of it, and is enlarged from there
# Of the normal distribution, by 8 bits, with a variance of 1.
_QUANTILES = ndtri((np.arange(256) + 0.5) / 256).astype(np.float32)
_QUANTILES /= _QUANTILES.std()


def random_color(rng: np.random.Generator) -> NDArray[np.float32]:
    """A colour, (3,) in [0, 1]: any brightness, more often pale than vivid."""
    grey, pale = rng.uniform(0.08, 0.95), rng.uniform() ** 2
    color: NDArray[np.float32] = np.clip(grey + pale * rng.uniform(-0.6, 0.6, 3), 0.02, 1.0).astype(np.float32)
    return color


def noise(shape: tuple[int, ...], deviation: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Nearly normal noise: 256 values, at most 2.9 deviations, in a tenth of the time of a generator's own."""
    bits = np.frombuffer(rng.bytes(math.prod(shape)), dtype=np.uint8).reshape(shape)
    return cv2.LUT(bits, np.float32(deviation) * _QUANTILES).astype(np.float32, copy=False)


def between(pattern: NDArray[Any], one: NDArray[Any], other: NDArray[Any]) -> Picture:
    """The picture whose pixels are so far from one colour to another, (H, W, 3)."""
    steps = np.clip(255 * pattern, 0, 255).astype(np.uint8)
    colors = one + np.linspace(0, 1, 256)[:, None] * (other - one)
    table = np.clip(np.rint(255 * colors), 0, 255).astype(np.uint8)[None]
    picture: Picture = cv2.LUT(cv2.merge((steps, steps, steps)), table)
    return picture


def texture(height: int, width: int, rng: np.random.Generator) -> Picture:
    """A surface of two colours, (H, W, 3): grained, checked, striped, speckled or nearly plain."""
    pattern = _PATTERNS[rng.integers(len(_PATTERNS))](height, width, rng)
    return between(pattern, random_color(rng), random_color(rng))


def background(height: int, width: int, rng: np.random.Generator) -> Picture:
    """A random background, (H, W, 3): patches of all kinds and sizes under uneven light."""
    picture = texture(height, width, rng)
    for _ in range(rng.integers(*_PATCHES)):
        _add_patch(picture, rng)
    light = 0.6 + 0.7 * _grain(height, width, rng, coarsest=1.5)
    return cv2.multiply(picture, cv2.merge((light, light, light)), dtype=cv2.CV_8U).astype(np.uint8, copy=False)


def _add_patch(picture: Picture, rng: np.random.Generator) -> None:
    """Lays a patch of one colour or texture over the picture, sharp or out of focus."""
    height, width, _ = picture.shape
    corners = _outline(height, width, rng)
    blur_px = rng.uniform(1.0, 8.0) if rng.uniform() < _SOFT_PATCH else 0.0
    margin = math.ceil(3 * blur_px)
    low = np.maximum(corners.min(axis=0) - margin, 0)
    high = np.minimum(corners.max(axis=0) + margin + 1, (width, height))
    textured, color = rng.uniform() < 0.6, random_color(rng)
    if (high <= low).any():
        return
    window = picture[low[1] : high[1], low[0] : high[0]]
    rows, columns, _ = window.shape
    if not (textured or blur_px):
        cv2.fillPoly(window, [corners - low], np.rint(255 * color).tolist())
        return
    mask = np.zeros((rows, columns), dtype=np.uint8)
    cv2.fillPoly(mask, [corners - low], 255)
    filling = texture(rows, columns, rng) if textured else np.full_like(window, np.rint(255 * color))
    if blur_px:
        share = cv2.blur(mask, (margin + 1, margin + 1)).astype(np.float32) / 255
        window[:] = cv2.blendLinear(filling, np.ascontiguousarray(window), share, 1 - share)
    else:
        cv2.copyTo(filling, mask, window)


def _outline(height: int, width: int, rng: np.random.Generator) -> NDArray[np.int32]:
    """The corners (u, v) of a random polygon, or of an ellipse by many corners, (N, 2) px."""
    center = rng.uniform((0, 0), (width, height))
    size = 0.5 * max(height, width) * rng.uniform(0.05, 1.0) ** 2 + 3.0
    if rng.uniform() < 0.4:
        axes = (int(size), int(size * rng.uniform(0.2, 1.0)) + 1)
        middle = (int(center[0]), int(center[1]))
        return np.asarray(cv2.ellipse2Poly(middle, axes, int(rng.integers(180)), 0, 360, 5), dtype=np.int32)
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 8)))
    corners = center + size * np.column_stack((np.cos(angles), np.sin(angles)))
    return np.rint(corners).astype(np.int32)


def _grain(height: int, width: int, rng: np.random.Generator, coarsest: float = 4.0) -> Pattern:
    """Value noise: octaves of random grids, each twice as fine and at a random lower weight."""
    longest = max(height, width)
    size = tuple(max(2, math.ceil(min(1.0, _GRAIN_PX / longest) * side)) for side in (width, height))
    total = np.zeros(size[::-1], dtype=np.float32)
    cells, weight = coarsest, 1.0
    while cells < 64:
        rows, columns = (max(2, round(cells * side / longest) + 1) for side in (height, width))
        grid = rng.uniform(-1, 1, (rows, columns)).astype(np.float32)
        total += weight * cv2.resize(grid, size, interpolation=cv2.INTER_CUBIC)
        cells, weight = 2 * cells, weight * rng.uniform(0.3, 0.8)
    low, high = float(total.min()), float(total.max())
    return cv2.resize((total - low) / (high - low), (width, height)).astype(np.float32, copy=False)


def _plain(height: int, width: int, rng: np.random.Generator) -> Pattern:
    return 0.15 * _grain(height, width, rng)


def _wave(height: int, width: int, angle: float, period: float) -> Pattern:
    """A sine of the place along a direction (rad); the period is a share of the longer side."""
    turns = 2 * np.pi / (period * max(height, width))
    across = np.arange(width, dtype=np.float32) * np.float32(turns * np.cos(angle))
    down = (np.arange(height, dtype=np.float32) * np.float32(turns * np.sin(angle)))[:, None]
    wave: Pattern = np.sin(across) * np.cos(down) + np.cos(across) * np.sin(down)
    return wave


def _direction(rng: np.random.Generator) -> tuple[float, float]:
    """Angle (rad) and period of a wave."""
    return rng.uniform(0, np.pi), 0.5 ** rng.uniform(1.5, 5.0)


def _stripes(height: int, width: int, rng: np.random.Generator) -> Pattern:
    pattern: Pattern = np.clip(0.5 + rng.uniform(0.5, 5.0) * _wave(height, width, *_direction(rng)), 0, 1)
    return pattern


def _checks(height: int, width: int, rng: np.random.Generator) -> Pattern:
    angle, period = _direction(rng)
    one, other = (_wave(height, width, angle + turn, period) for turn in (0, np.pi / 2))
    pattern: Pattern = np.clip(0.5 + 5.0 * one * other, 0, 1)
    return pattern


def _speckles(height: int, width: int, rng: np.random.Generator) -> Pattern:
    grain = _grain(height, width, rng, coarsest=12.0)
    pattern: Pattern = np.clip(8.0 * (grain - rng.uniform(0.4, 0.7)), 0, 1)
    return pattern


_PATTERNS: tuple[Callable[[int, int, np.random.Generator], Pattern], ...] = (
    _plain,
    _grain,
    _stripes,
    _checks,
    _speckles,
)
