"""The uncertainty of every pose of a BOP submission, and what it is worth where the true poses are known."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from maskval.association import Rule
from maskval.bop.dataset import Dataset, ImageObject, MaskSource
from maskval.bop.results import PoseResult
from maskval.errors import InvalidFileError, MaskvalError
from maskval.evaluation.matching import Evaluation, ImageErrors, match_images
from maskval.geometry import Pose
from maskval.methods.mask_agreement import ALPHA, uncertainty
from maskval.pose_errors import add, add_s, mdd, mssd
from maskval.rendering.views import Canvas

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
) -> list[JudgedPose]:
    """The uncertainty of each pose, in the order of the results.

    Args:
        dataset: Meshes and cameras.
        results: The poses.
        source: The masks.
        association: "known" when the poses of an object in an image come from its masks in the same order, else the
            matching: "greedy" or "optimal".
        alpha: Visibility below which the certainty is lowered by the visibility, in [0, 1].
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center: 0.5 for what BOP renders.
        canvas: Where the whole silhouette is counted for the visibility: "full", or "3x3" images.

    Raises:
        InvalidFileError: If poses, masks and data set do not belong together; the message says where.
    """
    groups: dict[ImageObject, list[int]] = defaultdict(list)
    for index, result in enumerate(results):
        groups[ImageObject(result.scene_id, result.im_id, result.obj_id)].append(index)
    judged: dict[int, JudgedPose] = {}
    for where, members in groups.items():
        masks = source.masks(where)
        camera = dataset.scene(where.scene_id).camera(where.im_id).camera(masks.width, masks.height)
        poses = [results[index].X_CO for index in members]
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
            raise InvalidFileError(
                f"scene {where.scene_id}, image {where.im_id}, object {where.obj_id}: {error}"
            ) from error
        for place, index in enumerate(members):
            c, v, u = (float(values[place]) for values in (found.c, found.v, found.u))
            judged[index] = JudgedPose(results[index], int(found.masks[place]), c, v, u)
    return [judged[index] for index in range(len(results))]


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
