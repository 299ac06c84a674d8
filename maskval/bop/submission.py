"""The uncertainty of every pose of a BOP submission, and what it is worth where the true poses are known."""

import math
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from maskval.association import Rule
from maskval.bop.dataset import Dataset, ImageObject, MaskSource
from maskval.bop.results import PoseResult
from maskval.errors import ImplausibleInputError, ImplausibleInputWarning, InvalidFileError, MaskvalError
from maskval.evaluation.matching import Evaluation, ImageErrors, match_images
from maskval.geometry import Pose
from maskval.masks import PackedMasks
from maskval.methods.mask_agreement import ALPHA, uncertainty
from maskval.plausibility.check import Finding, PlausibilityCheck
from maskval.plausibility.corrections import View
from maskval.pose_errors import add, add_s, mdd, mssd
from maskval.rendering.views import Canvas

# Simplified meshes of one object differ less; a factor of two is another object, and one of 1,000 another unit.
SAME_DIAMETER, OTHER_DIAMETER = 0.1, 2.0

ErrorName = Literal["mssd", "mdd", "add", "add-s"]


@dataclass(frozen=True, slots=True)
class JudgedPose:
    """A pose of a submission and what the masks say of it.

    Args:
        result: The pose.
        mask: Index of its mask among those of its object in its image, or `UNMATCHED`.
        c: Certainty, the intersection over union with that mask, in [0, 1].
        v: Visibility, the share of the silhouette inside the image, in [0, 1].
        u: Uncertainty, in [0, 1]; low is good.
    """

    result: PoseResult
    mask: int
    c: float
    v: float
    u: float


def judge_results(
    dataset: Dataset,
    results: Sequence[PoseResult],
    source: MaskSource,
    *,
    association: Literal["known"] | Rule = "greedy",
    alpha: float = ALPHA,
    pixel_center: float = 0.5,
    canvas: Canvas = "full",
    check: bool = True,
    progress: Callable[[int], object] = lambda count: None,
) -> list[JudgedPose]:
    """The uncertainty of each pose, in the order of the results.

    It also looks whether poses and masks can belong together: see docs/maskval.md. What is only odd is told by an
    `ImplausibleInputWarning`.

    Args:
        dataset: Meshes and cameras.
        results: The poses.
        source: The masks.
        association: "known" when the poses of an object in an image come from its masks in the same order, else the
            matching: "greedy" or "optimal".
        alpha: Visibility below which the certainty is lowered by the visibility, in [0, 1].
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center: 0.5 for what BOP renders.
        canvas: Where the whole silhouette is counted for the visibility: "full", or "3x3" images.
        check: Whether to look if poses and masks can be meant as they are.
        progress: Called with a number of poses whenever so many more are judged.

    Raises:
        InvalidFileError: If poses, masks and data set do not belong together; the message says where.
        ImplausibleInputError: If poses and masks certainly are not what was meant; the message says why.
    """
    groups: dict[ImageObject, list[int]] = defaultdict(list)
    for index, result in enumerate(results):
        groups[ImageObject(result.scene_id, result.im_id, result.obj_id)].append(index)
    judged: dict[int, JudgedPose] = {}
    plausibility = PlausibilityCheck(pixel_center)
    for where, members in groups.items():
        masks = source.masks(where)
        image = dataset.scene(where.scene_id).camera(where.im_id)
        _check_size(masks, dataset.known_image_size(where.scene_id, where.im_id), where)
        camera = image.camera(masks.width, masks.height)
        poses = tuple(results[index].X_CO for index in members)
        try:
            found = uncertainty(
                dataset.mesh(where.obj_id),
                poses,
                masks,
                camera,
                association=association,
                alpha=alpha,
                pixel_center=pixel_center,
                canvas=canvas,
            )
        except MaskvalError as error:
            raise InvalidFileError(f"{_in_words(where)}: {error}") from error
        if check:
            plausibility.add(View(dataset.mesh(where.obj_id), poses, masks, camera, image.X_CW), found.v)
        progress(len(poses))
        for place, index in enumerate(members):
            c, v, u = (float(values[place]) for values in (found.c, found.v, found.u))
            judged[index] = JudgedPose(results[index], int(found.masks[place]), c, v, u)
    if check:
        _tell([*_odd_models(dataset, {where.obj_id for where in groups}), *plausibility.findings()])
    return [judged[index] for index in range(len(results))]


def _check_size(masks: PackedMasks, size: tuple[int, int] | None, where: ImageObject) -> None:
    found = masks.height, masks.width
    if size is not None and size != found:
        turned = ": height and width are swapped" if size == found[::-1] else ""
        raise InvalidFileError(
            f"{_in_words(where)}: expected masks of the image's {size[0]} x {size[1]} (H x W), got {found[0]} x "
            f"{found[1]}{turned}"
        )


def _in_words(where: ImageObject) -> str:
    return f"scene {where.scene_id}, image {where.im_id}, object {where.obj_id}"


def _odd_models(dataset: Dataset, obj_ids: set[int]) -> Iterator[Finding]:
    """The objects whose model is not as large as models_info.json says."""
    known = dataset.models() if dataset.has_models_info else {}
    for obj_id in sorted(obj_ids & known.keys()):
        said, measured = known[obj_id].diameter_m, dataset.mesh(obj_id).diameter
        ratio = max(said, measured) / min(said, measured) if min(said, measured) > 0 else math.inf
        if ratio > 1 + SAME_DIAMETER:
            words = f"models_info.json: the diameter of object {obj_id} is {said * 1e3:g} mm, that of its model"
            yield Finding(f"{words} {measured * 1e3:g} mm: another unit or object?", ratio >= OTHER_DIAMETER)


def _tell(findings: Sequence[Finding]) -> None:
    """Raises the certain ones, and warns of the others."""
    certain = [one.message for one in findings if one.is_certain]
    if certain:
        raise ImplausibleInputError("; ".join(certain))
    for one in findings:
        warnings.warn(one.message, ImplausibleInputWarning, stacklevel=3)  # where the results were given


def evaluate_poses(dataset: Dataset, judged: Sequence[JudgedPose], *, error: ErrorName = "mssd") -> Evaluation:
    """The poses of the data set's targets, matched to their parts.

    Args:
        dataset: True poses and how visible the parts are.
        judged: Poses and uncertainties; those that are no target are left out.
        error: What is the error of a pose: "mssd" (the MDD for objects without symmetries), "mdd", "add" or "add-s".

    Raises:
        InvalidFileError: If what is needed of a target is not in the data set.
    """
    errors = _PoseErrors(dataset, error)
    targets = dataset.targets()
    poses: dict[tuple[int, int], list[JudgedPose]] = defaultdict(list)
    for pose in judged:
        where = ImageObject(pose.result.scene_id, pose.result.im_id, pose.result.obj_id)
        if where in targets:
            poses[where[:2]].append(pose)
    images = []
    for scene_id, im_id in sorted({target[:2] for target in targets}):
        parts = [
            (part, info)
            for part, info in dataset.scene(scene_id).parts(im_id)
            if ImageObject(scene_id, im_id, part.obj_id) in targets
        ]
        for part, info in parts:
            if info.visib_fract > 0 and part.X_CO.apply(dataset.mesh(part.obj_id).center)[2] < 0:
                place = _in_words(ImageObject(scene_id, im_id, part.obj_id))
                raise InvalidFileError(f"scene_gt.json: {place}: expected a visible part before the camera, got z < 0")
        mine = poses[scene_id, im_id]
        table = [[errors.between(pose.result, part.obj_id, part.X_CO) for part, _ in parts] for pose in mine]
        images.append(
            ImageErrors(
                np.array(table).reshape(len(mine), len(parts)),
                np.array([pose.u for pose in mine]),
                np.array([info.visib_fract for _, info in parts]),
            )
        )
    return match_images(images)


class _PoseErrors:
    """One kind of pose error, with the points and symmetries of each object at hand."""

    def __init__(self, dataset: Dataset, error: ErrorName) -> None:
        self._dataset = dataset
        self._error = error
        if error == "mssd" and not dataset.has_models_info:
            raise InvalidFileError(
                "models/models_info.json does not exist: mssd needs the symmetries in it; mdd, add and add-s need none"
            )
        self._models = dataset.models() if error == "mssd" else {}
        self._symmetries: dict[int, tuple[Pose, ...]] = {}

    def between(self, result: PoseResult, obj_id: int, X_CO_true: Pose) -> float:
        """The error of a pose against a part, metres; infinite against a part of another kind."""
        if result.obj_id != obj_id:
            return np.inf
        points = self._dataset.mesh(obj_id).vertices
        if self._error == "mssd":
            return mssd(result.X_CO, X_CO_true, points, self._symmetries_of(obj_id))
        plain = {"mdd": mdd, "add": add, "add-s": add_s}
        return plain[self._error](result.X_CO, X_CO_true, points)

    def _symmetries_of(self, obj_id: int) -> tuple[Pose, ...]:
        if obj_id not in self._symmetries:
            if obj_id not in self._models:
                raise InvalidFileError(f"models_info.json: expected the object {obj_id}, but found {[*self._models]}")
            self._symmetries[obj_id] = self._models[obj_id].symmetry_poses()
        return self._symmetries[obj_id]
