"""COCO's figures of a detector: pycocotools matches masks, image by image; AP and AR follow for any weights of images.

COCO's own accumulation takes a second per set, too long for a bootstrap: the one here is the same in arrays.
"""

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

_RECALLS = np.linspace(0.0, 1.0, 101)
_EPSILON = np.spacing(1)  # as in pycocotools
_THRESHOLDS = 10  # IoU .50, .55 ... .95
_MOST = 100  # detections of one image, the best scores first

Mask = NDArray[np.bool_]
Array = NDArray[np.float64]


class MaskFigures(NamedTuple):
    """AP over IoU .50 to .95, AP at .50, and AR over .50 to .95, in [0, 1]; None without annotated parts."""

    ap_50_95: float | None
    ap_50: float | None
    ar_100: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """D detections of I images.

    Attributes:
        image: image of each detection, (D,).
        score: (D,).
        right: whether it is matched at each IoU threshold, (D, 10).
        counts: whether it counts there, (D, 10); it does not when it shows a part that is not annotated.
        annotated: annotated parts of each image, (I,).
    """

    image: NDArray[np.int64]
    score: Array
    right: Mask
    counts: Mask
    annotated: NDArray[np.int64]

    @classmethod
    def join(cls, runs: Sequence[Self]) -> Self:
        """The matches of runs of images, one after the other."""
        annotated = [run.annotated for run in runs]
        first = np.cumsum([0, *map(len, annotated)])
        return cls(
            image=np.concatenate([run.image + before for run, before in zip(runs, first, strict=False)]),
            score=np.concatenate([run.score for run in runs]),
            right=np.concatenate([run.right for run in runs]),
            counts=np.concatenate([run.counts for run in runs]),
            annotated=np.concatenate(annotated),
        )


@dataclass(frozen=True, slots=True, eq=False)
class PackedBits:
    """A mask: its rows from the first to the last that is not empty, eight pixels in a byte.

    Attributes:
        top: the first row.
        rows: (R, W / 8).
        area_px: how many pixels it has.
    """

    top: int
    rows: NDArray[np.uint8]
    area_px: int

    @classmethod
    def pack(cls, mask: Mask) -> Self:
        """The bits of a mask, (H, W)."""
        filled = np.flatnonzero(mask.any(axis=1))
        top, bottom = (int(filled[0]), int(filled[-1]) + 1) if len(filled) else (0, 0)
        rows = np.packbits(mask[top:bottom], axis=1)
        return cls(top, rows, int(np.bitwise_count(rows).sum(dtype=np.int64)))

    def iou(self, other: Self, *, crowd: bool) -> float:
        """Intersection over union, or over this mask if the other one is a crowd; 0 where they do not meet."""
        first, last = max(self.top, other.top), min(self.top + len(self.rows), other.top + len(other.rows))
        if first >= last:
            return 0.0
        both = self.rows[first - self.top : last - self.top] & other.rows[first - other.top : last - other.top]
        shared = int(np.bitwise_count(both).sum(dtype=np.int64))
        return shared / (self.area_px if crowd else self.area_px + other.area_px - shared) if shared else 0.0


class _Evaluation(COCOeval):  # type: ignore[misc]  # pycocotools has no types
    """COCO's evaluation of masks that are bits: run lengths take ten times as long to make and to compare."""

    def computeIoU(self, imgId: int, catId: int) -> Any:  # pycocotools' names
        """See COCOeval: one row per detection, the best scores first, and one column per part."""
        truths, found = self._gts[imgId, catId], self._dts[imgId, catId]
        order = np.argsort([-row["score"] for row in found], kind="mergesort")[: self.params.maxDets[-1]]
        if not (truths and found):
            return []
        ious = [[found[i]["bits"].iou(truth["bits"], crowd=bool(truth["iscrowd"])) for truth in truths] for i in order]
        return np.array(ious)


@dataclass(slots=True)
class Annotations:
    """Masks of images, collected as bits."""

    images: int = 0
    truths: list[dict[str, Any]] = field(default_factory=list)
    found: list[dict[str, Any]] = field(default_factory=list)

    def add(self, truths: list[tuple[Mask, bool]], found: list[tuple[Mask, float]]) -> None:
        """One more image.

        Args:
            truths: Visible mask of each part, and whether it is annotated: else COCO takes it for a crowd, which is
                neither to be found nor wrong to find.
            found: Mask and score of each detection.
        """
        self.images += 1
        for mask, annotated in truths:
            self.truths.append(self._row(len(self.truths), mask) | {"iscrowd": int(not annotated)})
        for mask, score in found:
            self.found.append(self._row(len(self.found), mask) | {"score": score})

    def _row(self, index: int, mask: Mask) -> dict[str, Any]:
        bits = PackedBits.pack(mask)
        return {"id": index + 1, "image_id": self.images, "category_id": 1, "area": bits.area_px, "bits": bits}

    def evaluation(self) -> Any:
        """COCO's evaluation of one category, all sizes and 100 detections, matched but not accumulated."""
        with contextlib.redirect_stdout(io.StringIO()):  # it talks
            evaluation = _Evaluation(self._coco(self.truths), self._coco(self.found), "bbox")  # its boxes are not asked
            evaluation.params.areaRng, evaluation.params.areaRngLbl = [[0, 1e10]], ["all"]
            evaluation.params.maxDets = [_MOST]
            evaluation.evaluate()
        return evaluation

    def _coco(self, rows: list[dict[str, Any]]) -> Any:
        coco = COCO()
        images = [{"id": image + 1} for image in range(self.images)]
        coco.dataset = {"images": images, "categories": [{"id": 1}], "annotations": rows}
        coco.createIndex()
        return coco

    def matches(self) -> Matches:
        """COCO's matching of detections and parts."""
        images = self.evaluation().evalImgs
        rows = [(index, row) for index, row in enumerate(images) if row is not None]
        annotated = np.zeros(self.images, dtype=np.int64)
        for index, row in rows:
            annotated[index] = np.count_nonzero(np.asarray(row["gtIgnore"]) == 0)
        nothing = np.zeros((0, _THRESHOLDS), dtype=np.bool_)
        return Matches(
            image=np.repeat([index for index, _ in rows], [len(row["dtScores"]) for _, row in rows]).astype(np.int64),
            score=np.concatenate([np.empty(0), *(row["dtScores"] for _, row in rows)]),
            right=np.concatenate([nothing, *(row["dtMatches"].T > 0 for _, row in rows)]),
            counts=np.concatenate([nothing, *(~row["dtIgnore"].T.astype(bool) for _, row in rows)]),
            annotated=annotated,
        )


def mask_figures(matches: Matches, weights: NDArray[np.int64] | None = None) -> MaskFigures:
    """COCO's AP and AR.

    Args:
        matches: Detections and annotated parts.
        weights: How often each image is in the sample, (I,); once by default.
    """
    often = np.ones(len(matches.annotated), dtype=np.int64) if weights is None else weights
    parts = int(often @ matches.annotated)
    if parts == 0:
        return MaskFigures(None, None, None)
    order = np.argsort(-matches.score, kind="stable")
    weight = often[matches.image[order], None] * matches.counts[order]
    right = np.cumsum(weight * matches.right[order], axis=0, dtype=np.float64)
    recall = right / parts
    precision = right / (np.cumsum(weight, axis=0) + _EPSILON)
    # The best precision at this recall or a higher one; beyond the last recall it is 0.
    best = np.maximum.accumulate(precision[::-1], axis=0)[::-1]
    best = np.vstack((best, np.zeros(_THRESHOLDS)))
    ap = [best[np.searchsorted(recall[:, t], _RECALLS), t].mean() for t in range(_THRESHOLDS)]
    return MaskFigures(float(np.mean(ap)), float(ap[0]), float(recall[-1].mean()) if len(recall) else 0.0)
