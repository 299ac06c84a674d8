"""What is observed before a decision."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from maskval import METHODS, Estimates, MaskVal, Needs, NoUncertainty, Pose
from sim.gym.decision_env import GraspCellEnv
from tests.sim.asserts import CERTAIN, assert_every_method_judges_exact_estimates
from tests.sim.gym.decisions import REFINE, SEED, N, first_sight, made


def test_exact_estimates_are_observed_where_the_parts_are(oracle: GraspCellEnv) -> None:
    observation, info = first_sight(oracle)
    count = int(observation["valid"].sum())
    assert count >= 1
    truth = info["truth"]
    assert truth["mdd_m"] == pytest.approx([0.0] * count, abs=1e-9)
    for index in range(count):
        X_BO = Pose.from_matrix(truth["X_BO"][truth["part"][index]])
        position = observation["position"].reshape(N, 3)[index]
        # Estimates are placed by the robot's forward kinematics, which the servo misses by less than 1 mm.
        assert position == pytest.approx(X_BO.translation, abs=2e-3)
        quaternion_wxyz = observation["orientation"].reshape(N, 4)[index]
        assert np.abs(quaternion_wxyz @ X_BO.quaternion_wxyz) == pytest.approx(1.0, abs=1e-5)
    assert not observation["position"].reshape(N, 3)[count:].any()
    # Whole and exact masks: nothing is uncertain. Both networks agree.
    inside = observation["visibility"][:count] == 1.0
    assert inside.any()
    assert (observation["u_maskval"][:count][inside] < 0.05).all()
    assert (observation["u_ensemble-add"][:count] == 0.0).all()


def test_boxes_areas_and_pictures_belong_to_the_masks(oracle: GraspCellEnv) -> None:
    observation, _ = first_sight(oracle)
    masks, depth = observation["masks"][..., 0], observation["depth"][..., 0]
    assert observation["rgb"].shape == (480, 640, 3)
    assert observation["rgb"].std() > 0
    assert masks.max() == observation["valid"].sum()
    for index in range(int(masks.max())):
        rows, columns = np.nonzero(masks == index + 1)
        box = observation["box"].reshape(N, 4)[index]
        expected = [columns.min() / 640, rows.min() / 480, (columns.max() + 1) / 640, (rows.max() + 1) / 480]
        assert box == pytest.approx(expected)
        assert observation["mask_area"][index] == pytest.approx(len(rows) / (640 * 480))
        assert 0.4 < depth[masks == index + 1].min() < 0.61  # the view is from 0.6 m above the belt


def test_no_truth_is_told_unless_it_is_asked_for() -> None:
    env = made(truth=False)
    observation, info = env.reset(seed=SEED)
    assert "truth" not in info
    assert set(observation) == set(env.observation_space.keys())
    env.close()


@pytest.fixture(scope="module")
def all_methods() -> Iterator[GraspCellEnv]:
    env = made(estimator="oracle", methods=tuple(METHODS))
    yield env
    env.close()


def test_every_method_of_the_library_judges_by_its_name(all_methods: GraspCellEnv) -> None:
    assert len(METHODS) == 12
    observation, _ = first_sight(all_methods)
    assert_every_method_judges_exact_estimates(observation)


def u_temporal_of_two_looks(env: GraspCellEnv) -> tuple[float, float]:
    """Of a part at first sight, and when it is looked at again from above."""
    observation, info = first_sight(env)
    part, first = info["truth"]["part"][0], observation["u_temporal"][0]
    observation, *_, info = env.step(np.int64(REFINE))
    return float(first), float(observation["u_temporal"][info["truth"]["part"].index(part)])


def test_a_method_with_a_memory_remembers_the_episode_and_nothing_before_it(all_methods: GraspCellEnv) -> None:
    first_of_two = made(estimator="oracle", methods=("temporal", "none"))
    looks = [u_temporal_of_two_looks(env) for env in (all_methods, all_methods, first_of_two, first_of_two)]
    first_of_two.close()
    assert len(set(looks)) == 1
    at_first_sight, again = looks[0]
    assert at_first_sight == 1.0
    assert again < CERTAIN  # both looks are placed by a servo that misses by less than 1 mm, of 5 cm


class Doubling:
    """A method of one's own that needs a second network."""

    needs = Needs(estimators=2)

    def __call__(self, estimates: Estimates) -> Any:
        return np.full(len(estimates), 0.25)


def test_methods_of_ones_own_are_asked_and_their_networks_charged() -> None:
    mine = made(methods={"none": NoUncertainty(), "mine": Doubling()})
    other = made(methods={"mine": MaskVal()})
    observation, _ = first_sight(mine)
    valid = observation["valid"].astype(bool)
    assert (observation["u_mine"][valid] == 0.25).all()
    assert (observation["u_none"] == 0.0).all()
    _, with_one_network = other.reset(seed=SEED)
    _, with_two = mine.reset(seed=SEED)
    assert with_two["time"] - with_one_network["time"] == pytest.approx(0.20, abs=0.005)  # a pose network's time
    mine.close()
    other.close()
