import numpy as np
import pytest

from maskval import Pose, mask_iou
from sim.learned.grouping import VOTE_SCALE, instances
from sim.model.parts import PartModel
from tests.sim.learned.perfect import CAMERA, SURE, UNSURE, mask_of

SIZE = (480, 640)


def perfect_maps(masks: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a perfect detector says: logits that cross zero at the borders, peaks at the middles, votes for them."""
    part = np.full((120, 160), UNSURE, dtype=np.float32)
    center, votes = part.copy(), np.zeros((2, 120, 160), dtype=np.float32)
    for mask in masks:
        share = mask.reshape(120, 4, 160, 4).mean(axis=(1, 3))
        part = np.maximum(part, np.clip(16 * (share - 0.5), UNSURE, SURE)).astype(np.float32)
        v, u = np.nonzero(share > 0.5)
        middle = np.array((u.mean(), v.mean()))
        votes[:, v, u] = (middle[:, None] - (u, v)) / VOTE_SCALE
        center[round(middle[1]), round(middle[0])] = SURE
    return part, center, votes


def test_parts_apart_are_found_as_they_are(antenna: PartModel) -> None:
    poses = [Pose.from_rotvec((2.8, 0.3, turn), (x, y, 0.55)) for turn, x, y in ((0.3, -0.15, 0.0), (1.5, 0.1, 0.05))]
    masks = [mask_of(antenna.part.mesh, X_CO, CAMERA) for X_CO in poses]
    found = instances(*perfect_maps(masks), SIZE)
    assert len(found) == 2
    for mask in masks:
        assert max(mask_iou(mask, one.mask) for one in found) > 0.97  # of a map with a quarter of the resolution
    assert all(one.score > 0.99 for one in found)


def test_parts_that_touch_are_told_apart_by_their_votes() -> None:
    left, right = np.zeros(SIZE, dtype=np.bool_), np.zeros(SIZE, dtype=np.bool_)
    left[200:260, 200:300], right[200:260, 300:400] = True, True
    found = instances(*perfect_maps([left, right]), SIZE)
    assert len(found) == 2
    for mask in (left, right):
        assert max(mask_iou(mask, one.mask) for one in found) > 0.93
    assert not (found[0].mask & found[1].mask)[:, :290].any()


def test_nothing_is_found_without_peaks_or_without_parts() -> None:
    mask = np.zeros(SIZE, dtype=np.bool_)
    mask[200:260, 200:300] = True
    part, center, votes = perfect_maps([mask])
    assert instances(part, np.full_like(center, UNSURE), votes, SIZE) == []
    assert instances(np.full_like(part, UNSURE), center, votes, SIZE) == []


def test_pixels_that_vote_for_nothing_belong_to_nobody() -> None:
    mask, stray = np.zeros(SIZE, dtype=np.bool_), np.zeros(SIZE, dtype=np.bool_)
    mask[200:260, 200:300], stray[20:60, 500:560] = True, True
    part, center, votes = perfect_maps([mask])
    part[5:15, 125:140] = SURE  # and no vote
    (found,) = instances(part, center, votes, SIZE)
    assert not (found.mask & stray).any()


def test_the_score_is_that_of_the_peak_times_that_of_the_pixels() -> None:
    mask = np.zeros(SIZE, dtype=np.bool_)
    mask[200:260, 200:300] = True
    part, center, votes = perfect_maps([mask])
    center[center > 0], part[part > 0] = 0.0, np.log(3.0)  # probabilities 1/2 and 3/4
    (found,) = instances(part, center, votes, SIZE)
    assert found.score == pytest.approx(0.5 * 0.75)
