"""A batch of test images: made, estimated and judged; what remains of an image is a few numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cell.layout import default_camera
from experiments.dataset_coco import Annotations, Matches
from maskval import Camera, Estimates, MaskVal, Mesh, add, mdd
from maskval.ensemble import ENSEMBLE_MAXIMUM_M
from sim.dataset import ImageTruth, Recipe, make_image
from sim.dataset_estimates import ImageEstimates, estimate_image
from sim.latents import Streams
from sim.noise import load_noise
from sim.part_numbers import NOTHING, PIXEL_CENTER
from sim.parts import load_part

Array = NDArray[np.float64]
ERROR_THRESHOLD_M = 0.015  # the paper's e_t for its robot


@dataclass(frozen=True, slots=True)
class BatchTask:
    """A run of images of one part's set.

    Attributes:
        object: the part's name or file.
        seed: root of the set's random numbers.
        images: their numbers.
        annotated_visibility: least visible share of a part that the detector is asked for.
    """

    object: str
    seed: int
    images: range
    annotated_visibility: float


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """N poses of P parts in I images, in the order of the images.

    Attributes:
        poses: poses of each image, (I,).
        parts: parts of each image, (I,).
        pose_part: part of each pose, counted in its image, or `NOTHING`, (N,).
        mdd_m: error of each pose, infinite without a part, (N,).
        disagreement_m: ADD between S1 and S2, (N,).
        u: uncertainty of each pose by the method's name, (N,) each; Ensemble-ADD's on a scale from 0 m.
        visibility: visible share of each part, (P,).
        in_view: share of each part inside the image, (P,).
    """

    poses: NDArray[np.int64]
    parts: NDArray[np.int64]
    pose_part: NDArray[np.int64]
    mdd_m: Array
    disagreement_m: Array
    u: dict[str, Array]
    visibility: Array
    in_view: Array

    @classmethod
    def join(cls, runs: Sequence[Self]) -> Self:
        """Runs of images, one after the other."""
        return cls(
            poses=np.concatenate([run.poses for run in runs]),
            parts=np.concatenate([run.parts for run in runs]),
            pose_part=np.concatenate([run.pose_part for run in runs]),
            mdd_m=np.concatenate([run.mdd_m for run in runs]),
            disagreement_m=np.concatenate([run.disagreement_m for run in runs]),
            u={method: np.concatenate([run.u[method] for run in runs]) for method in runs[0].u},
            visibility=np.concatenate([run.visibility for run in runs]),
            in_view=np.concatenate([run.in_view for run in runs]),
        )


def run_batch(task: BatchTask) -> tuple[Judged, Matches]:
    """What is known of the images of a task: a function of its fields, whatever is asked for beside it."""
    model, camera = load_part(task.object), default_camera()
    noise, mesh = load_noise(model.noise), model.part.mesh
    annotations, images = Annotations(), []
    for number in task.images:
        streams = Streams(task.seed, number, model.part.name)
        truth = make_image(mesh, camera, Recipe(), streams)
        estimates = estimate_image(truth, mesh, camera, noise, streams)
        _annotate(annotations, truth, estimates, task.annotated_visibility)
        images.append(_judge(truth, estimates, mesh, camera, streams))
    return Judged.join(images), annotations.matches()


def _annotate(annotations: Annotations, truth: ImageTruth, estimates: ImageEstimates, least: float) -> None:
    seen = [(truth.mask(part), share >= least) for part, share in enumerate(truth.visibility) if share > 0.0]
    annotations.add(seen, [(detection.mask, detection.score) for detection in estimates.detections])


def _judge(truth: ImageTruth, estimates: ImageEstimates, mesh: Mesh, camera: Camera, streams: Streams) -> Judged:
    first, second = estimates.poses
    shown = [truth.X_CO_true[part] if part != NOTHING else None for part in estimates.parts]
    detected = [detection.mask for detection in estimates.detections]
    # No pixel shows the part number below NOTHING: the true mask of what shows no part is empty.
    true = [truth.mask(part if part != NOTHING else NOTHING - 1) for part in estimates.parts]
    mdd_m = np.array(
        [
            np.inf if X_true is None else mdd(X_est, X_true, mesh.vertices)
            for X_est, X_true in zip(first, shown, strict=True)
        ]
    )
    disagreement_m = np.array([add(X1, X2, mesh.vertices) for X1, X2 in zip(first, second, strict=True)])
    return Judged(
        poses=np.array([len(first)]),
        parts=np.array([len(truth.visibility)]),
        pose_part=np.array(estimates.parts, dtype=np.int64),
        mdd_m=mdd_m,
        disagreement_m=disagreement_m,
        u={
            "maskval": _maskval(detected, estimates, mesh, camera),
            "ensemble-add": np.minimum(disagreement_m / ENSEMBLE_MAXIMUM_M, 1.0),
            "oracle-mask": _maskval(true, estimates, mesh, camera),
            # Any rising function of the error is the perfect method; this one is 1/2 at e_t and 1 without a part.
            "oracle-mdd": 1.0 - ERROR_THRESHOLD_M / (ERROR_THRESHOLD_M + mdd_m),
            "random": streams.generator(0, "dataset random u").uniform(size=len(first)),
        },
        visibility=truth.visibility,
        in_view=truth.in_view,
    )


def _maskval(masks: list[NDArray[np.bool_]], estimates: ImageEstimates, mesh: Mesh, camera: Camera) -> Array:
    stack = np.array(masks, dtype=np.bool_).reshape(-1, camera.height, camera.width)
    scores = np.array([detection.score for detection in estimates.detections])
    return MaskVal()(Estimates(camera, mesh, stack, estimates.poses[:1], scores, PIXEL_CENTER))
