"""Random pictures: surfaces for bodies and rooms, and heterogeneous backgrounds to paste bodies over."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Pattern = NDArray[np.float32]  # (H, W) in [0, 1], how far a pixel is from one colour to another

_PATCHES = (8, 40)  # things in a background
_SOFT_PATCH = 0.3  # share of them that are out of focus


def random_color(rng: np.random.Generator) -> NDArray[np.float32]:
    """A colour, (3,) in [0, 1]: any brightness, more often pale than vivid."""
    grey, pale = rng.uniform(0.08, 0.95), rng.uniform() ** 2
    color: NDArray[np.float32] = np.clip(grey + pale * rng.uniform(-0.6, 0.6, 3), 0.02, 1.0).astype(np.float32)
    return color


def texture(height: int, width: int, rng: np.random.Generator) -> Picture:
    """A surface of two colours, (H, W, 3): grained, checked, striped, speckled or nearly plain."""
    pattern = _PATTERNS[rng.integers(len(_PATTERNS))](height, width, rng)
    pattern = np.clip(pattern + rng.normal(0.0, 0.03, pattern.shape).astype(np.float32), 0.0, 1.0)
    one, other = random_color(rng), random_color(rng)
    return np.rint(255 * (one + pattern[..., None] * (other - one))).astype(np.uint8)


def background(height: int, width: int, rng: np.random.Generator) -> Picture:
    """A random background, (H, W, 3): patches of all kinds and sizes under uneven light."""
    picture = texture(height, width, rng)
    for _ in range(rng.integers(*_PATCHES)):
        mask = _patch(height, width, rng)
        if rng.uniform() < _SOFT_PATCH:
            mask = cv2.GaussianBlur(mask, (0, 0), rng.uniform(1.0, 8.0)).astype(np.float32, copy=False)
        left, top, across, down = cv2.boundingRect((mask > 0).astype(np.uint8))
        window = (slice(top, top + down), slice(left, left + across))
        share, under = mask[window][..., None], picture[window].astype(np.float32)
        textured = rng.uniform() < 0.6 and across > 0
        filling = texture(down, across, rng) if textured else 255 * random_color(rng)
        picture[window] = np.rint(under + share * (filling - under)).astype(np.uint8)
    light = 0.6 + 0.7 * _grain(height, width, rng, coarsest=1.5)
    return np.clip(picture * light[..., None], 0, 255).astype(np.uint8)


def _patch(height: int, width: int, rng: np.random.Generator) -> Pattern:
    """1 inside of a random ellipse or polygon."""
    mask = np.zeros((height, width), dtype=np.float32)
    center = rng.uniform((0, 0), (width, height))
    size = 0.5 * max(height, width) * rng.uniform(0.05, 1.0) ** 2 + 3.0
    if rng.uniform() < 0.4:
        axes = (int(size), int(size * rng.uniform(0.2, 1.0)) + 1)
        cv2.ellipse(mask, (int(center[0]), int(center[1])), axes, float(rng.uniform(0, 180)), 0, 360, 1.0, cv2.FILLED)
        return mask
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 8)))
    corners = center + size * np.column_stack((np.cos(angles), np.sin(angles)))
    cv2.fillPoly(mask, [np.rint(corners).astype(np.int32)], 1.0)
    return mask


def _grain(height: int, width: int, rng: np.random.Generator, coarsest: float = 4.0) -> Pattern:
    """Value noise: octaves of random grids, each twice as fine and at a random lower weight."""
    total = np.zeros((height, width), dtype=np.float32)
    cells, weight = coarsest, 1.0
    while cells < 64:
        rows, columns = (max(2, round(cells * side / max(height, width)) + 1) for side in (height, width))
        grid = rng.uniform(-1, 1, (rows, columns)).astype(np.float32)
        total += weight * cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC)
        cells, weight = 2 * cells, weight * rng.uniform(0.3, 0.8)
    low, high = float(total.min()), float(total.max())
    return (total - low) / (high - low)


def _plain(height: int, width: int, rng: np.random.Generator) -> Pattern:
    return 0.15 * _grain(height, width, rng)


def _waves(height: int, width: int, rng: np.random.Generator) -> tuple[Pattern, Pattern]:
    """Two sines across one another, of random period and direction."""
    v, u = np.mgrid[:height, :width].astype(np.float32) / max(height, width)
    angle, period = rng.uniform(0, np.pi), 0.5 ** rng.uniform(1.5, 5.0)
    along = (u * np.cos(angle) + v * np.sin(angle)) * np.float32(2 * np.pi / period)
    across = (v * np.cos(angle) - u * np.sin(angle)) * np.float32(2 * np.pi / period)
    return np.sin(along), np.sin(across)


def _stripes(height: int, width: int, rng: np.random.Generator) -> Pattern:
    wave, _ = _waves(height, width, rng)
    pattern: Pattern = np.clip(0.5 + rng.uniform(0.5, 5.0) * wave, 0, 1).astype(np.float32)
    return pattern


def _checks(height: int, width: int, rng: np.random.Generator) -> Pattern:
    one, other = _waves(height, width, rng)
    pattern: Pattern = np.clip(0.5 + 5.0 * one * other, 0, 1).astype(np.float32)
    return pattern


def _speckles(height: int, width: int, rng: np.random.Generator) -> Pattern:
    grain = _grain(height, width, rng, coarsest=12.0)
    pattern: Pattern = np.clip(8.0 * (grain - rng.uniform(0.4, 0.7)), 0, 1).astype(np.float32)
    return pattern


_PATTERNS: tuple[Callable[[int, int, np.random.Generator], Pattern], ...] = (
    _plain,
    _grain,
    _stripes,
    _checks,
    _speckles,
)
