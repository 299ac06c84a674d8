"""The figures that a set of parameters gives on the images of a fit: worked out by a worker process, which keeps them.

Images and their random numbers do not depend on the parameters, detections depend on the detector's alone: a worker
makes them once and keeps the newest.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cell.layout import default_camera
from cell.part import pose_error
from experiments.dataset.batch import annotate
from experiments.dataset.coco import Annotations, MaskFigures, mask_figures
from experiments.dataset.metrics import Figures, figures, from_least
from experiments.dataset.rules import ANNOTATED_VISIBILITY, Rules
from maskval import ImageErrors, PackedMasks, add, match_images, uncertainty
from sim.images.generated import Recipe, make_image
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import load_part
from sim.networks.ground_truth import FrameTruth
from sim.networks.image_estimates import ImageLatents, detect, draw_latents, estimate
from sim.networks.noise_model import MaskNoise, PartNoise, PoseNoise
from sim.networks.random_streams import Streams

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class ImageSet:
    """Which images: a part's name or file, the root of their random numbers, how many."""

    part: str
    seed: int
    images: int


@dataclass(frozen=True, slots=True)
class ErrorModelTrial:
    """An error model to be tried on a set of images; `methods` asks for the methods' figures as well."""

    images: ImageSet
    noise: PartNoise
    methods: bool


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """An image with its random numbers."""

    truth: FrameTruth
    latents: ImageLatents


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """N detections of an image.

    Attributes:
        masks: packed.
        parts: the part that each shows, or `NO_INSTANCE`.
        false: the masks of those that show none, by index.
    """

    masks: PackedMasks
    parts: tuple[int, ...]
    false: dict[int, Mask]


def run_trial(trial: ErrorModelTrial) -> tuple[MaskFigures, dict[str, Figures]]:
    """The detector's figures, and each method's if they are asked for."""
    found, of_masks = _detections(trial.images, trial.noise.mask)
    return of_masks, _method_figures(trial.images, found, trial.noise.pose) if trial.methods else {}


@lru_cache(maxsize=1)
def _images(images: ImageSet) -> list[Image]:
    model, camera = load_part(images.part), default_camera()
    kept = []
    for number in range(images.images):
        streams = Streams(images.seed, number, model.part.name)
        truth = make_image(model.part.mesh, camera, Recipe(), streams).truth
        kept.append(Image(truth, draw_latents(truth, streams)))
    return kept


@lru_cache(maxsize=1)
def _detections(images: ImageSet, noise: MaskNoise) -> tuple[list[Found], MaskFigures]:
    annotations, found = Annotations(), []
    for image in _images(images):
        detections = detect(image.truth, image.latents, noise)
        annotate(annotations, image.truth, detections, ANNOTATED_VISIBILITY)
        found.append(_packed(image.truth, [detection.mask for detection in detections]))
    return found, mask_figures(annotations.matches())


def _packed(truth: FrameTruth, masks: list[Mask]) -> Found:
    parts = tuple(truth.shown_by(mask) for mask in masks)
    stack = np.array(masks, dtype=np.bool_).reshape(-1, *truth.instance_ids.shape)
    false = {index: masks[index] for index, part in enumerate(parts) if part == NO_INSTANCE}
    return Found(PackedMasks.pack(stack), parts, false)


def _method_figures(images: ImageSet, found: list[Found], noise: PoseNoise) -> dict[str, Figures]:
    part_kind, camera = load_part(images.part).part, default_camera()
    mesh = part_kind.mesh
    errors, u, disagreement_m = [], [], []
    for image, one in zip(_images(images), found, strict=True):
        first, second = estimate(image.truth, image.latents, one.false, one.parts, noise)
        table = np.full((len(one.parts), len(image.truth.X_CO_true)), np.inf)
        for index, part in enumerate(one.parts):
            if part != NO_INSTANCE:
                table[index, part] = pose_error(first[index], image.truth.X_CO_true[part], mesh, part_kind.symmetries)
        errors.append(ImageErrors(table, np.zeros(len(first)), image.truth.visibility))
        u.append(uncertainty(mesh, first, one.masks, camera, pixel_center=PIXEL_CENTER).u)
        disagreement_m += [add(X1, X2, mesh.vertices) for X1, X2 in zip(first, second, strict=True)]
    matched = match_images(errors)
    sets = {"maskval": np.concatenate(u), "ensemble-add": from_least(np.array(disagreement_m))}
    return {method: figures(replace(matched, u=values), Rules()) for method, values in sets.items()}
