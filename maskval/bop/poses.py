"""The poses of a file, whose rotations may be printed with few digits."""

import warnings
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from maskval.bop.fields import M_PER_MM
from maskval.bop.places import Place
from maskval.errors import InexactRotationWarning, InvalidFileError, MaskvalError
from maskval.geometry import Pose

# The greatest difference of an element from the nearest rotation's: three decimals stay below the first. Two decimals
# stay below the second, and so does LM-O: 187 of its 1,445 true rotations are off by more than 0.001, up to 0.0046.
EXACT = 1e-3
INEXACT = 1e-2
# 10,000 km: farther than any place from the middle of the Earth, which maps may be given in.
FARTHEST_MM = 1e10


class PoseReader:
    """Makes poses of one file's numbers; at the end of `with`, one warning tells of all that were far off a rotation.

    Args:
        path: The file, for the warning.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._count = 0
        self._far: list[float] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None and self._far:
            warnings.warn(
                f"{self._path}: {len(self._far):,} of {self._count:,} rotations are off by more than {EXACT:g}, by up "
                f"to {max(self._far):.2g}; the nearest rotations are taken",
                InexactRotationWarning,
                stacklevel=3,  # where the file was asked for
            )

    def pose(self, rotation: NDArray[np.float64], translation_mm: NDArray[np.float64], place: Place | str) -> Pose:
        """The pose of nine numbers, row by row, and three in millimetres.

        Args:
            rotation: (9,), a rotation to 1e-2 an element: the nearest one is taken.
            translation_mm: (3,), millimetres.
            place: Where the numbers stand, for the error.

        Raises:
            InvalidFileError: If the matrix is no rotation, or the translation is longer than 10,000 km.
        """
        if np.abs(translation_mm).max() > FARTHEST_MM:
            raise InvalidFileError(
                f"{place}: expected a translation within {FARTHEST_MM:g} mm, but found {translation_mm.tolist()}"
            )
        R = rotation.reshape(3, 3)
        left, _, right = np.linalg.svd(np.clip(R, -2, 2))  # what no rotation has may overflow
        nearest = left @ right
        try:
            pose = Pose(nearest, translation_mm * M_PER_MM)
        except MaskvalError as error:
            raise InvalidFileError(f"{place}: {error}") from error
        off = float(np.abs(nearest - R).max())
        if off > INEXACT:
            raise InvalidFileError(
                f"{place}: expected a rotation to {INEXACT:g}, but the nearest one differs by {off:.3g}"
            )
        self._count += 1
        if off > EXACT:
            self._far.append(off)
        return pose
