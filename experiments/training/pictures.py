"""Rendered pictures with the truth about their parts, as BOP datasets hold them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Pose, bop
from maskval.bop.images import mask_path, read_mask
from maskval.symmetry import symmetry_poses
from sim.model.parts import PartModel
from sim.parts.turns import model_symmetries

_TURN_STEP = 0.2  # diameters that the farthest vertex moves from one to the next


@dataclass(frozen=True, slots=True, eq=False)
class SeenPart:
    """A part in a picture: its pose X_CO, how much of it is visible, and the mask of that, (H, W)."""

    X_CO: Pose
    visibility: float
    mask: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class TruePicture:
    """A picture: RGB (H, W, 3), its camera, and the parts in it of which something is visible."""

    rgb: NDArray[np.uint8]
    camera: Camera
    parts: tuple[SeenPart, ...]


def looks_alike(model: PartModel) -> tuple[Pose, ...]:
    """The poses X_OO that a part looks alike in, the identity first; of turns about an axis, some."""
    return symmetry_poses(*model_symmetries(model.symmetries, model.part.mesh), maximum_step=_TURN_STEP)


def read_pictures(folder: Path, split: str) -> Iterator[TruePicture]:
    """The pictures of a split, one after another.

    Raises:
        InvalidFileError: a file is missing or malformed.
    """
    dataset = bop.Dataset(folder, split=split)
    for scene_id in dataset.scene_ids:
        scene = dataset.scene(scene_id)
        assert scene.truths is not None
        assert scene.infos is not None
        for im_id, truths in scene.truths.items():
            rgb = dataset.photo(scene_id, im_id)
            if rgb is None:
                raise FileNotFoundError(f"{scene.folder}: expected a picture of image {im_id}, got none")
            camera = scene.cameras[im_id].camera(rgb.shape[1], rgb.shape[0])
            parts = tuple(
                SeenPart(truth.X_CO, info.visib_fract, read_mask(mask_path(scene.folder, im_id, index)))
                for index, (truth, info) in enumerate(zip(truths, scene.infos[im_id], strict=True))
                if info.px_count_visib > 0
            )
            yield TruePicture(rgb, camera, parts)
