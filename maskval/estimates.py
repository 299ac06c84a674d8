"""What an uncertainty method is given, and what it must offer."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.correspondences import Correspondences
from maskval.errors import InvalidEstimatesError
from maskval.geometry import Pose, as_pose, as_poses
from maskval.inputs.arrays import check_kind, check_number, floats
from maskval.mesh import Mesh

_FLAGS = ("depth", "X_BC", "correspondences", "rgb")


@dataclass(frozen=True, slots=True, eq=False)
class Estimates:
    """N detections of one kind of part in one image, and what one or more pose estimators make of them.

    Args:
        camera: Intrinsics and image size.
        mesh: The part.
        masks: The detector's masks, (N, H, W), bool.
        poses: `poses[e][i]` is estimator e's pose X_CO of detection i, made from mask i; estimator 0 is the one used.
            Homogeneous matrices, (E, N, 4, 4), will do as well.
        scores: The detector's confidences, (N,).
        pixel_center: Where pixel i of the images is sampled, u = i + pixel_center.
        depth: Measured z-depth, (H, W), metres, 0 where nothing was measured; None without a depth camera.
        X_BC: Pose of the camera in a frame that stays where it is, such as the robot's base; None if unknown.
        correspondences: What estimator 0 computed each of its poses from, N of them; None if it tells nothing of it.
        rgb: The picture, (H, W, 3), uint8; None if it is not at hand.

    Raises:
        InvalidEstimatesError: If masks, poses and scores are not equally many, an image is not of the camera's
            size, the masks are not bool, a depth is negative or not finite, or there is no estimator.
    """

    camera: Camera
    mesh: Mesh
    masks: NDArray[np.bool_]
    poses: tuple[tuple[Pose, ...], ...]
    scores: NDArray[np.float64]
    pixel_center: float = 0.0
    depth: NDArray[np.float32] | None = None
    X_BC: Pose | None = None
    correspondences: tuple[Correspondences, ...] | None = None
    rgb: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        check_kind("camera", self.camera, Camera, InvalidEstimatesError)
        check_kind("mesh", self.mesh, Mesh, InvalidEstimatesError)
        check_number("pixel_center", self.pixel_center, InvalidEstimatesError, least=0.0, most=1.0, ends="[)")
        masks, scores = _kept(self.masks), floats("scores", self.scores, InvalidEstimatesError)
        size = (self.camera.height, self.camera.width)
        if masks.dtype != np.bool_ or masks.ndim != 3 or masks.shape[1:] != size:
            raise InvalidEstimatesError(
                f"masks must be bool of shape (N, {size[0]}, {size[1]}), but are {masks.dtype} of {masks.shape}"
            )
        if len(self.poses) == 0:
            raise InvalidEstimatesError("poses must hold those of at least one estimator, but hold none")
        object.__setattr__(self, "poses", tuple(as_poses(poses) for poses in self.poses))
        if self.X_BC is not None:
            object.__setattr__(self, "X_BC", as_pose(self.X_BC))
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
        if self.depth is not None:
            object.__setattr__(self, "depth", _depth(self.depth, size))
        if self.rgb is not None:
            object.__setattr__(self, "rgb", _rgb(self.rgb, size))
        if self.correspondences is not None and len(self.correspondences) != len(masks):
            raise InvalidEstimatesError(
                f"correspondences must be given for each of {len(masks)} masks, but are {len(self.correspondences)}"
            )

    def __len__(self) -> int:
        return len(self.masks)


def _kept(masks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The masks, copied unless nobody can write to them."""
    array = np.asarray(masks)
    return np.array(array) if array.flags.writeable or array.base is not None else array


def _depth(image: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    depth = floats("depth", image, InvalidEstimatesError).astype(np.float32)
    if depth.shape != size or not (np.isfinite(depth) & (depth >= 0)).all():
        raise InvalidEstimatesError(f"depth must be of shape {size} (H, W), finite and >= 0 m, but has {depth.shape}")
    depth.setflags(write=False)
    return depth


def _rgb(image: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.uint8]:
    rgb = np.asarray(image)
    if rgb.shape != (*size, 3) or rgb.dtype != np.uint8:
        raise InvalidEstimatesError(f"rgb must be uint8 of shape {(*size, 3)}, but is {rgb.dtype} of {rgb.shape}")
    rgb = rgb.view()
    rgb.setflags(write=False)
    return rgb


@dataclass(frozen=True, slots=True)
class Needs:
    """What a method must be given beside the camera, the mesh, masks, scores and one estimator's poses.

    Args:
        estimators: How many pose estimators, >= 1.
        depth: Whether the estimates must hold a depth image.
        X_BC: Whether they must hold the camera's pose: the method compares what several views of one scene show.
        correspondences: Whether they must hold what the poses were computed from.
        rgb: Whether they must hold the picture.

    Raises:
        InvalidEstimatesError: If `estimators` is no whole number >= 1, or another is not True or False.
    """

    estimators: int = 1
    depth: bool = False
    X_BC: bool = False
    correspondences: bool = False
    rgb: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.estimators, bool) or not isinstance(self.estimators, int) or self.estimators < 1:
            raise InvalidEstimatesError(f"estimators must be a whole number >= 1, but is {self.estimators!r}")
        for name in _FLAGS:
            if not isinstance(getattr(self, name), bool):
                raise InvalidEstimatesError(f"{name} must be True or False, but is {getattr(self, name)!r}")

    @classmethod
    def together(cls, *each: Self) -> Self:
        """What serves all of them."""
        return cls(
            estimators=max((needs.estimators for needs in each), default=1),
            **{name: any(getattr(needs, name) for needs in each) for name in _FLAGS},
        )


class UncertaintyMethod(Protocol):
    """An uncertainty quantification: anything that gives every estimated pose a number that is low for a good one.

    A method with an attribute `needs` of the type `Needs` is given what it asks for; one without, the least.
    """

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The uncertainty u of each pose of estimator 0, (N,), in [0, 1]; low is good.

        Args:
            estimates: Detections and what was asked for about them.
        """
        ...


def needs_of(method: UncertaintyMethod) -> Needs:
    """What a method asks for: its attribute `needs`, or the least there is.

    Raises:
        InvalidEstimatesError: If its `needs` are of another type.
    """
    needs = getattr(method, "needs", Needs())
    if not isinstance(needs, Needs):
        raise InvalidEstimatesError(f"{type(method).__name__}.needs must be a maskval.Needs, but is {needs!r}")
    return needs
