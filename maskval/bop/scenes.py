"""BOP's annotations of a scene: cameras, true poses, how visible each part is, and the targets of an evaluation."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from maskval.bop.fields import M_PER_MM, Entry, read_json, write_entries
from maskval.bop.poses import PoseReader
from maskval.camera import Camera
from maskval.errors import InvalidCameraError, InvalidFileError, MaskvalError
from maskval.geometry import Pose, as_pose
from maskval.inputs.arrays import floats

T = TypeVar("T")
GREATEST_PX = 1e7  # of a focal length or principal point: beyond any lens, and what a kernel can count with


@dataclass(frozen=True, slots=True, eq=False)
class ImageCamera:
    """The camera of an image; BOP keeps the image's size in the image.

    Args:
        K: Intrinsics, (3, 3), pixels.
        depth_scale: Millimetres of depth for each step of the depth image.
        X_CW: Pose of the world in the camera frame, where it is known.
    """

    K: NDArray[np.float64]
    depth_scale: float = 1.0
    X_CW: Pose | None = None

    def __post_init__(self) -> None:
        K = floats("K", self.K, InvalidCameraError)
        K.setflags(write=False)
        if self.X_CW is not None:
            object.__setattr__(self, "X_CW", as_pose(self.X_CW))
        object.__setattr__(self, "K", K)

    def camera(self, width: int, height: int) -> Camera:
        """The camera of an image of this size, pixels."""
        return Camera.from_K(self.K, width, height)


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """A part and its true pose.

    Args:
        obj_id: Object.
        X_CO: True pose of the object in the camera frame, or its homogeneous matrix, (4, 4).
    """

    obj_id: int
    X_CO: Pose

    def __post_init__(self) -> None:
        object.__setattr__(self, "X_CO", as_pose(self.X_CO))


@dataclass(frozen=True, slots=True)
class GroundTruthInfo:
    """How much of a part can be seen; boxes are x, y, width and height, and -1 where there is none.

    Args:
        bbox_obj: Box of the whole silhouette, pixels; it may reach beyond the image.
        bbox_visib: Box of what is visible of it, pixels.
        px_count_all: Pixels of the whole silhouette, those beyond the image included.
        px_count_valid: Pixels of it at which depth was measured.
        px_count_visib: Pixels of it that are visible.
        visib_fract: px_count_visib / px_count_all, in [0, 1].
    """

    bbox_obj: tuple[int, int, int, int]
    bbox_visib: tuple[int, int, int, int]
    px_count_all: int
    px_count_valid: int
    px_count_visib: int
    visib_fract: float


@dataclass(frozen=True, slots=True)
class EvaluationTarget:
    """What an evaluation asks for: so many instances of an object in an image."""

    scene_id: int
    im_id: int
    obj_id: int
    inst_count: int


def read_scene_camera(path: Path) -> dict[int, ImageCamera]:
    """The camera of each image of `scene_camera.json`, by image."""
    with PoseReader(path) as poses:
        return {im_id: _camera(entry, poses) for im_id, entry in read_json(path).items()}


def read_scene_gt(path: Path) -> dict[int, list[GroundTruth]]:
    """The parts of each image of `scene_gt.json`, by image, translations turned into metres."""
    with PoseReader(path) as poses:

        def part(entry: Entry) -> GroundTruth:
            R, t = entry["cam_R_m2c"], entry["cam_t_m2c"]
            return GroundTruth(entry["obj_id"].identifier(), poses.pose(R.numbers(9), t.numbers(3), R.place))

        return _lists(path, part)


def read_scene_gt_info(path: Path) -> dict[int, list[GroundTruthInfo]]:
    """How visible each part of each image of `scene_gt_info.json` is, by image."""

    def info(entry: Entry) -> GroundTruthInfo:
        boxes = [_box(entry[name]) for name in ("bbox_obj", "bbox_visib")]
        counts = [entry[f"px_count_{name}"].identifier() for name in ("all", "valid", "visib")]
        fraction = entry["visib_fract"]
        if counts[2] > counts[0]:
            raise entry["px_count_visib"].error(f"at most the {counts[0]} of px_count_all")
        if not 0 <= fraction.number() <= 1:
            raise fraction.error("a share in [0, 1]")
        return GroundTruthInfo(boxes[0], boxes[1], counts[0], counts[1], counts[2], fraction.number())

    return _lists(path, info)


def read_targets(path: Path) -> list[EvaluationTarget]:
    """The targets of a `test_targets_bop19.json`."""
    names = ("scene_id", "im_id", "obj_id", "inst_count")
    return [EvaluationTarget(*(entry[name].identifier() for name in names)) for entry in read_json(path).elements()]


def write_scene_camera(path: Path, cameras: Mapping[int, ImageCamera]) -> None:
    """Writes `scene_camera.json`, translations in millimetres."""

    def fields(camera: ImageCamera) -> dict[str, Any]:
        entry: dict[str, Any] = {"cam_K": camera.K.ravel().tolist(), "depth_scale": camera.depth_scale}
        return entry if camera.X_CW is None else entry | _pose_fields(camera.X_CW, "w2c")

    write_entries(path, {str(im_id): fields(camera) for im_id, camera in cameras.items()})


def write_scene_gt(path: Path, images: Mapping[int, Iterable[GroundTruth]]) -> None:
    """Writes `scene_gt.json`, translations in millimetres."""
    write_entries(
        path,
        {
            str(im_id): [_pose_fields(part.X_CO, "m2c") | {"obj_id": part.obj_id} for part in parts]
            for im_id, parts in images.items()
        },
    )


def write_scene_gt_info(path: Path, images: Mapping[int, Iterable[GroundTruthInfo]]) -> None:
    """Writes `scene_gt_info.json`."""

    def fields(info: GroundTruthInfo) -> dict[str, Any]:
        return {
            "bbox_obj": info.bbox_obj,
            "bbox_visib": info.bbox_visib,
            "px_count_all": info.px_count_all,
            "px_count_valid": info.px_count_valid,
            "px_count_visib": info.px_count_visib,
            "visib_fract": info.visib_fract,
        }

    write_entries(path, {str(im_id): [fields(info) for info in infos] for im_id, infos in images.items()})


def write_targets(path: Path, targets: Sequence[EvaluationTarget]) -> None:
    """Writes a `test_targets_bop19.json`."""
    write_entries(
        path,
        [{"im_id": t.im_id, "inst_count": t.inst_count, "obj_id": t.obj_id, "scene_id": t.scene_id} for t in targets],
    )


def _camera(entry: Entry, poses: PoseReader) -> ImageCamera:
    K = entry["cam_K"].numbers(9).reshape(3, 3)
    try:
        Camera.from_K(K, 1, 1)
    except MaskvalError as error:
        raise InvalidFileError(f"{entry['cam_K'].place}: {error}") from error
    if np.abs(K).max() > GREATEST_PX:
        raise entry["cam_K"].error(f"intrinsics within {GREATEST_PX:g} px")
    scale = entry["depth_scale"].number() if "depth_scale" in entry else 1.0
    if scale <= 0:
        raise entry["depth_scale"].error("a scale > 0 mm")
    if "cam_R_w2c" not in entry:
        return ImageCamera(K, scale)
    R, t = entry["cam_R_w2c"], entry["cam_t_w2c"]
    return ImageCamera(K, scale, poses.pose(R.numbers(9), t.numbers(3), R.place))


def _box(entry: Entry) -> tuple[int, int, int, int]:
    entry.numbers(4)
    x, y, width, height = (element.integer() for element in entry.elements())
    return x, y, width, height


def _lists(path: Path, read: Callable[[Entry], T]) -> dict[int, list[T]]:
    return {im_id: [read(part) for part in entry.elements()] for im_id, entry in read_json(path).items()}


def _pose_fields(X: Pose, frames: str) -> dict[str, Any]:
    return {
        f"cam_R_{frames}": X.rotation.ravel().tolist(),
        f"cam_t_{frames}": (X.translation / M_PER_MM).tolist(),
    }
