"""Poses with their uncertainties and true errors, and the parts that should have been found: what metrics count."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from maskval.association import UNMATCHED, associate
from maskval.errors import InvalidEvaluationError
from maskval.inputs.arrays import check_number, floats, wholes

# The paper's θ_v: an unfound part counts as a false negative only if it is at least this visible.
VISIBILITY_THRESHOLD = 0.85

# The part of a pose that belongs to none: a false detection. Its error must be infinite.
NO_PART = -1


@dataclass(frozen=True, slots=True)
class Counting:
    """What the paper leaves open about counting; the defaults are those that reach its tables.

    Args:
        averaging: AP, AR and ARU of each image and then their mean ("images"), or of all poses at once ("pooled").
        empty_images: An image without remaining poses has no AP ("skip"), or AP 1 ("one"); pooled counts have neither.
        false_negatives: An eligible part is one when no true positive of it remains ("no true positive"), or
            when no pose of it remains ("no pose").
        visibility_threshold: θ_v, least visibility of an eligible part, in [0, 1].
    """

    averaging: Literal["images", "pooled"] = "images"
    empty_images: Literal["skip", "one"] = "skip"
    false_negatives: Literal["no true positive", "no pose"] = "no true positive"
    visibility_threshold: float = VISIBILITY_THRESHOLD

    def __post_init__(self) -> None:
        for name, value, legal in (
            ("averaging", self.averaging, ("images", "pooled")),
            ("empty_images", self.empty_images, ("skip", "one")),
            ("false_negatives", self.false_negatives, ("no true positive", "no pose")),
        ):
            if value not in legal:
                raise InvalidEvaluationError(f"{name} must be one of {legal}, but is {value!r}")
        check_number("visibility_threshold", self.visibility_threshold, InvalidEvaluationError, least=0, most=1)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """N poses and P parts in I images.

    Args:
        images: Number of images I, those without poses or parts included.
        pose_image: Image of each pose, (N,), 0 to I - 1.
        pose_part: Part of each pose, (N,), 0 to P - 1, or `NO_PART`.
        errors_m: True error of each pose, (N,), metres; infinite without a part.
        u: Uncertainty of each pose, (N,), low is good.
        part_image: Image of each part, (P,), 0 to I - 1.
        part_visibility: Visible share of each part (occlusion and field of view), (P,), in [0, 1].

    Raises:
        InvalidEvaluationError: If lengths differ, an index is out of range, a pose and its part are not in one
            image, or a number is out of its range.
    """

    images: int
    pose_image: NDArray[np.int64]
    pose_part: NDArray[np.int64]
    errors_m: NDArray[np.float64]
    u: NDArray[np.float64]
    part_image: NDArray[np.int64]
    part_visibility: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_number("images", self.images, InvalidEvaluationError, least=0)
        for name in ("pose_image", "pose_part", "part_image"):
            _freeze(self, name, wholes(name, getattr(self, name), InvalidEvaluationError))
        for name in ("errors_m", "u", "part_visibility"):
            _freeze(self, name, floats(name, getattr(self, name), InvalidEvaluationError))
        poses, parts = self.u.shape, self.part_image.shape
        for name, shape in (
            ("pose_image", poses),
            ("pose_part", poses),
            ("errors_m", poses),
            ("part_visibility", parts),
        ):
            if getattr(self, name).shape != shape or len(shape) != 1:
                raise InvalidEvaluationError(f"{name} must have shape {shape}, but has {getattr(self, name).shape}")
        self._check_indices()
        if not np.isfinite(self.u).all():
            raise InvalidEvaluationError(f"u must be finite, but pose {int(np.argmin(np.isfinite(self.u)))} has none")
        if not (self.errors_m >= 0).all() or not np.isposinf(self.errors_m[self.pose_part == NO_PART]).all():
            raise InvalidEvaluationError("errors_m must be >= 0, and infinite for a pose without a part")
        if not ((self.part_visibility >= 0) & (self.part_visibility <= 1)).all():
            raise InvalidEvaluationError("part_visibility must be in [0, 1]")

    def _check_indices(self) -> None:
        for name, low, size in (
            ("pose_image", 0, self.images),
            ("part_image", 0, self.images),
            ("pose_part", NO_PART, len(self.part_image)),
        ):
            values = getattr(self, name)
            wrong = np.flatnonzero((values < low) | (values >= size))
            if len(wrong):
                index = int(wrong[0])
                raise InvalidEvaluationError(f"{name}[{index}] must be in {low}..{size - 1}, but is {values[index]}")
        owned = self.pose_part != NO_PART
        apart = np.flatnonzero(self.part_image[self.pose_part[owned]] != self.pose_image[owned])
        if len(apart):
            index = int(np.flatnonzero(owned)[apart[0]])
            raise InvalidEvaluationError(f"pose {index} and its part {self.pose_part[index]} must be in one image")

    def of_images(self, chosen: NDArray[np.int64]) -> "Evaluation":
        """The evaluation of chosen images, one of them as often as it is chosen: a bootstrap sample.

        Args:
            chosen: Indices of images, (J,).
        """
        poses, pose_image, _ = _members(self.pose_image, self.images, chosen)
        parts, part_image, first_part = _members(self.part_image, self.images, chosen)
        # A part stands in every copy of its image at the same place.
        grouped, _, first = _members(self.part_image, self.images, np.arange(self.images))
        place = np.zeros(len(self.part_image) + 1, dtype=np.int64)
        place[grouped] = np.arange(len(grouped)) - first[self.part_image[grouped]]
        part = self.pose_part[poses]
        return Evaluation(
            images=len(chosen),
            pose_image=pose_image,
            pose_part=np.where(part == NO_PART, NO_PART, first_part[pose_image] + place[part]),
            errors_m=self.errors_m[poses],
            u=self.u[poses],
            part_image=part_image,
            part_visibility=self.part_visibility[parts],
        )


@dataclass(frozen=True, slots=True, eq=False)
class ImageErrors:
    """What is known of one image before poses and parts are matched.

    Args:
        errors_m: Error of each pose against each part, (N, P), metres; infinite where they cannot belong together.
        u: Uncertainty of each pose, (N,).
        part_visibility: Visible share of each part, (P,), in [0, 1].
    """

    errors_m: NDArray[np.float64]
    u: NDArray[np.float64]
    part_visibility: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("errors_m", "u", "part_visibility"):
            _freeze(self, name, floats(name, getattr(self, name), InvalidEvaluationError))


def _freeze(record: object, name: str, array: NDArray[Any]) -> None:
    array.setflags(write=False)
    object.__setattr__(record, name, array)


def match_images(images: Sequence[ImageErrors]) -> Evaluation:
    """The evaluation of images whose poses are matched to parts, the least error first and each part once.

    A pose that no part is left for belongs to none, so that a part found twice counts as a false positive.

    Args:
        images: The errors of each image.

    Raises:
        InvalidEvaluationError: If an image's table is not of its poses and parts, or holds no errors.
    """
    poses = np.array([len(image.u) for image in images], dtype=np.int64)
    parts = np.array([len(image.part_visibility) for image in images], dtype=np.int64)
    first_part = np.cumsum(parts) - parts
    pose_part, errors = [np.empty(0, dtype=np.int64)], [np.empty(0)]
    for index, image in enumerate(images):
        table = image.errors_m
        if table.shape != (poses[index], parts[index]) or not (table >= 0).all():
            raise InvalidEvaluationError(
                f"errors_m of image {index} must be >= 0 and of shape ({poses[index]}, {parts[index]}), "
                f"but are of {table.shape}"
            )
        # The least error first is the greatest closeness first, in (0, 1], and 0 where nothing belongs together.
        matched = associate(1.0 / (1.0 + table), "greedy")
        found = matched != UNMATCHED
        pose_part.append(np.where(found, matched + first_part[index], NO_PART))
        # The index of an unmatched pose, -1, takes the column appended here.
        padded = np.pad(table, ((0, 0), (0, 1)), constant_values=np.inf)
        errors.append(padded[np.arange(len(table)), matched])
    return Evaluation(
        images=len(images),
        pose_image=np.repeat(np.arange(len(images)), poses),
        pose_part=np.concatenate(pose_part),
        errors_m=np.concatenate(errors),
        u=np.concatenate([np.empty(0), *(image.u for image in images)]),
        part_image=np.repeat(np.arange(len(images)), parts),
        part_visibility=np.concatenate([np.empty(0), *(image.part_visibility for image in images)]),
    )


def _members(
    group_of: NDArray[np.int64], groups: int, chosen: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The members of the chosen groups, one group after the other, which choice each is of, and each choice's first."""
    order = np.argsort(group_of, kind="stable")
    counts = np.bincount(group_of, minlength=groups)
    starts = np.cumsum(counts) - counts
    lengths = counts[chosen]
    first = np.cumsum(lengths) - lengths
    owner = np.repeat(np.arange(len(chosen)), lengths)
    return order[starts[chosen][owner] + np.arange(len(owner)) - first[owner]], owner, first
