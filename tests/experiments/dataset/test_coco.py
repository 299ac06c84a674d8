import contextlib
import io

import numpy as np
import pytest
from numpy.typing import NDArray
from pycocotools import mask as run_lengths

from experiments.dataset.coco import Annotations, MaskFigures, Matches, mask_figures


def disc(u: float, v: float, radius: float) -> NDArray[np.bool_]:
    rows, columns = np.mgrid[:48, :64]
    return np.asarray((columns - u) ** 2 + (rows - v) ** 2 <= radius**2)


def annotations(images: int, seed: int = 0) -> Annotations:
    """Two discs and an unannotated one per image; found more or less well, one in five missed, one in five twice."""
    rng, collected = np.random.default_rng(seed), Annotations()
    for _ in range(images):
        discs = [(disc(u, v, 8), u != 50) for u, v in ((14, 15), (32, 30), (50, 15))]
        found = []
        for (u, v), times in zip(((14, 15), (32, 30), (50, 15)), rng.choice([0, 1, 1, 1, 2], size=3), strict=True):
            for _ in range(times):
                du, dv = rng.normal(scale=1.5, size=2)
                found.append((disc(u + du, v + dv, 8 + rng.normal()), float(rng.uniform())))
        collected.add(discs, found)
    return collected


def by_pycocotools(collected: Annotations) -> MaskFigures:
    evaluation = collected.evaluation()
    with contextlib.redirect_stdout(io.StringIO()):
        evaluation.accumulate()
    precision, recall = evaluation.eval["precision"], evaluation.eval["recall"]
    return MaskFigures(precision.mean(), precision[0].mean(), recall.mean())


def test_the_figures_are_those_of_pycocotools() -> None:
    collected = annotations(40)
    found = mask_figures(collected.matches())
    assert found == pytest.approx(by_pycocotools(collected), abs=1e-12)
    assert 0.2 < (found.ap_50_95 or 0) < (found.ap_50 or 0) < 1


def test_the_overlaps_are_those_of_pycocotools_run_lengths() -> None:
    rng = np.random.default_rng(3)
    truths = [(disc(u, v, 8), u != 50) for u, v in ((14, 15), (32, 30), (50, 15))] + [(np.zeros((48, 64), bool), True)]
    found = [(disc(*rng.uniform((0, 0), (64, 48)), rng.uniform(3, 20)), float(rng.uniform())) for _ in range(12)]
    collected = Annotations()
    collected.add(truths, found)
    encoded, kinds = [], [int(not annotated) for _, annotated in truths]
    for masks in ([mask for mask, _ in sorted(found, key=lambda one: -one[1])], [mask for mask, _ in truths]):
        encoded.append([run_lengths.encode(np.asfortranarray(mask.astype(np.uint8))) for mask in masks])
    expected = run_lengths.iou(*encoded, kinds)
    assert np.count_nonzero(expected) > 10
    np.testing.assert_array_equal(collected.evaluation().ious[1, 1], expected)


def test_a_weight_is_as_many_copies_of_an_image() -> None:
    once, matches = annotations(12), annotations(12).matches()
    weights = np.array([0, 3, 1, 2, 0, 0, 1, 1, 1, 2, 1, 0])
    copies = Annotations()
    for image in np.repeat(np.arange(1, 13), weights):
        copies.images += 1
        for rows, out in ((once.truths, copies.truths), (once.found, copies.found)):
            out += [
                row | {"id": len(out) + 1 + i, "image_id": copies.images}
                for i, row in enumerate(row for row in rows if row["image_id"] == image)
            ]
    assert mask_figures(matches, weights) == pytest.approx(by_pycocotools(copies), abs=1e-12)


def test_perfect_masks_have_1_everywhere_and_unannotated_ones_do_not_count() -> None:
    collected = Annotations()
    seen, hidden = disc(20, 20, 8), disc(45, 25, 5)
    collected.add([(seen, True), (hidden, False)], [(seen, 0.5), (hidden, 0.9)])
    assert mask_figures(collected.matches()) == (pytest.approx(1), pytest.approx(1), 1)


def test_matches_are_joined_image_by_image() -> None:
    first, second = annotations(3).matches(), annotations(4, seed=1).matches()
    joined = Matches.join([first, second])
    assert len(joined.annotated) == 7
    assert joined.image.tolist() == [*first.image, *(second.image + 3)]


@pytest.mark.parametrize(("annotated", "expected"), [(True, (0.0, 0.0, 0.0)), (False, (None, None, None))])
def test_without_detections_all_is_0_and_without_parts_undefined(
    annotated: bool, expected: tuple[float | None, ...]
) -> None:
    collected = Annotations()
    collected.add([(disc(20, 20, 8), annotated)], [])
    collected.add([], [])
    assert mask_figures(collected.matches()) == expected
