"""Pictures for the detector, each time lit and mirrored differently."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.training.batches import DetectorBatch
from experiments.training.lighting import relit
from experiments.training.pictures import TruePicture
from sim.learned.estimators import DETECTOR_SIZE
from sim.learned.grouping import VOTE_SCALE

LEAST_VISIBILITY, FEWEST_PX = 0.1, 150  # of the parts that are to be found; less does not count
MAP = DETECTOR_SIZE[0] // 2, DETECTOR_SIZE[1] // 2
_IGNORED = 255
_SPREAD = 0.08  # of the centre's peak, in square roots of the part's area, but …
_LEAST_SPREAD = 1.5  # … at least so many map pixels

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class StoredPicture:
    """A picture in the detector's size, and which part each map pixel shows.

    Attributes:
        image: RGB, (H, W, 3).
        numbers: (h, w), the part's number from 1, 0 for none, 255 for what does not count.
    """

    image: NDArray[np.uint8]
    numbers: NDArray[np.uint8]


def stored_pictures(pictures: Iterable[TruePicture]) -> list[StoredPicture]:
    """All pictures in the size in which the detector learns from them."""
    return [_stored(picture) for picture in pictures]


def _stored(picture: TruePicture) -> StoredPicture:
    image = cv2.resize(picture.rgb, DETECTOR_SIZE[::-1], interpolation=cv2.INTER_AREA)
    numbers = np.zeros(MAP, dtype=np.uint8)
    for index, part in enumerate(picture.parts):
        covered = cv2.resize(part.mask.astype(np.uint8) * 255, MAP[::-1], interpolation=cv2.INTER_AREA)
        counts = part.visibility >= LEAST_VISIBILITY and np.count_nonzero(part.mask) >= FEWEST_PX
        numbers[covered > 127] = index + 1 if counts else _IGNORED
    return StoredPicture(np.asarray(image), numbers)


class DetectorSamples:
    """Batches of pictures; the one of a step is a function of seed and step.

    Args:
        pictures: to draw from.
        size: pictures in a batch.
        seed: root of all random numbers.
    """

    def __init__(self, pictures: list[StoredPicture], *, size: int, seed: int) -> None:
        self._pictures, self._size, self._seed = pictures, size, seed

    def batch(self, step: int) -> DetectorBatch[Floats]:
        """The batch of a step."""
        rng = np.random.default_rng((self._seed, step))
        chosen = rng.integers(len(self._pictures), size=self._size)
        samples = [_sample(self._pictures[index], rng) for index in chosen]
        images, parts, centers, votes = (np.stack(arrays) for arrays in zip(*samples, strict=True))
        pixels = np.ascontiguousarray(images.transpose(0, 3, 1, 2), dtype=np.float32)
        return DetectorBatch(pixels, parts, centers, votes)


def _sample(stored: StoredPicture, rng: np.random.Generator) -> tuple[NDArray[np.float64], Floats, Floats, Floats]:
    across, upside_down = rng.integers(2, size=2) * -2 + 1
    image, numbers = (array[::upside_down, ::across] for array in (stored.image, stored.numbers))
    return relit(image, rng), *targets(numbers)


def targets(numbers: NDArray[np.uint8]) -> tuple[Floats, Floats, Floats]:
    """Part (h, w), centre (h, w) and votes (2, h, w), see `DetectorBatch`, for which part each map pixel shows."""
    part = np.where(numbers == _IGNORED, -1.0, numbers > 0).astype(np.float32)
    center, votes = np.zeros(numbers.shape, dtype=np.float32), np.zeros((2, *numbers.shape), dtype=np.float32)
    rows, columns = np.arange(numbers.shape[0], dtype=np.float32), np.arange(numbers.shape[1], dtype=np.float32)
    for number in np.unique(numbers[(numbers > 0) & (numbers != _IGNORED)]):
        v, u = np.nonzero(numbers == number)
        middle = np.array((u.mean(), v.mean()))
        votes[:, v, u] = (middle[:, None] - (u, v)) / VOTE_SCALE
        spread = max(_SPREAD * np.sqrt(len(u)), _LEAST_SPREAD)
        near = np.exp(-((rows[:, None] - middle[1]) ** 2 + (columns[None, :] - middle[0]) ** 2) / (2 * spread**2))
        near[int(np.rint(middle[1])), int(np.rint(middle[0]))] = 1.0
        np.maximum(center, near, out=center)
    return part, center, votes
