"""A data set in BOP's layout: its objects, its scenes, and the masks that poses are judged by."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval.bop.detections import DetectionResult
from maskval.bop.fields import is_whole, read_json
from maskval.bop.images import mask_path, png_size, read_mask, read_photo
from maskval.bop.models import ModelInfo, read_model, read_models_info
from maskval.bop.scenes import (
    GroundTruth,
    GroundTruthInfo,
    ImageCamera,
    read_scene_camera,
    read_scene_gt,
    read_scene_gt_info,
    read_targets,
)
from maskval.errors import InvalidFileError
from maskval.masks import PackedMasks
from maskval.mesh import Mesh


class ImageObject(NamedTuple):
    """An object in an image, of which there may be several instances."""

    scene_id: int
    im_id: int
    obj_id: int


@dataclass(frozen=True, slots=True)
class Scene:
    """The annotations of a scene.

    Args:
        folder: Where they are.
        cameras: The camera of each image.
        truths: The parts of each image; None where true poses are kept back.
        infos: How visible they are; None where that is not known.
    """

    folder: Path
    cameras: dict[int, ImageCamera]
    truths: dict[int, list[GroundTruth]] | None
    infos: dict[int, list[GroundTruthInfo]] | None

    def camera(self, im_id: int) -> ImageCamera:
        """The camera of an image.

        Raises:
            InvalidFileError: If the scene has no such image.
        """
        if im_id not in self.cameras:
            raise InvalidFileError(
                f"{self.folder / 'scene_camera.json'}: expected the image {im_id}, which poses are given for, "
                f"but found {len(self.cameras)} others"
            )
        return self.cameras[im_id]

    def parts(self, im_id: int) -> list[tuple[GroundTruth, GroundTruthInfo]]:
        """The parts of an image, and how visible they are.

        Raises:
            InvalidFileError: If they are kept back, or the two files do not tell of the same parts.
        """
        truth, info = self.folder / "scene_gt.json", self.folder / "scene_gt_info.json"
        for path, images in ((truth, self.truths), (info, self.infos)):
            if images is None or im_id not in images:
                raise InvalidFileError(f"{path}: expected the parts of image {im_id}, but there are none")
        parts, infos = (self.truths or {})[im_id], (self.infos or {})[im_id]
        if len(parts) != len(infos):
            raise InvalidFileError(
                f"{info}: {im_id}: expected {len(parts)} parts as in scene_gt.json, but found {len(infos)}"
            )
        if len({(part.obj_id, part.X_CO.matrix.tobytes()) for part in parts}) < len(parts):
            raise InvalidFileError(f"{truth}: {im_id}: expected each part once, but two have one pose")
        return list(zip(parts, infos, strict=True))


class Dataset:
    """A folder in BOP's layout.

    Args:
        folder: Folder with `models` and the split's scenes.
        split: Folder of the scenes in it.

    Raises:
        FileNotFoundError: If one of these folders is missing.
    """

    def __init__(self, folder: Path, split: str = "test") -> None:
        for needed in (folder / "models", folder / split):
            if not needed.is_dir():
                raise FileNotFoundError(f"{needed} is no folder: expected a data set in BOP's layout")
        self._folder = folder
        self._split = split
        self._scenes: dict[int, Scene] = {}
        self._meshes: dict[int, Mesh] = {}
        self._camera_file = folder / "camera.json"
        self._camera_size: tuple[int, int] | None = None

    @property
    def scene_ids(self) -> list[int]:
        """The scenes, rising."""
        return sorted(int(path.name) for path in (self._folder / self._split).iterdir() if is_whole(path.name))

    def scene(self, scene_id: int) -> Scene:
        """A scene, read once."""
        if scene_id not in self._scenes:
            folder = self._folder / self._split / f"{scene_id:06d}"
            truth, info = folder / "scene_gt.json", folder / "scene_gt_info.json"
            self._scenes[scene_id] = Scene(
                folder,
                read_scene_camera(folder / "scene_camera.json"),
                read_scene_gt(truth) if truth.exists() else None,
                read_scene_gt_info(info) if info.exists() else None,
            )
        return self._scenes[scene_id]

    def mesh(self, obj_id: int) -> Mesh:
        """The mesh of an object, read once.

        Raises:
            InvalidFileError: If there is no such object, or its file is malformed.
        """
        if obj_id not in self._meshes:
            path = self._folder / "models" / f"obj_{obj_id:06d}.ply"
            if not path.exists():
                available = ", ".join(sorted(other.name for other in path.parent.glob("obj_*.ply"))) or "none"
                raise InvalidFileError(
                    f"{path} does not exist: expected the model of the object {obj_id}, got {available[:80]}"
                )
            self._meshes[obj_id] = read_model(path)
        return self._meshes[obj_id]

    def models(self) -> dict[int, ModelInfo]:
        """What is known of the objects.

        Raises:
            InvalidFileError: If there is no such file, or it is malformed.
        """
        return read_models_info(self._folder / "models" / "models_info.json")

    @property
    def has_models_info(self) -> bool:
        """Whether there is a file of what is known of the objects."""
        return (self._folder / "models" / "models_info.json").exists()

    def image_size(self, scene_id: int, im_id: int) -> tuple[int, int]:
        """Height and width of an image, pixels: those of its picture, or else of the data set's camera.json.

        Raises:
            InvalidFileError: If there is neither.
        """
        size = self.known_image_size(scene_id, im_id)
        if size is None:
            raise InvalidFileError(
                f"{self._folder}: expected the size of image {im_id} of scene {scene_id}, from camera.json "
                "(width, height) or a picture rgb, gray or depth, .png"
            )
        return size

    def photo(self, scene_id: int, im_id: int) -> NDArray[np.uint8] | None:
        """The picture of an image, (H, W, 3), RGB, of rgb or gray, .png, .jpg or .tif; None where there is none.

        Raises:
            InvalidFileError: If it is no picture.
        """
        for kind in ("rgb", "gray"):
            for ending in ("png", "jpg", "tif"):
                path = self.scene(scene_id).folder / kind / f"{im_id:06d}.{ending}"
                if path.exists():
                    return read_photo(path)
        return None

    def known_image_size(self, scene_id: int, im_id: int) -> tuple[int, int] | None:
        """Height and width of an image, pixels; None where nothing tells them."""
        for kind in ("rgb", "gray", "depth"):
            picture = self.scene(scene_id).folder / kind / f"{im_id:06d}.png"
            if picture.exists():
                return png_size(picture)
        if self._camera_size is None and self._camera_file.exists():
            camera = read_json(self._camera_file)
            self._camera_size = camera["height"].identifier(), camera["width"].identifier()
        return self._camera_size

    def targets(self) -> set[ImageObject]:
        """What an evaluation looks at: the targets of the split's file, or else every part of every image."""
        path = self._folder / f"{self._split}_targets_bop19.json"
        if path.exists():
            return {ImageObject(target.scene_id, target.im_id, target.obj_id) for target in read_targets(path)}
        return {
            ImageObject(scene_id, im_id, part.obj_id)
            for scene_id in self.scene_ids
            for im_id, parts in (self.scene(scene_id).truths or {}).items()
            for part in parts
        }


class MaskSource(Protocol):
    """Where masks come from."""

    def masks(self, where: ImageObject) -> PackedMasks:
        """The masks of all instances of an object in an image, of the image's size; there may be none.

        Raises:
            InvalidFileError: If there is no mask in all of the scene, so that the images' size is unknown.
        """
        ...


class DetectedMasks:
    """The masks of a detector, in the order of its file.

    Args:
        detections: What it found.
    """

    def __init__(self, detections: Iterable[DetectionResult]) -> None:
        self._found: dict[ImageObject, list[DetectionResult]] = defaultdict(list)
        self._sizes: dict[int, tuple[int, int]] = {}
        for detection in detections:
            self._found[ImageObject(detection.scene_id, detection.im_id, detection.obj_id)].append(detection)
            self._sizes[detection.scene_id] = detection.height, detection.width

    def masks(self, where: ImageObject) -> PackedMasks:
        """The masks of all instances of an object in an image."""
        found = self._found.get(where, [])
        if not found and where.scene_id not in self._sizes:
            raise InvalidFileError(
                f"expected masks of the scene {where.scene_id}, which poses are given for: found none"
            )
        height, width = (found[0].height, found[0].width) if found else self._sizes[where.scene_id]
        return PackedMasks.from_rle([detection.rle for detection in found], height, width)


class SceneMasks:
    """The masks that a data set brings along: the true ones.

    Args:
        dataset: The data set.
        visible: Those of what is visible of the parts, not of all of it.
    """

    def __init__(self, dataset: Dataset, *, visible: bool = True) -> None:
        self._dataset = dataset
        self._visible = visible
        self._size = lru_cache(maxsize=1)(self._size_of_scene)

    def masks(self, where: ImageObject) -> PackedMasks:
        """The masks of all instances of an object in an image."""
        scene = self._dataset.scene(where.scene_id)
        parts = (scene.truths or {}).get(where.im_id, [])
        indices = [index for index, part in enumerate(parts) if part.obj_id == where.obj_id]
        if not indices:
            height, width = self._size(where.scene_id)
            return PackedMasks.pack(np.zeros((0, height, width), dtype=np.bool_))
        masks = [read_mask(self._path(scene, where.im_id, index)) for index in indices]
        sizes = {mask.shape for mask in masks}
        if len(sizes) > 1:
            raise InvalidFileError(
                f"{scene.folder}: image {where.im_id}: expected masks of one size, but found {sorted(sizes)}"
            )
        return PackedMasks.pack(np.array(masks))

    def _path(self, scene: Scene, im_id: int, index: int) -> Path:
        return mask_path(scene.folder, im_id, index, visible=self._visible)

    def _size_of_scene(self, scene_id: int) -> tuple[int, int]:
        scene = self._dataset.scene(scene_id)
        for im_id, parts in (scene.truths or {}).items():
            if parts:
                height, width = read_mask(self._path(scene, im_id, 0)).shape
                return height, width
        raise InvalidFileError(f"{scene.folder / 'scene_gt.json'}: expected a part, whose mask tells the images' size")
