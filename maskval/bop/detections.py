"""Detections with masks as BOP's results JSON of 2022, after COCO: one object for each detection.

A whole file in COCO's layout is read too.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maskval.bop.coco import annotations
from maskval.bop.fields import Entry, read_json, warn_of_scores, write_entries
from maskval.errors import InvalidFileError, InvalidMaskError
from maskval.masks import mask_from_polygons, mask_from_rle, rle_counts

ImageSize = Callable[[int, int], tuple[int, int]]  # height and width of the image of a scene and an image id, pixels


@dataclass(frozen=True, slots=True, eq=False)
class DetectionResult:
    """An instance that a detector found; its mask is unpacked when it is asked for.

    Args:
        scene_id: Scene.
        im_id: Image in the scene (image_id in the file).
        obj_id: Object (category_id in the file).
        score: Confidence; high is good.
        rle: COCO's run lengths of the mask, not compressed.
        height: Image height, pixels.
        width: Image width, pixels.
        time_s: Time that the detector took for all of the image, seconds, or -1.
    """

    scene_id: int
    im_id: int
    obj_id: int
    score: float
    rle: tuple[int, ...]
    height: int
    width: int
    time_s: float = -1.0

    @property
    def mask(self) -> NDArray[np.bool_]:
        """The mask, (H, W)."""
        return mask_from_rle(self.rle, self.height, self.width)


def read_detections(path: Path, image_size: ImageSize | None = None) -> list[DetectionResult]:
    """The detections of a results file, their masks as run lengths, plain or compressed, or as polygons.

    Args:
        path: The JSON file: a list of detections, or a whole file in COCO's layout. In the latter, the file_name of an
            image tells scene and image, category_id is the object, and the score is 1 where there is none.
        image_size: What tells the size of an image, which polygons are drawn into: `Dataset.image_size`. A file in
            COCO's layout tells it itself.

    Raises:
        InvalidFileError: If an entry is malformed or stands there twice, its run lengths do not fill the image, or
            there are polygons and nothing tells the image's size.
    """
    found: list[DetectionResult] = []
    first: dict[tuple[object, ...], int] = {}
    for index, (entry, one) in enumerate(_each(read_json(path), path, image_size)):
        key = (one.scene_id, one.im_id, one.obj_id, one.score, one.rle)
        if (before := first.setdefault(key, index)) != index:
            raise InvalidFileError(f"{entry.place}: expected each detection once, but this is the one at [{before}]")
        found.append(one)
    warn_of_scores(path, [one.score for one in found])
    return found


def write_detections(path: Path, detections: Iterable[DetectionResult]) -> None:
    """Writes detections as bop_toolkit reads them; each box is that of its mask.

    Args:
        path: The JSON file.
        detections: The detections.
    """
    write_entries(
        path,
        [
            {
                "scene_id": d.scene_id,
                "image_id": d.im_id,
                "category_id": d.obj_id,
                "score": d.score,
                "bbox": _box(d.mask),
                "segmentation": {"counts": list(d.rle), "size": [d.height, d.width]},
                "time": d.time_s,
            }
            for d in detections
        ],
    )


def _each(root: Entry, path: Path, image_size: ImageSize | None) -> Iterator[tuple[Entry, DetectionResult]]:
    if "annotations" in root:
        for one in annotations(root, path):
            score = one.entry["score"].number() if "score" in one.entry else 1.0
            yield one.entry, _detection(one.entry, one.scene_id, one.im_id, score, one.size)
    else:
        for entry in root.elements():
            scene_id, im_id = entry["scene_id"].identifier(), entry["image_id"].identifier()
            size = None
            if isinstance(entry["segmentation"].value, list) and image_size is not None:
                size = image_size(scene_id, im_id)
            yield entry, _detection(entry, scene_id, im_id, entry["score"].number(), size)


def _detection(entry: Entry, scene_id: int, im_id: int, score: float, size: tuple[int, int] | None) -> DetectionResult:
    """The detection of an entry; polygons are drawn into an image of this size, (height, width)."""
    obj_id, segmentation = entry["category_id"].identifier(), entry["segmentation"]
    if isinstance(segmentation.value, list):
        if size is None:
            raise segmentation.error("run lengths, or image_size for polygons")
        rle = _run_lengths_of_polygons(segmentation, *size)
    else:
        size, rle = _run_lengths(segmentation)
    time_s = entry["time"].number() if "time" in entry else -1.0
    if time_s < 0 and time_s != -1:
        raise entry["time"].error("seconds >= 0, or -1")
    return DetectionResult(scene_id, im_id, obj_id, score, rle, *size, time_s)


def _run_lengths(segmentation: Entry) -> tuple[tuple[int, int], tuple[int, ...]]:
    """Height and width, and the run lengths."""
    size = [element.integer() for element in segmentation["size"].elements()]
    counts = segmentation["counts"]
    if len(size) != 2:
        raise segmentation["size"].error("height and width")
    if not isinstance(counts.value, list | str):
        raise counts.error("run lengths, a list of whole numbers or COCO's compressed text")
    given = counts.value if isinstance(counts.value, str) else [element.integer() for element in counts.elements()]
    try:
        rle = tuple(rle_counts(mask_from_rle(given, size[0], size[1])))
    except InvalidMaskError as error:
        raise InvalidFileError(f"{counts.place}: {error}") from error
    return (size[0], size[1]), rle


def _run_lengths_of_polygons(segmentation: Entry, height: int, width: int) -> tuple[int, ...]:
    polygons = [[number.number() for number in polygon.elements()] for polygon in segmentation.elements()]
    try:
        return tuple(rle_counts(mask_from_polygons(polygons, height, width)))
    except InvalidMaskError as error:
        raise InvalidFileError(f"{segmentation.place}: {error}") from error


def detection_of_mask(scene_id: int, im_id: int, obj_id: int, score: float, mask: NDArray[np.bool_]) -> DetectionResult:
    """The detection of a mask, (H, W)."""
    return DetectionResult(scene_id, im_id, obj_id, score, tuple(rle_counts(mask)), mask.shape[0], mask.shape[1])


def _box(mask: NDArray[np.bool_]) -> list[int]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if len(rows) == 0:
        return [-1, -1, -1, -1]
    left, top = int(columns[0]), int(rows[0])
    return [left, top, int(columns[-1]) + 1 - left, int(rows[-1]) + 1 - top]
