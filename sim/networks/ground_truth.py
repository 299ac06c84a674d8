"""What a picture really shows. Estimators of this package are made from it; observations never hold it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame
from maskval import Camera, Mesh, Pose
from maskval.rendering.silhouettes import silhouette_areas
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.networks.mask_kernels import histogram


@dataclass(frozen=True, eq=False)
class FrameTruth:
    """The truth about one frame, or about one generated image, of P parts.

    Attributes:
        frame: index of the frame, or number of the image.
        instance_ids: (H, W) int8, the part that each pixel shows, `NO_INSTANCE` where it shows none.
        X_CO_true: true pose of every part in the true camera.
        camera: the true camera.
        mesh: the shape of every part.
    """

    frame: int
    instance_ids: NDArray[np.int8]
    X_CO_true: tuple[Pose, ...]
    camera: Camera
    mesh: Mesh

    def __post_init__(self) -> None:
        self.instance_ids.setflags(write=False)

    @property
    def visibility(self) -> NDArray[np.float64]:
        """Visible share of each part's whole silhouette, (P,) in [0, 1]: occlusion and the image's border together."""
        return self._shares[0]

    @property
    def in_view(self) -> NDArray[np.float64]:
        """Share of each part's silhouette inside the image, whoever hides it, (P,) in [0, 1]."""
        return self._shares[1]

    @cached_property
    def _shares(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        whole, inside = silhouette_areas(self.mesh, self.X_CO_true, self.camera, pixel_center=PIXEL_CENTER).T
        shares = (
            np.minimum(1.0, self._seen_px / np.maximum(1, whole)),
            inside / np.maximum(1, whole),
        )
        for array in shares:
            array.setflags(write=False)
        return shares

    @cached_property
    def _seen_px(self) -> NDArray[np.int64]:
        """Pixels that show each part, (P,)."""
        return np.array([np.count_nonzero(self.instance_ids == part) for part in range(len(self.X_CO_true))], np.int64)

    def visible_parts(self) -> list[int]:
        """Parts with at least one pixel, in the order of their numbers."""
        return [int(part) for part in np.flatnonzero(self._seen_px)]

    def mask(self, part: int) -> NDArray[np.bool_]:
        """The pixels that show the part, (H, W)."""
        shown: NDArray[np.bool_] = self.instance_ids == part
        return shown

    def X_CO_seen(self, part: int, center_O: NDArray[np.float64], believed: Camera) -> Pose:
        """The pose in which the part looks to a believed camera as it truly looks to the true one.

        As large in focal lengths, its middle at the same pixel, and turned by as much as the ray to it is turned:
        what a network concludes from a picture whose camera it has wrong. The true pose where it has it right.

        Args:
            part: Its number.
            center_O: Its middle, (3,) m.
            believed: The camera that the network believes in.
        """
        X_CO, true = self.X_CO_true[part], self.camera
        if believed == true:
            return X_CO
        x, y, z = p_true = X_CO.apply(center_O)
        z_seen = z * np.sqrt(believed.fx / true.fx * believed.fy / true.fy)
        u, v = true.fx * x / z + true.cx, true.fy * y / z + true.cy
        p_seen = np.array([(u - believed.cx) / believed.fx * z_seen, (v - believed.cy) / believed.fy * z_seen, z_seen])
        axis = np.cross(p_true, p_seen)
        turn = Pose.from_rotvec(axis / (np.linalg.norm(p_true) * np.linalg.norm(p_seen)))  # small: sin is the angle
        rotation = turn.rotation @ X_CO.rotation
        return Pose(rotation, p_seen - rotation @ center_O)

    def part_of(self, detection: Detection) -> int | None:
        """The part that most of the detection's pixels show; None if they show none."""
        part = self.shown_by(detection.mask)
        return None if part == NO_INSTANCE else part

    def shown_by(self, mask: NDArray[np.bool_]) -> int:
        """The part that most of a mask's pixels show, or `NO_INSTANCE`."""
        return shown_part(self.instance_ids, mask)


def shown_part(instance_ids: NDArray[np.int8], mask: NDArray[np.bool_]) -> int:
    """The part that most of a mask's pixels show, or `NO_INSTANCE`.

    Args:
        instance_ids: The part that each pixel shows, (H, W); `NO_INSTANCE` where it shows none.
        mask: (H, W).
    """
    pixels = histogram(instance_ids.ravel(), mask.ravel())
    return int(pixels.argmax()) if pixels.any() else NO_INSTANCE


class LatestTruth:
    """Holds the truth about the newest frame for those who may ask: this package's estimators and the logs."""

    def __init__(self) -> None:
        self._newest: FrameTruth | None = None

    def keep(self, truth: FrameTruth) -> None:
        """Replaces what is held."""
        self._newest = truth

    @property
    def newest(self) -> FrameTruth:
        """The truth about the newest frame.

        Raises:
            LookupError: there has been none.
        """
        if self._newest is None:
            raise LookupError("no frame has been taken yet: there is no truth about one")
        return self._newest

    def of(self, frame: Frame) -> FrameTruth:
        """The truth about the newest frame.

        Raises:
            LookupError: an older frame is asked for.
        """
        if self._newest is None or self._newest.frame != frame.index:
            held = "none" if self._newest is None else f"frame {self._newest.frame}"
            raise LookupError(f"the truth about frame {frame.index} is not held any more, only {held}")
        return self._newest
