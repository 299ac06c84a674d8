from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from cell.layout import Belt
from maskval import Pose
from sim.errors import PlacementError
from sim.model.parts import PartModel, load_part
from sim.model.placement import (
    CLEARANCE,
    DROP_HEIGHT,
    TAKT_SPREAD,
    feed_parts,
    feeding_length,
    place_parts,
)

SEEDS = range(10)


def outline(model: PartModel, X_WO: Pose) -> np.ndarray:
    points = X_WO.apply(model.part.mesh.vertices)[:, :2]
    return points[ConvexHull(points).vertices]


@pytest.mark.parametrize("name", ["antenna", "handle"])
def test_parts_lie_on_the_belt_with_room_around_each(name: str) -> None:
    model, belt = load_part(name), Belt()
    pairs = 0
    for seed in SEEDS:
        poses = place_parts(model, 8, belt, np.random.default_rng(seed))
        outlines = [outline(model, pose) for pose in poses]
        for one in outlines:
            assert np.all(np.abs(one[:, 0] - belt.center_x) <= belt.width / 2 - CLEARANCE + 1e-9)
            assert np.all(np.abs(one[:, 1]) <= belt.loading_length / 2 - CLEARANCE + 1e-9)
        for one, other in combinations(outlines, 2):
            nearest = np.linalg.norm(one[:, None] - other[None], axis=2).min()
            assert nearest >= CLEARANCE
            pairs += 1
        for pose in poses:
            lowest = pose.apply(model.part.mesh.vertices)[:, 2].min()
            assert lowest == pytest.approx(belt.top_z + DROP_HEIGHT, abs=1e-6)
    assert pairs == len(SEEDS) * 8 * 7 // 2


def test_resting_poses_come_with_their_probabilities_and_any_yaw() -> None:
    model, count = load_part("handle"), 400
    poses = [place_parts(model, 1, Belt(), np.random.default_rng(seed))[0] for seed in range(count)]
    ups = np.array([pose.rotation[2] for pose in poses])
    for resting in model.resting_poses:
        share = np.mean(ups @ resting.rotation[2] > 0.99)
        # Three standard deviations of a binomial share.
        assert abs(share - resting.probability) < 3 * np.sqrt(resting.probability * (1 - resting.probability) / count)
    headings = np.array([np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0]) for pose in poses])
    quadrants = np.histogram(headings, bins=4, range=(-np.pi, np.pi))[0]
    assert np.all(np.abs(quadrants - count / 4) < 3 * np.sqrt(count * 0.25 * 0.75))


def test_the_same_generator_places_the_same() -> None:
    model = load_part("antenna")
    one, other = (place_parts(model, 8, Belt(), np.random.default_rng(7)) for _ in range(2))
    assert all(np.array_equal(a.matrix, b.matrix) for a, b in zip(one, other, strict=True))


def test_too_many_parts_are_an_error_and_not_a_loop() -> None:
    with pytest.raises(PlacementError, match=r"no room for 60 × handle on 1\.4 m × 0\.4 m of belt with 55 mm"):
        place_parts(load_part("handle"), 60, Belt(), np.random.default_rng(0))


@pytest.mark.parametrize("name", ["antenna", "handle"])
@pytest.mark.parametrize("speed", [0.001, 0.1])
def test_parts_come_along_a_moving_belt_in_order_and_in_takt(name: str, speed: float) -> None:
    model, takt = load_part(name), 15.0
    belt = Belt(speed=speed, upstream=feeding_length(speed, takt, 8))
    intervals = []
    for seed in SEEDS:
        outlines = [outline(model, pose) for pose in feed_parts(model, 8, belt, np.random.default_rng(seed), takt)]
        front = np.array([one[:, 1].min() for one in outlines])
        back = np.array([one[:, 1].max() for one in outlines])
        assert front[0] == pytest.approx(belt.loading_length / 2)  # about to come into reach
        assert back[-1] <= belt.length / 2 + belt.upstream
        assert (front[1:] - back[:-1] >= CLEARANCE - 1e-9).all()
        for one in outlines:
            assert np.all(np.abs(one[:, 0] - belt.center_x) <= belt.width / 2 - CLEARANCE + 1e-9)
        intervals += list(np.diff(front) / speed)
    assert len(intervals) == len(SEEDS) * 7
    if speed == 0.1:  # at 1 mm/s parts of 0.1 m and more need longer than the takt
        assert np.abs(np.array(intervals) / takt - 1).max() <= TAKT_SPREAD
        # Uniform: the mean's standard deviation is takt · spread / √3 / √70.
        assert np.mean(intervals) == pytest.approx(takt, abs=4 * takt * TAKT_SPREAD / np.sqrt(3 * 70))
