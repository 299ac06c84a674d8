"""The files of rendered pictures in BOP's layout."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.results.provenance import write_json
from maskval import Camera, bop, silhouette, silhouette_boxes
from sim.images.pictures import LabelledPicture
from sim.instance_ids import PIXEL_CENTER
from sim.model.parts import PartModel
from sim.networks.ground_truth import FrameTruth
from sim.parts.turns import model_symmetries

OBJECT = 1  # the part's number in the dataset
DEPTH_SCALE = 0.1  # mm for each step of the depth images, which then reach 6.5 m: farther than a room's corner
_NO_BOX = (-1, -1, -1, -1)  # BOP's, of what is not to be seen


@dataclass(frozen=True, slots=True)
class Labels:
    """What BOP's files say of a picture; the parts' order is that of their masks."""

    camera: bop.ImageCamera
    truths: list[bop.GroundTruth]
    infos: list[bop.GroundTruthInfo]


def write_models(folder: Path, models: Mapping[int, PartModel], camera: Camera) -> None:
    """Writes `models/`, with the mesh of a part for each number of an object, and `camera.json`."""
    infos = {}
    for number, model in models.items():
        mesh = model.part.mesh
        bop.write_model(folder / "models" / f"obj_{number:06d}.ply", mesh)
        infos[number] = mesh, bop.ModelInfo(mesh.diameter, *model_symmetries(model.symmetries, mesh))
    bop.write_models_info(folder / "models" / "models_info.json", infos)
    intrinsics = {name: getattr(camera, name) for name in ("cx", "cy", "fx", "fy", "height", "width")}
    write_json(folder / "camera.json", {**intrinsics, "depth_scale": DEPTH_SCALE})


def write_picture(scene: Path, im_id: int, picture: LabelledPicture, rgb_format: str = "png") -> Labels:
    """Writes the images of a picture; returns what the scene's JSON files say of it.

    Args:
        scene: Folder of the scene, with its `rgb`.
        im_id: The picture's number in it.
        picture: The picture.
        rgb_format: Ending of the RGB file: png, or jpg of quality 95.

    Raises:
        OSError: an image could not be written.
    """
    write_rgb(scene / "rgb" / f"{im_id:06d}.{rgb_format}", picture.rgb)
    bop.write_depth(scene / "depth" / f"{im_id:06d}.png", picture.depth, DEPTH_SCALE)
    camera = bop.ImageCamera(picture.truth.camera.K, DEPTH_SCALE, picture.X_CW)
    return Labels(camera, *write_parts(scene, im_id, picture.truth, measured=picture.depth > 0))


def write_rgb(path: Path, rgb: NDArray[np.uint8]) -> None:
    """Writes a picture in the format of the path's ending; its folder exists.

    Raises:
        OSError: it could not be written.
    """
    if not cv2.imwrite(str(path), cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)):
        raise OSError(f"{path} could not be written")


def write_parts(
    scene: Path,
    im_id: int,
    truth: FrameTruth,
    parts: Sequence[int] | None = None,
    *,
    number: int = OBJECT,
    measured: NDArray[np.bool_],
) -> tuple[list[bop.GroundTruth], list[bop.GroundTruthInfo]]:
    """Writes the masks of parts; returns what the scene's JSON files say of them.

    Args:
        scene: Folder of the scene.
        im_id: The picture's number in it.
        truth: What the picture shows.
        parts: Those to write; all by default.
        number: Of the object in the dataset.
        measured: Where depth was measured, (H, W).
    """
    chosen = range(len(truth.X_CO_true)) if parts is None else parts
    boxes = silhouette_boxes(truth.mesh, truth.X_CO_true, truth.camera, pixel_center=PIXEL_CENTER)
    infos = []
    for place, part in enumerate(chosen):
        whole = silhouette(truth.mesh, truth.X_CO_true[part], truth.camera, pixel_center=PIXEL_CENTER)
        visible = truth.mask(part) & whole.mask
        bop.write_mask(bop.mask_path(scene, im_id, place, visible=False), whole.mask)
        bop.write_mask(bop.mask_path(scene, im_id, place), visible)
        infos.append(_info(whole.area_px, boxes[part], visible, whole.mask & measured))
    return [bop.GroundTruth(number, truth.X_CO_true[part]) for part in chosen], infos


def write_scene(scene: Path, labels: Mapping[int, Labels]) -> None:
    """Writes the JSON files of a scene, by number of the picture."""
    bop.write_scene_camera(scene / "scene_camera.json", {im_id: one.camera for im_id, one in labels.items()})
    bop.write_scene_gt(scene / "scene_gt.json", {im_id: one.truths for im_id, one in labels.items()})
    bop.write_scene_gt_info(scene / "scene_gt_info.json", {im_id: one.infos for im_id, one in labels.items()})


def targets(
    scene_id: int, labels: Mapping[int, Labels], least: float = 0.1, number: int = OBJECT
) -> list[bop.EvaluationTarget]:
    """What an evaluation asks for: the parts of which at least this share is visible (BOP: 0.1), by picture.

    Args:
        scene_id: The scene.
        labels: Of its pictures.
        least: Visible share.
        number: Of the object that the scene shows.
    """
    counts = {im_id: sum(info.visib_fract >= least for info in one.infos) for im_id, one in labels.items()}
    return [bop.EvaluationTarget(scene_id, im_id, number, count) for im_id, count in counts.items() if count]


def _info(
    area_px: int, box: NDArray[np.int64], visible: NDArray[np.bool_], measured: NDArray[np.bool_]
) -> bop.GroundTruthInfo:
    visible_px = int(np.count_nonzero(visible))
    return bop.GroundTruthInfo(
        bbox_obj=_bop_box(box.tolist()) if visible_px else _NO_BOX,
        bbox_visib=_bop_box(cv2.boundingRect(visible.astype(np.uint8))) if visible_px else _NO_BOX,
        px_count_all=area_px,
        px_count_valid=int(np.count_nonzero(measured)),
        px_count_visib=visible_px,
        visib_fract=visible_px / area_px if area_px else 0.0,
    )


def _bop_box(box: Sequence[int]) -> tuple[int, int, int, int]:
    """As BOP's toolkit writes a box: its width is the last column less the first, one less than its columns."""
    left, top, width, height = box
    return left, top, width - 1, height - 1
