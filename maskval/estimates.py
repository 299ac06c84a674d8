"""What an uncertainty method is given, and what it must offer."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError
from maskval.geometry import Pose
from maskval.mesh import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Estimates:
    """N detections of one kind of part in one image, and what one or more pose estimators make of them.

    Args:
        camera: Intrinsics and image size.
        mesh: The part.
        masks: The detector's masks, (N, H, W), bool.
        poses: poses[e][i] is estimator e's pose X_CO of detection i, made from mask i; estimator 0 is the one used.
        scores: The detector's confidences, (N,).
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center.

    Raises:
        InvalidEstimatesError: If masks, poses and scores are not equally many, the masks are not of the image's
            size or not bool, or there is no estimator.
    """

    camera: Camera
    mesh: Mesh
    masks: NDArray[np.bool_]
    poses: tuple[tuple[Pose, ...], ...]
    scores: NDArray[np.float64]
    pixel_center: float = 0.0

    def __post_init__(self) -> None:
        masks, scores = np.array(self.masks), np.array(self.scores, dtype=np.float64)
        size = (self.camera.height, self.camera.width)
        if masks.dtype != np.bool_ or masks.ndim != 3 or masks.shape[1:] != size:
            raise InvalidEstimatesError(
                f"masks must be bool of shape (N, {size[0]}, {size[1]}), but are {masks.dtype} of {masks.shape}"
            )
        if not self.poses:
            raise InvalidEstimatesError("poses must hold those of at least one estimator, but hold none")
        for e, poses in enumerate(self.poses):
            if len(poses) != len(masks):
                raise InvalidEstimatesError(
                    f"every estimator must give a pose for each of {len(masks)} masks, but estimator {e} "
                    f"gives {len(poses)}"
                )
        if scores.shape != (len(masks),) or not np.isfinite(scores).all():
            raise InvalidEstimatesError(f"scores must be finite and of shape ({len(masks)},), but are {scores}")
        for name, array in (("masks", masks), ("scores", scores)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "poses", tuple(tuple(poses) for poses in self.poses))

    def __len__(self) -> int:
        return len(self.masks)


class UncertaintyMethod(Protocol):
    """An uncertainty quantification: anything that gives every estimated pose a number that is low for a good one."""

    @property
    def estimators(self) -> int:
        """How many pose estimators it needs."""
        ...

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The uncertainty u of each pose of estimator 0, (N,), in [0, 1]; low is good.

        Args:
            estimates: Detections and the poses of at least `estimators` estimators.
        """
        ...


@dataclass(frozen=True, slots=True)
class NoUncertainty:
    """The method that trusts every pose: u = 0."""

    estimators: ClassVar[int] = 1

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """Zero for each pose, (N,)."""
        return np.zeros(len(estimates))
