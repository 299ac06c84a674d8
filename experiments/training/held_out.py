"""What the trained networks make of pictures that they were not trained on; the fusion's weight is found there."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

from experiments.training.pictures import SeenPart, TruePicture
from maskval import Pose, mask_iou
from maskval.pose_errors import mssd
from sim.learned.coordinates import Maps, ObjectCoordinates, estimate_of
from sim.learned.crops import CropView
from sim.learned.estimators import find, look
from sim.learned.weights import DETECTOR, STYLES, Network, open_network
from sim.model.parts import PartModel

WEIGHTS = (0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3)  # of a correspondence, that are tried
LEAST_VISIBILITY = 0.6  # of the parts that count
GOOD_M = 0.015  # the paper's e_t
_MATCH = 0.5  # IoU of a mask with that of the part that it is of

Errors = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What was found on held-out pictures.

    Attributes:
        weights: of a correspondence, by style.
        figures: of each network, for people.
        detector_s: inference time per picture, s of processor time.
        pose_s: of a pose network with PnP, s per picture.
    """

    weights: dict[str, float]
    figures: dict[str, dict[str, float]]
    detector_s: float
    pose_s: float


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """A crop around the true mask, what a network says of it, and the true pose."""

    view: CropView
    maps: Maps
    X_CO_true: Pose


def measure(folder: Path, pictures: Sequence[TruePicture], model: PartModel, alike: Sequence[Pose]) -> Found:
    """Measures the networks of a folder.

    Args:
        folder: with the three networks.
        pictures: held-out ones.
        model: the part.
        alike: the poses that it looks alike in.
    """
    weights, figures, pose_s = {}, {}, []
    for style in STYLES:
        network = open_network(folder / f"{style}.onnx")
        start = process_time()
        looks = _looks(network, pictures)
        looked = process_time()
        errors = {weight: _errors_m(looks, model, alike, weight) for weight in WEIGHTS}
        solved_s = (process_time() - looked) / len(WEIGHTS)
        pose_s.append((looked - start + solved_s) / len(pictures))
        best = min(WEIGHTS, key=lambda weight: round(float(np.median(errors[weight])), 6))
        weights[style], figures[style] = best, _pose_figures(errors[best])
    start = process_time()
    figures[DETECTOR] = _detector_figures(open_network(folder / f"{DETECTOR}.onnx"), pictures)
    return Found(weights, figures, (process_time() - start) / len(pictures), float(np.mean(pose_s)))


def _counted(picture: TruePicture) -> list[SeenPart]:
    return [part for part in picture.parts if part.visibility >= LEAST_VISIBILITY]


def _looks(network: Network, pictures: Sequence[TruePicture]) -> list[_Look]:
    looks = []
    for picture in pictures:
        parts = _counted(picture)
        if parts:
            seen = look(network, picture.rgb, picture.camera, [part.mask for part in parts])
            looks += [_Look(view, maps, part.X_CO) for (view, maps), part in zip(seen, parts, strict=True)]
    return looks


def _errors_m(looks: Sequence[_Look], model: PartModel, alike: Sequence[Pose], weight: float) -> Errors:
    mesh = model.part.mesh
    coordinates = ObjectCoordinates.of(mesh, model.part.symmetries)
    return np.array(
        [
            mssd(estimate_of(one.maps, one.view, coordinates, weight).X_CO_est, one.X_CO_true, mesh.vertices, alike)
            for one in looks
        ]
    )


def _pose_figures(errors_m: Errors) -> dict[str, float]:
    return {
        "parts": float(len(errors_m)),
        "median_mm": 1000.0 * float(np.median(errors_m)),
        "share_within_15_mm": float(np.mean(errors_m <= GOOD_M)),
    }


def _detector_figures(detector: Network, pictures: Sequence[TruePicture]) -> dict[str, float]:
    """How many of the counted parts are found, how well, and how many masks show none."""
    best, wrong, detected = [], 0, 0
    for picture in pictures:
        masks = [found.mask for found in find(detector, picture.rgb)]
        overlaps = np.array([[mask_iou(mask, part.mask) for part in picture.parts] for mask in masks])
        overlaps = overlaps.reshape(len(masks), len(picture.parts))
        wrong += int(np.count_nonzero(overlaps.max(axis=1, initial=0.0) < _MATCH))
        detected += len(masks)
        counted = [part.visibility >= LEAST_VISIBILITY for part in picture.parts]
        best += overlaps.max(axis=0, initial=0.0)[counted].tolist()
    found = np.array(best) >= _MATCH
    return {
        "parts": float(len(best)),
        "found": float(np.mean(found)),
        "median_iou_of_found": float(np.median(np.array(best)[found])) if found.any() else 0.0,
        "share_of_masks_without_part": wrong / max(detected, 1),
    }
