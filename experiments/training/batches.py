"""What a network is shown in one step, and what it should say."""

from dataclasses import dataclass
from typing import Generic, TypeVar

Values = TypeVar("Values")  # arrays of float32 where a batch is made, tensors where it is used


@dataclass(frozen=True, slots=True, eq=False)
class PoseBatch(Generic[Values]):
    """N crops and the truth about them.

    Attributes:
        images: (N, 3, H, W) in [0, 1].
        coordinates: of S poses that look alike, (N, S, 3, h, w) in half sizes.
        visible: (N, h, w), 1 where the part is seen.
        head: u, v and logarithm of depth, (N, 3); see `sim.learned.coordinates.Maps`.
    """

    images: Values
    coordinates: Values
    visible: Values
    head: Values


@dataclass(frozen=True, slots=True, eq=False)
class DetectorBatch(Generic[Values]):
    """N pictures and the truth about them.

    Attributes:
        images: (N, 3, H, W) in [0, 1].
        part: (N, h, w), 1 where a part is seen, 0 elsewhere, -1 where it does not count.
        center: how near the middle of a part is, (N, h, w) in [0, 1], 1 there.
        votes: from each pixel of a part to its middle, (N, 2, h, w); see `sim.learned.grouping`.
    """

    images: Values
    part: Values
    center: Values
    votes: Values
