"""From a true visible mask to what an instance segmentation would give: Mask R-CNN's way, in a 28 × 28 grid of its box.

The box's sides are jittered. The signed distance to the true outline, in cells of the grid, positive inside, gets a
smooth random field, a bias and leakage into neighbours; what is above 0 after going back to the image is the mask.
With the view's difficulty D, box jitter, field and leakage are exp(g D_M) times their standard size, where
D_M = ρ D + √(1 − ρ²) e_M. A few masks lose a piece, a few instances are missed, barely visible ones more often.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import ClassVar, Self

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from cell.interfaces import Detection
from sim.networks.mask_kernels import fill_positive, overlap, sample, signed
from sim.networks.noise_model import MaskNoise

CELLS = 28  # the side of Mask R-CNN's mask head
MODES = 5  # cosines per axis in the random field: its bumps are about CELLS / MODES cells wide
_FINE = 4  # samples per cell and axis, at which the distance is measured
_MARGIN = 2  # cells around the box that the distance knows about
_CUT = -3.0  # cells; so far outside is what a dropped piece leaves
_BLOB_SPREAD = 0.3  # standard deviation of the logarithm of a false alarm's half axes
FALSE_ALARM_COUNT = 7  # numbers that a false alarm needs

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Box = tuple[float, float, float, float]  # left, top, right, bottom, in px from the image's corner


@dataclass(frozen=True, slots=True, eq=False)
class MaskLatents:
    """Standard-normal numbers of one view.

    Attributes:
        difficulty: D, shared by mask, S1 and S2.
        own_difficulty: e_M.
        miss: below its quantile, the instance is missed.
        drop: (3,): below the first one's quantile a piece is missing; where it was, and how large.
        score: the score's noise.
        box: (4,): left, top, right, bottom side.
        field: (MODES²,): coefficients of the random field.
    """

    difficulty: float
    own_difficulty: float
    miss: float
    drop: Array
    score: float
    box: Array
    field: Array

    COUNT: ClassVar[int] = 10 + MODES**2  # numbers in the vector, without the difficulty

    @classmethod
    def from_vector(cls, difficulty: float, vector: Array) -> Self:
        """The record of a difficulty and `COUNT` other numbers; the arrays are read-only.

        Raises:
            ValueError: another number of numbers, or one is not finite.
        """
        if vector.shape != (cls.COUNT,) or not np.isfinite(vector).all():
            raise ValueError(f"expected {cls.COUNT} finite latents, got {vector}")
        frozen = vector.copy()
        frozen.setflags(write=False)
        own, miss, score = frozen[:3].tolist()
        return cls(float(difficulty), own, miss, frozen[3:6], score, frozen[6:10], frozen[10:])


def noisy_detection(
    visible: Mask, neighbors: Mask, visibility: float, latents: MaskLatents, noise: MaskNoise
) -> Detection | None:
    """What the detector gives for one instance; None when it misses it, which an empty mask counts as.

    Args:
        visible: The true visible mask, (H, W).
        neighbors: The pixels of all other instances, (H, W).
        visibility: Visible share of the whole silhouette, in [0, 1].
        latents: The view's numbers.
        noise: The parameters.
    """
    if ndtr(latents.miss) < miss_probability(visibility, noise) or not visible.any():
        return None
    scale = difficulty_scale(latents, noise)
    box = _jittered_box(visible, scale * noise.box_share * latents.box)
    distance = cell_distance(visible, box)
    distance += noise.bias_cells + scale * noise.field_cells * random_field(latents.field)
    if noise.leak_cells > 0.0:
        distance += scale * noise.leak_cells * _nearness(neighbors, box)
    _drop_piece(distance, latents.drop, noise)
    mask = paste(distance, box, visible.shape)
    found, shown, shared = overlap(mask.ravel(), visible.ravel())
    if not found:
        return None
    iou = shared / (found + shown - shared)
    mask.setflags(write=False)
    return Detection(mask, min(1.0, max(0.0, iou + noise.score_sd * latents.score)))


def false_alarm(shape: tuple[int, ...], latents: Array, noise: MaskNoise) -> Detection | None:
    """In rare cases a blob at a random place of the image, taken for an instance; else None.

    Args:
        shape: The image's (H, W).
        latents: Standard-normal numbers of the picture, (FALSE_ALARM_COUNT,).
        noise: The parameters.
    """
    gate, u, v, turn = ndtr(latents[:4]).tolist()
    if gate >= noise.false_alarms_per_image:
        return None
    axes = np.maximum(1, np.round(noise.false_alarm_radius_px * np.exp(_BLOB_SPREAD * latents[4:6]))).astype(int)
    blob = np.zeros(shape[:2], dtype=np.uint8)
    cv2.ellipse(blob, (int(u * shape[1]), int(v * shape[0])), axes.tolist(), 180.0 * turn, 0.0, 360.0, 1, cv2.FILLED)
    blob.setflags(write=False)
    score = noise.false_alarm_score + noise.score_sd * float(latents[6])
    return Detection(blob.view(np.bool_), min(1.0, max(0.0, score)))


def miss_probability(visibility: float, noise: MaskNoise) -> float:
    """The chance that an instance is missed, in [0, 1]: it rises to 1 as the visibility falls to 0.

    Args:
        visibility: Visible share of the whole silhouette, in [0, 1].
        noise: The parameters.
    """
    noticed = min(1.0, visibility / noise.miss_visibility) if noise.miss_visibility > 0.0 else 1.0
    return 1.0 - (1.0 - noise.miss_probability) * noticed


def difficulty_scale(latents: MaskLatents, noise: MaskNoise) -> float:
    """How much larger than usual this view's displacements are, > 0.

    Args:
        latents: The view's numbers.
        noise: The parameters.
    """
    rho = noise.difficulty_correlation
    difficulty = rho * latents.difficulty + math.sqrt(1.0 - rho**2) * latents.own_difficulty
    return math.exp(noise.difficulty_gain * difficulty)


def random_field(coefficients: Array) -> NDArray[np.float32]:
    """A smooth field over the grid, (CELLS, CELLS), of mean 0 and variance 1 (its average over the grid).

    Args:
        coefficients: Independent N(0, 1), (MODES²,).
    """
    # In double precision: single's last bits move outlines by a pixel once in some thousand masks.
    field: NDArray[np.float32] = (coefficients @ _cosines()).astype(np.float32).reshape(CELLS, CELLS)
    return field


def cell_distance(mask: Mask, box: Box) -> NDArray[np.float32]:
    """Signed distance of each cell's middle to the mask's outline, in cells, positive inside, (CELLS, CELLS).

    The image's border is no outline: what lies beyond it is taken to be as its nearest pixel is.

    Args:
        mask: (H, W).
        box: What the grid covers.
    """
    outside = (_sampled(mask.view(np.uint8), box) <= 127).view(np.uint8)
    to_outside, to_inside = (
        np.asarray(cv2.distanceTransform(side, cv2.DIST_L2, cv2.DIST_MASK_5), dtype=np.float32)
        for side in (1 - outside, outside)
    )
    inner = slice(_FINE * _MARGIN, -_FINE * _MARGIN)
    fine = signed(to_outside[inner, inner], to_inside[inner, inner], _FINE, CELLS)
    distance: NDArray[np.float32] = np.asarray(
        cv2.resize(fine, (CELLS, CELLS), interpolation=cv2.INTER_AREA), np.float32
    )
    return distance


def paste(distance: NDArray[np.float32], box: Box, shape: tuple[int, ...]) -> Mask:
    """The mask that a grid of signed distances means, (H, W): bilinear between the cells' middles, cut at the box.

    Args:
        distance: Signed distances, (CELLS, CELLS), positive inside.
        box: What the grid covers.
        shape: The image's (H, W).
    """
    left, top, right, bottom = box
    # A pixel belongs to the box when its middle does.
    u0, u1 = max(0, math.ceil(left - 0.5)), min(shape[1], math.ceil(right - 0.5))
    v0, v1 = max(0, math.ceil(top - 0.5)), min(shape[0], math.ceil(bottom - 0.5))
    mask = np.zeros(shape[:2], dtype=np.bool_)
    if u1 > u0 and v1 > v0:
        u = (np.arange(u0, u1, dtype=np.float64) + 0.5 - left) * (CELLS / (right - left)) - 0.5
        v = (np.arange(v0, v1, dtype=np.float64) + 0.5 - top) * (CELLS / (bottom - top)) - 0.5
        fill_positive(distance.astype(np.float64), u, v, mask[v0:v1, u0:u1])
    return mask


def _jittered_box(mask: Mask, moves: Array) -> Box:
    """The mask's box, each side moved by a share of the box's extent, and never less than a pixel wide."""
    u, v, width, height = cv2.boundingRect(mask.view(np.uint8))
    left, right = u + moves[0] * width, u + width + moves[2] * width
    top, bottom = v + moves[1] * height, v + height + moves[3] * height
    return float(left), float(top), float(max(right, left + 1.0)), float(max(bottom, top + 1.0))


def _nearness(neighbors: Mask, box: Box) -> NDArray[np.float32]:
    """1 in cells at and beyond a border with a neighbour, 0 away from them, (CELLS, CELLS)."""
    seen = _sampled(neighbors.view(np.uint8), box)
    if not seen.any():
        return np.zeros((CELLS, CELLS), dtype=np.float32)
    cells = cv2.resize(seen, None, fx=1 / _FINE, fy=1 / _FINE, interpolation=cv2.INTER_AREA).astype(np.float32)
    # At a straight border the blurred cover is 1/2: twice that, at most 1, is 1 from the border on.
    near = np.minimum(1.0, cv2.blur(cells, (3, 3)) * np.float32(2 / 255))
    inner: NDArray[np.float32] = near[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN]
    return inner


def _drop_piece(distance: NDArray[np.float32], latents: Array, noise: MaskNoise) -> None:
    """In rare cases cuts off the cells on one side of a line, in place."""
    if ndtr(latents[0]) >= noise.drop_probability:
        return
    angle = 2.0 * math.pi * float(ndtr(latents[1]))
    share = noise.drop_share_min + (noise.drop_share_max - noise.drop_share_min) * float(ndtr(latents[2]))
    place = np.arange(CELLS) + 0.5 - CELLS / 2
    along = math.cos(angle) * place[None, :] + math.sin(angle) * place[:, None]
    inside = distance > 0.0
    if inside.any():
        distance[along > np.quantile(along[inside], 1.0 - share)] = _CUT


def _sampled(image: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
    """The box and its margin in samples, _FINE per cell; a pixel of 1 becomes 255."""
    left, top, right, bottom = box
    place: Array = np.arange(-_MARGIN * _FINE, (CELLS + _MARGIN) * _FINE, dtype=np.float64) + 0.5
    u = left + place * ((right - left) / (CELLS * _FINE)) - 0.5
    v = top + place * ((bottom - top) / (CELLS * _FINE)) - 0.5
    return sample(image, u, v)


@cache
def _cosines() -> Array:
    """The modes of the random field, (MODES², CELLS²): equal variances that add up to 1 on average over the grid."""
    place = (np.arange(CELLS) + 0.5) / CELLS
    along = np.array([math.sqrt(1 if k == 0 else 2) * np.cos(math.pi * k * place) for k in range(MODES)])
    modes: Array = np.einsum("iv,ju->ijvu", along, along).reshape(MODES**2, CELLS**2) / MODES
    modes.setflags(write=False)
    return modes
