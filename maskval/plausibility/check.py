"""Poses that cannot be meant: rules with numbers, and a trial of what may have gone wrong with all of them alike."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval.plausibility.corrections import CORRECTIONS, View
from maskval.rendering.silhouettes import silhouette_iou

# A camera outside of an object that it sees is farther from its centre: a tenth of the radius is inside even of a flat
# or hollow one, save in the very middle of a container.
INSIDE = 0.1  # of the radius of the sphere around the vertices
UNSEEN = 0.01  # visibility: what somebody has found shows more of its silhouette
HALF = 0.5  # of the poses: what so many do is no outlier
FEW = 3  # poses; of fewer, nothing is certain but the impossible
MISSED = 0.8  # of the poses that meet no mask: half of them do so even 3 cm off, half turned and 60 % occluded at once
NONE_MEETS = 10  # poses that no working estimator misses altogether
GAIN = 0.1  # of an IoU, that counts as better or worse
# By chance, half of the poses that change get better: 14 of 14 in one of 10,000 cases, 10 of 10 in one of 1,000.
CERTAIN, LIKELY = 1e-4, 1e-3
EXACT = 0.9  # mean IoU that no wrong guess reaches in all of `FEW` poses that were worse
MOST_VIEWS, MOST_POSES = 64, 8  # of which masks are kept, evenly spread over all; and the first of each

Ious = NDArray[np.float64]


class Finding(NamedTuple):
    """What is odd, in words, and whether poses, masks and camera are certainly not what was meant."""

    message: str
    is_certain: bool


def find_implausible(views: Iterable[View], *, pixel_center: float = 0.0) -> list[Finding]:
    """What is odd about poses of one source, the certain first; nothing where they can be meant as they are.

    Args:
        views: All of its poses, with the masks that they should project to.
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center.
    """
    check = PlausibilityCheck(pixel_center)
    for view in views:
        _, visibility = silhouette_iou(view.mesh, view.poses, view.masks, view.camera, pixel_center=pixel_center)
        check.add(view, visibility)
    return check.findings()


class PlausibilityCheck:
    """Gathers the poses of one source, view after view, to say at the end what is odd about them.

    Args:
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center.
    """

    def __init__(self, pixel_center: float) -> None:
        self._pixel_center = pixel_center
        self._counts = {"poses": 0, "behind": 0, "inside": 0, "unseen": 0, "maskless": 0}
        self._kept: list[View] = []
        self._met, self._stride = 0, 1

    def add(self, view: View, visibility: NDArray[np.float64]) -> None:
        """Takes a view, and the visibility of each of its poses, (N,)."""
        radius = float(np.linalg.norm(view.mesh.vertices - view.mesh.center, axis=1).max())
        centers_C = np.array([X_CO.apply(view.mesh.center) for X_CO in view.poses]).reshape(-1, 3)
        behind = centers_C[:, 2] + radius < 0
        inside = np.linalg.norm(centers_C, axis=1) < INSIDE * radius
        unseen = (visibility < UNSEEN) & ~behind & ~inside
        for name, flags in (("behind", behind), ("inside", inside), ("unseen", unseen)):
            self._counts[name] += int(np.count_nonzero(flags))
        self._counts["poses"] += len(view.poses)
        if len(view.masks) == 0:
            self._counts["maskless"] += len(view.poses)
        else:
            self._keep(view)

    def _keep(self, view: View) -> None:
        """Keeps every view as long as there is room, then every second, fourth ..."""
        if self._met % self._stride == 0:
            self._kept.append(replace(view, poses=view.poses[:MOST_POSES]))
        self._met += 1
        if len(self._kept) > MOST_VIEWS:
            self._kept, self._stride = self._kept[::2], 2 * self._stride

    def findings(self) -> list[Finding]:
        """What is odd, the certain first."""
        given = self._best(self._kept)
        can_gain = np.count_nonzero(given <= 1 - GAIN) >= HALF * len(given) > 0  # else no correction is one
        tried = dict(self._tried()) if can_gain else {}
        causes = [found for cause, ious in tried.items() if (found := _compared(given, ious, cause))]
        best = max(tried, key=lambda cause: float(tried[cause].mean()), default="")
        named = f": {best}" if best and tried[best].mean() >= given.mean() + 2 * GAIN else ""
        odd = [*self._symptoms(given, named), *causes]
        return sorted(odd, key=lambda finding: not finding.is_certain)

    def _symptoms(self, given: Ious, named: str) -> Iterator[Finding]:
        """What can be seen of single poses; `named` is the likely cause, if there is one."""
        total, cause = self._counts["poses"], named or ": wrong unit, frame or intrinsics?"
        for name, words, few in (
            ("behind", "lie behind the camera", 1),
            ("inside", "have the camera in the middle of the object", 1),
            ("unseen", "show less than 1 % of their silhouette in the image", FEW),
        ):
            count = self._counts[name]
            if count:
                yield Finding(f"{count} of {total} poses {words}{cause}", count >= max(HALF * total, few))
        count = self._counts["maskless"]
        if total and count >= HALF * total:
            ids = "do obj_id and category_id, and im_id and image_id, agree?"
            yield Finding(
                f"{count} of {total} poses have no mask of their object in their image: {ids}", count == total >= FEW
            )
        missed = int(np.count_nonzero(given == 0))
        if missed >= max(MISSED * len(given), FEW + 2):
            yield Finding(
                f"{missed} of {len(given)} silhouettes meet no mask of their object{cause}",
                missed == len(given) >= NONE_MEETS,
            )

    def _tried(self) -> Iterator[tuple[str, Ious]]:
        """Each mistake, and the best IoU of each pose that was kept if it were undone."""
        for correction in CORRECTIONS:
            undone = [view for one in self._kept if (view := correction.undo(one)) is not None]
            if len(undone) == len(self._kept):
                yield correction.cause, self._best(undone)

    def _best(self, views: Iterable[View]) -> Ious:
        """The IoU of each pose with the mask that it meets best."""
        best = [np.empty(0)]
        for view in views:
            iou, _ = silhouette_iou(view.mesh, view.poses, view.masks, view.camera, pixel_center=self._pixel_center)
            best.append(iou.max(axis=1))
        return np.concatenate(best)


def _compared(given: Ious, corrected: Ious, cause: str) -> Finding | None:
    """The finding that a correction is one, by a sign test of the poses that it makes better or worse."""
    better, worse = (int(np.count_nonzero(change >= GAIN)) for change in (corrected - given, given - corrected))
    if better < HALF * len(given) or better < FEW:
        return None
    chance = float(scipy.stats.binom.sf(better - 1, better + worse, 0.5))
    is_exact = worse == 0 and corrected.mean() >= EXACT
    if chance > LIKELY and not is_exact:
        return None
    words = f"the mean IoU of {len(given)} silhouettes with their masks would rise from {given.mean():.2f} to"
    return Finding(f"{cause}; {words} {corrected.mean():.2f}", chance <= CERTAIN)
