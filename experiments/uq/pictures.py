"""Pictures of judged poses: the detection, the projection, and how they overlap."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.observing.drawing import DARK, GREEN, GREY, MASK, MODEL, WHITE, Color, Image, outline, tint, write
from experiments.results.files import replacing
from maskval import UNMATCHED, Camera, PackedMasks, bop, silhouette, silhouette_boxes

T = TypeVar("T", np.bool_, np.uint8)
_PANEL = (360, 480)  # px, height and width
_BAR = 34  # px, of the line of text above a panel
_MARGIN = 0.25  # of the larger side of what is shown, around it
_FARTHEST = 0.5  # of the image's size: what is shown reaches no farther beyond the image


def write_pictures(
    folder: Path,
    dataset: bop.Dataset,
    judged: Sequence[bop.JudgedPose],
    source: bop.MaskSource,
    pixel_center: float,
) -> list[str]:
    """Writes worst.png, median.png and best.png, of the greatest, the middle and the least u; returns their names.

    Args:
        folder: where to.
        dataset: of the poses.
        judged: the poses, at least one.
        source: their masks.
        pixel_center: where pixel i of the masks is sampled.

    Raises:
        UsageError: a file cannot be written.
        MaskvalError: a picture or a mask cannot be read.
    """
    order = sorted(range(len(judged)), key=lambda index: (judged[index].u, index))
    chosen = {"worst": order[-1], "median": order[(len(order) - 1) // 2], "best": order[0]}
    for name, index in chosen.items():
        drawn = panels(dataset, judged[index], source, pixel_center)
        _, encoded = cv2.imencode(".png", cv2.cvtColor(drawn, cv2.COLOR_RGB2BGR))
        with replacing(folder / f"{name}.png") as file:
            file.write(encoded.tobytes())
    return [f"{name}.png" for name in chosen]


def panels(dataset: bop.Dataset, judged: bop.JudgedPose, source: bop.MaskSource, pixel_center: float) -> Image:
    """The three panels of a pose beside each other, RGB."""
    result = judged.result
    masks = source.masks(bop.ImageObject(result.scene_id, result.im_id, result.obj_id))
    camera = dataset.scene(result.scene_id).camera(result.im_id).camera(masks.width, masks.height)
    mesh = dataset.mesh(result.obj_id)
    mask = _mask_of(judged, masks)
    (box,) = silhouette_boxes(mesh, [result.X_CO], camera, pixel_center=pixel_center)
    window = _window(mask, box, camera)
    left, top, right, bottom = window
    moved = Camera(camera.fx, camera.fy, camera.cx - left, camera.cy - top, right - left, bottom - top, camera.skew)
    seen = silhouette(mesh, result.X_CO, moved, pixel_center=pixel_center).mask
    detected, photo = _cut(mask, window), _cut(_photo(dataset, judged, camera), window)
    inside = _cut(np.ones(mask.shape, dtype=np.bool_), window)
    photo[~inside] = DARK
    where = f"scene {result.scene_id}, image {result.im_id}, object {result.obj_id}"
    numbers = f"c {judged.c:.3f}   v {judged.v:.3f}   u {judged.u:.3f}"
    return np.concatenate(
        [
            _panel(photo, [(detected, MASK)], f"detection: {where}" if mask.any() else f"no detection: {where}"),
            _panel(photo, [(seen, MODEL)], "projection of the model"),
            _panel(photo, [(detected & ~seen, MASK), (seen & ~detected, MODEL), (detected & seen, GREEN)], numbers),
        ],
        axis=1,
    )


def _mask_of(judged: bop.JudgedPose, masks: PackedMasks) -> NDArray[np.bool_]:
    """The mask that a pose was matched to, (H, W); an empty one where there is none."""
    if judged.mask == UNMATCHED:
        return np.zeros((masks.height, masks.width), dtype=np.bool_)
    return np.asarray(masks.unpack()[judged.mask])


def _photo(dataset: bop.Dataset, judged: bop.JudgedPose, camera: Camera) -> Image:
    photo = dataset.photo(judged.result.scene_id, judged.result.im_id)
    if photo is None or photo.shape[:2] != (camera.height, camera.width):
        return np.full((camera.height, camera.width, 3), GREY, dtype=np.uint8)
    return photo


def _window(mask: NDArray[np.bool_], box: NDArray[np.int64], camera: Camera) -> tuple[int, int, int, int]:
    """Left, top, right and bottom of what is shown: the mask and the whole silhouette, in the panels' shape."""
    rows, columns = np.nonzero(mask)
    corners = [(box[0], box[1]), (box[0] + box[2], box[1] + box[3])] if box[2] else []
    corners += [(columns.min(), rows.min()), (columns.max() + 1, rows.max() + 1)] if len(rows) else []
    size = np.array((camera.width, camera.height))
    low, high = (np.min(corners, axis=0), np.max(corners, axis=0)) if corners else (np.zeros(2), size)
    low, high = np.maximum(low, -_FARTHEST * size), np.minimum(high, (1 + _FARTHEST) * size)
    middle, sides = (low + high) / 2, np.maximum(high - low, 8) * (1 + 2 * _MARGIN)
    height = max(sides[1], sides[0] * _PANEL[0] / _PANEL[1])
    half = np.array((height * _PANEL[1] / _PANEL[0], height)) / 2
    left, top = np.floor(middle - half).astype(int)
    right, bottom = np.ceil(middle + half).astype(int)
    return int(left), int(top), int(right), int(bottom)


def _cut(image: NDArray[T], window: tuple[int, int, int, int]) -> NDArray[T]:
    """The window of an image, with nothing where it reaches beyond."""
    left, top, right, bottom = window
    cut = np.zeros((bottom - top, right - left, *image.shape[2:]), dtype=image.dtype)
    a, b, c, d = max(left, 0), max(top, 0), min(right, image.shape[1]), min(bottom, image.shape[0])
    if a < c and b < d:
        cut[b - top : d - top, a - left : c - left] = image[b:d, a:c]
    return cut


def _panel(photo: Image, shapes: Sequence[tuple[NDArray[np.bool_], Color]], text: str) -> Image:
    image = np.asarray(cv2.resize(photo, _PANEL[::-1], interpolation=cv2.INTER_NEAREST), dtype=np.uint8)
    for shape, color in shapes:
        large = cv2.resize(shape.astype(np.uint8), _PANEL[::-1], interpolation=cv2.INTER_NEAREST) > 0
        tint(image, large, color)
        outline(image, large, color, 2)
    panel = np.full((_PANEL[0] + _BAR, _PANEL[1], 3), DARK, dtype=np.uint8)
    panel[_BAR:] = image
    write(panel, text, (8, _BAR - 11), height=13, color=WHITE, width=_PANEL[1] - 16)
    panel[:, -2:] = DARK
    return panel
