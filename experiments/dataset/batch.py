"""A batch of test images: made, estimated and judged; what remains of an image is a few numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection
from cell.part import Part, pose_error
from experiments.dataset.coco import Annotations, Matches
from experiments.dataset.sources import PictureSet, SeenImage, generated, photographed, poses_alike
from experiments.errors import UsageError
from experiments.setup.methods import Context, make_uncertainty
from experiments.setup.thresholds import Thresholds
from maskval import Estimates, Pose, UncertaintyMethod, add, needs_of
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import PartModel, load_part
from sim.networks.estimators import NETWORKS
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.random_streams import Streams

METHODS = ("maskval", "ensemble-add", "oracle-mask", "oracle-mdd", "random")  # unless others are asked for

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BatchTask:
    """A run of images of one part's set.

    Attributes:
        object: the part's name or file.
        seed: root of the set's random numbers.
        images: their numbers.
        annotated_visibility: least visible share of a part that the detector is asked for.
        methods: names of the methods to judge by.
        pictures: rendered pictures and trained networks; None for generated images and simulated networks.
    """

    object: str
    seed: int
    images: range
    annotated_visibility: float
    methods: tuple[str, ...] = METHODS
    pictures: PictureSet | None = None

    def images_of(self, model: PartModel) -> Iterator[SeenImage]:
        """The images, one after another."""
        if self.pictures is None:
            return generated(model, self.seed, self.images)
        return photographed(model, self.pictures, self.images)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """N poses of P parts in I images, in the order of the images.

    Attributes:
        poses: poses of each image, (I,).
        parts: parts of each image, (I,).
        pose_part: part of each pose, counted in its image, or `NO_INSTANCE`, (N,).
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
    model, latest_truth = load_part(task.object), LatestTruth()
    alike = poses_alike(model, task.pictures)
    methods = make_uncertainties(task.methods, model.part, Streams(task.seed, 0, model.part.name), latest_truth)
    annotations, images = Annotations(), []
    for image in task.images_of(model):
        annotate(annotations, image.truth, image.detections, task.annotated_visibility)
        latest_truth.keep(image.truth)
        images.append(_judge(image, methods, alike))
    return Judged.join(images), annotations.matches()


def annotate(annotations: Annotations, truth: FrameTruth, detections: Sequence[Detection], least: float) -> None:
    """Adds an image to the detector's evaluation, which counts parts whose visible share is at least `least`."""
    seen = [(truth.mask(part), share >= least) for part, share in enumerate(truth.visibility) if share > 0.0]
    annotations.add(seen, [(detection.mask, detection.score) for detection in detections])


def make_uncertainties(
    names: Sequence[str], part: Part, streams: Streams, latest_truth: LatestTruth
) -> dict[str, UncertaintyMethod]:
    """The methods by name, Ensemble-ADD on a scale from 0 m.

    Raises:
        UsageError: a method does not exist, or needs several views of a scene: test images show another one each.
    """
    from_zero = Thresholds("of this set", refine=0.0, grasp={}, ensemble_add_minimum={part.name: 0.0})
    context = Context(part, from_zero, streams, latest_truth)
    made = {name: make_uncertainty(name, context) for name in names}
    for name, method in made.items():
        needs = needs_of(method)
        if needs.X_BC:
            raise UsageError(
                f"{name} needs several views of one scene; expected methods that judge a single test image"
            )
        if needs.estimators > NETWORKS:
            raise UsageError(f"{name} needs {needs.estimators} estimators; expected at most {NETWORKS}, as there are")
    return made


def _judge(image: SeenImage, methods: dict[str, UncertaintyMethod], symmetries: tuple[Pose, ...]) -> Judged:
    truth, (first, second) = image.truth, image.poses
    mesh, camera = truth.mesh, truth.camera
    depth = any(needs_of(method).depth for method in methods.values())
    parts = image.parts
    shown = [truth.X_CO_true[part] if part != NO_INSTANCE else None for part in parts]
    errors = (
        np.inf if X_true is None else pose_error(X_est, X_true, mesh, symmetries)
        for X_est, X_true in zip(first, shown, strict=True)
    )
    masks = np.empty((len(first), camera.height, camera.width), dtype=np.bool_)
    for mask, one in zip(masks, image.detections, strict=True):
        mask[:] = one.mask
    masks.setflags(write=False)
    estimates = Estimates(
        camera=camera,
        mesh=mesh,
        masks=masks,
        poses=image.poses,
        scores=np.array([one.score for one in image.detections]),
        pixel_center=PIXEL_CENTER,
        depth=image.depth() if depth and image.depth is not None else None,
        correspondences=image.correspondences,
        rgb=image.rgb,
    )
    return Judged(
        poses=np.array([len(first)]),
        parts=np.array([len(truth.visibility)]),
        pose_part=np.array(parts, dtype=np.int64),
        mdd_m=np.array(list(errors)),
        disagreement_m=np.array([add(X1, X2, mesh.vertices) for X1, X2 in zip(first, second, strict=True)]),
        u={name: _asked(name, method, estimates) for name, method in methods.items()},
        visibility=truth.visibility,
        in_view=truth.in_view,
    )


def _asked(name: str, method: UncertaintyMethod, estimates: Estimates) -> Array:
    """The method's u.

    Raises:
        UsageError: the method raised, or gives something else than a u for each pose.
    """
    try:
        u = np.array(method(estimates), dtype=np.float64)
    except Exception as error:
        raise UsageError(f"{name} raised {type(error).__name__}: {error}") from error
    if u.shape != (len(estimates),) or not np.all((u >= 0.0) & (u <= 1.0)):
        raise UsageError(f"{name}: expected {len(estimates)} uncertainties in [0, 1], got {u}")
    return u
