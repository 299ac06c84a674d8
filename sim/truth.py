"""What a picture really shows. Estimators of this package are made from it; observations never hold it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame
from maskval import Camera, Mesh, Pose, silhouette
from sim.part_numbers import NOTHING, PIXEL_CENTER, shown_part


@dataclass(frozen=True, slots=True, eq=False)
class FrameTruth:
    """The truth about one frame.

    Attributes:
        frame: index of the frame.
        part_numbers: (H, W) int8, the part that each pixel shows, `NOTHING` where it shows none.
        X_CO_true: true pose of every part in the true camera.
    """

    frame: int
    part_numbers: NDArray[np.int8]
    X_CO_true: tuple[Pose, ...]

    def visible_parts(self) -> list[int]:
        """Parts with at least one pixel, in the order of their numbers."""
        pixels = np.bincount(self.part_numbers.ravel() + 1)  # the first bin counts the pixels without a part
        return [int(part) for part in np.flatnonzero(pixels[1:])]

    def mask(self, part: int) -> NDArray[np.bool_]:
        """The pixels that show the part, (H, W)."""
        shown: NDArray[np.bool_] = self.part_numbers == part
        return shown

    def visibility(self, part: int, mesh: Mesh, camera: Camera) -> float:
        """Visible share of the part's whole silhouette, in [0, 1]: occlusion and the image's border together."""
        whole = silhouette(mesh, self.X_CO_true[part], camera, pixel_center=PIXEL_CENTER).area_px
        return min(1.0, float(self.mask(part).sum()) / whole) if whole else 0.0

    def part_of(self, detection: Detection) -> int | None:
        """The part that most of the detection's pixels show; None if they show none."""
        part = shown_part(self.part_numbers, detection.mask)
        return None if part == NOTHING else part


class TruthBooth:
    """Holds the truth about the newest frame for those who may ask: this package's estimators and the logs."""

    def __init__(self) -> None:
        self._newest: FrameTruth | None = None

    def keep(self, truth: FrameTruth) -> None:
        """Replaces what is held."""
        self._newest = truth

    def of(self, frame: Frame) -> FrameTruth:
        """The truth about the newest frame.

        Raises:
            LookupError: an older frame is asked for.
        """
        if self._newest is None or self._newest.frame != frame.index:
            held = "none" if self._newest is None else f"frame {self._newest.frame}"
            raise LookupError(f"the truth about frame {frame.index} is not held any more, only {held}")
        return self._newest
