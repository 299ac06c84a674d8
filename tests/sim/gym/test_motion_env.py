"""The environment of motions: a scripted hand can do the task in it, and what it must not do is noticed."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from cell.arm.ur10 import forward
from cell.grasping import plan_grasps, plan_places
from cell.layout import Layout
from maskval import METHODS, Pose
from sim.gym.motion_env import GraspCellMotionEnv
from sim.gym.velocity_controller import MAX_SPEED, MAX_TURN, STEP_TIME
from sim.model.conditions import Conditions
from sim.model.parts import load_part
from tests.sim.asserts import CERTAIN, assert_every_method_judges_exact_estimates

OPEN, GRIP = 1.0, -1.0
LAYOUT, PART = Layout(), load_part("antenna").part
SEED = 2


def made(**options: Any) -> GraspCellMotionEnv:
    env = gymnasium.make("graspcell:GraspCellMotion-v0", **{"truth": True} | options).unwrapped
    assert isinstance(env, GraspCellMotionEnv)
    return env


@pytest.fixture(scope="module")
def env() -> Iterator[GraspCellMotionEnv]:
    env = made(estimator="oracle")
    yield env
    env.close()


class Scripted:
    """A hand that goes straight from pose to pose."""

    def __init__(self, env: GraspCellMotionEnv, seed: int) -> None:
        self.env = env
        self.observation, self.info = env.reset(seed=seed)
        self.rewards, self.events, self.over = [0.0], [], False
        self.began = self.info["time"]

    @property
    def X_BT(self) -> Pose:
        return Pose.from_quaternion_wxyz(
            unit(self.observation["tcp_orientation"]), self.observation["tcp_position"].astype(float)
        )

    def act(self, velocity: Any, turn: Any, jaws: float) -> None:
        action = np.concatenate([velocity, turn, [jaws]]).astype(np.float32)
        self.observation, reward, self.over, _, self.info = self.env.step(action)
        self.rewards.append(float(reward))
        self.events += [event["outcome"] for event in self.info["events"]]

    def go(self, X_BT: Pose, jaws: float, most: float = 1.0) -> None:
        for _ in range(200):
            way = X_BT.translation - self.X_BT.translation
            turn = Pose((X_BT.rotation @ self.X_BT.rotation.T), np.zeros(3)).rotvec
            if self.over or (np.linalg.norm(way) < 1e-3 and np.linalg.norm(turn) < 5e-3):
                return
            v, w = 0.3 * way / STEP_TIME / MAX_SPEED, 0.3 * turn / STEP_TIME / MAX_TURN
            self.act(np.clip(v, -most, most), np.clip(w, -1, 1), jaws)
        raise AssertionError(f"did not arrive: {way} m, {turn} rad")

    def stay(self, seconds: float, jaws: float) -> None:
        for _ in range(round(seconds / STEP_TIME)):
            if not self.over:
                self.act(np.zeros(3), np.zeros(3), jaws)


def unit(quaternion_wxyz: NDArray[np.float32]) -> NDArray[np.float64]:
    exact = quaternion_wxyz.astype(float)
    found: NDArray[np.float64] = exact / np.linalg.norm(exact)
    return found


def raised(X: Pose, height: float) -> Pose:
    return Pose(X.rotation, X.translation + [0.0, 0.0, height])


def seed_that_shows_a_part(env: GraspCellMotionEnv) -> int:
    return next(seed for seed in range(30) if env.reset(seed=seed)[0]["valid"].any())


def pick(hand: Scripted) -> Any:
    """Grasps the part where it is estimated; returns the plan."""
    observed = hand.observation
    X_BO_est = Pose.from_quaternion_wxyz(unit(observed["orientation"][:4]), observed["position"][:3].astype(float))
    plan = plan_grasps(PART, X_BO_est)[0]
    hand.go(plan.X_BT_before, OPEN)
    hand.go(plan.X_BT_grip, OPEN, most=0.4)
    hand.stay(0.6, GRIP)
    hand.go(plan.X_BT_lifted, GRIP)
    return plan


def test_gymnasium_finds_nothing_to_complain_about() -> None:
    check_env(made(methods=tuple(METHODS)))


@pytest.mark.study
def test_stable_baselines3_finds_nothing_to_complain_about() -> None:
    from stable_baselines3.common.env_checker import check_env as check_for_baselines  # noqa: PLC0415

    check_for_baselines(made(methods=tuple(METHODS)))


def test_a_scripted_hand_places_the_part_by_what_it_observes(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, seed_that_shows_a_part(env))
    plan = pick(hand)
    assert 0.005 < hand.observation["jaws"][0] < 0.05
    assert hand.observation["force"][0] > 50.0  # 120 N per finger, less what the strongest of several contacts has not
    half_opening = float(hand.observation["jaws"][0]) + 0.012
    place = plan_places(PART, LAYOUT, plan, 0, half_opening)
    nearest = min(place, key=lambda one: np.linalg.norm((hand.X_BT.inverse() @ one.X_BT_above).rotvec))
    hand.go(nearest.X_BT_above, GRIP)
    hand.go(nearest.X_BT_release, GRIP, most=0.3)
    hand.stay(1.0, OPEN)
    assert hand.over
    assert hand.events == ["placed"]
    count = hand.info["count"]
    assert (count["tp"], count["fp"], count["fn"], count["timeouts"]) == (1, 0, 0, 0)
    assert sum(hand.rewards) == pytest.approx(1.0 - 0.01 * (count["duration"] - hand.began))
    p_BK = LAYOUT.X_WB.inverse().apply(LAYOUT.container.slot_center(0, PART.slot_size))
    assert np.abs(hand.info["truth"]["X_BO"][0, :2, 3] - p_BK[:2]).max() < 0.1


def test_a_part_that_is_let_go_of_above_the_belt_is_dropped(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, seed_that_shows_a_part(env))
    pick(hand)
    hand.stay(1.0, OPEN)
    assert hand.events == ["dropped"]
    assert hand.over
    assert hand.info["count"]["fp"] == 1
    assert sum(hand.rewards) == pytest.approx(-1.0 - 0.01 * (hand.info["time"] - hand.began))


def test_striking_the_belt_stops_the_arm_and_ends_the_episode(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, SEED)
    for _ in range(200):
        hand.act([0.0, 0.0, -1.0], np.zeros(3), OPEN)
        if hand.over:
            break
    assert hand.events[-1].startswith("collision with")
    assert hand.observation["force"][0] > 30.0
    assert hand.info["count"]["fp"] == 1
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(7, np.float32))


def test_closing_on_nothing_is_void_and_goes_on(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, SEED)
    hand.stay(1.0, GRIP)
    hand.stay(1.0, OPEN)
    assert hand.events == ["void"]
    assert not hand.over


def test_time_that_is_up_ends_the_slot(env: GraspCellMotionEnv) -> None:
    short = made(slot_time=1.0, n_parts=2)
    hand = Scripted(short, SEED)
    hand.stay(5.0, OPEN)
    assert hand.events == ["time-out", "time-out"]
    assert hand.over
    assert hand.info["time"] == pytest.approx(2.0, abs=2 * STEP_TIME)
    assert hand.info["count"] | {"duration": 0} == {"tp": 0, "fp": 0, "fn": 2, "void": 0, "timeouts": 2, "duration": 0}
    short.close()


def test_the_tool_moves_at_the_velocity_that_is_asked_for(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, SEED)
    share = np.array([0.3, -0.4, 0.2])
    turn = np.array([0.0, 0.0, 0.3])
    hand.act(share, turn, OPEN)  # gathers speed
    hand.act(share, turn, OPEN)
    before = hand.X_BT
    for _ in range(10):
        hand.act(share, turn, OPEN)
    after = hand.X_BT
    seconds = 10 * STEP_TIME
    assert after.translation - before.translation == pytest.approx(share * MAX_SPEED * seconds, abs=1e-3)
    turned = Pose(after.rotation @ before.rotation.T, np.zeros(3)).rotvec
    assert turned == pytest.approx(turn * MAX_TURN * seconds, abs=5e-3)
    assert np.allclose((forward(hand.observation["joints"]) @ LAYOUT.gripper.X_FT).matrix, after.matrix, atol=1e-5)


def test_out_of_reach_the_arm_stands_still_and_says_so(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, SEED)
    for _ in range(80):
        hand.act([0.0, 0.0, 1.0], np.zeros(3), OPEN)
    assert hand.info["blocked"] is True
    there = hand.X_BT.translation
    hand.act([0.0, 0.0, 1.0], np.zeros(3), OPEN)
    assert hand.X_BT.translation == pytest.approx(there, abs=1e-3)


def test_pictures_are_shown_when_the_networks_are_done_with_them(env: GraspCellMotionEnv) -> None:
    hand = Scripted(env, seed_that_shows_a_part(env))
    ages = [float(hand.observation["age"][0])]
    for _ in range(40):
        hand.act(np.zeros(3), np.zeros(3), OPEN)
        ages.append(float(hand.observation["age"][0]))
    # 0.25 s for the masks and 0.20 s for the poses, then up to a step until it is noticed.
    assert min(ages) == pytest.approx(0.45, abs=STEP_TIME)
    assert max(ages) == pytest.approx(0.90, abs=2 * STEP_TIME)


def test_with_latency_an_old_picture_is_shown_and_its_age_is_told_truly() -> None:
    """On a moving belt: what is observed is where the part was that long ago, while the arm goes on moving."""
    late = made(
        estimator="oracle",
        methods=("ensemble-rotation",),
        conditions=Conditions(latency_s=0.3, belt_speed=0.1),
    )
    hand = Scripted(late, SEED)
    was, ages = {}, []
    for step in range(120):
        hand.act([0.2 * np.cos(step / 10), 0.0, 0.0], np.zeros(3), OPEN)
        now, age = hand.info["time"], float(hand.observation["age"][0])
        was[round(now, 3)] = hand.info["truth"]["X_BO"][0, :3, 3]
        if hand.observation["valid"][0] and now - age > hand.began:  # the first picture was taken before the steps
            assert hand.observation["position"][:3] == pytest.approx(was[round(now - age, 3)], abs=2e-3)
            ages.append(age)
    late.close()
    assert len(ages) > 20
    # The latency, 0.25 s for the masks and 0.20 s for each of two networks, then up to a step until it is noticed.
    assert min(ages) == pytest.approx(0.3 + 0.25 + 2 * 0.20, abs=STEP_TIME)
    travelled = np.linalg.norm(np.ptp(list(was.values()), axis=0))
    assert travelled == pytest.approx(0.1 * 119 * STEP_TIME, rel=0.05)


def test_every_method_of_the_library_judges_by_its_name_and_forgets_at_the_reset() -> None:
    env = made(estimator="oracle", methods=tuple(METHODS))
    seed = seed_that_shows_a_part(env)
    for _ in range(2):
        hand = Scripted(env, seed)
        assert_every_method_judges_exact_estimates(hand.observation)
        for _ in range(20):
            hand.act([0.0, 0.0, -0.8], np.zeros(3), OPEN)
        hand.stay(1.5, OPEN)
        assert hand.observation["valid"][0]
        assert hand.observation["u_temporal"][0] < CERTAIN  # seen from 0.2 m nearer
    env.close()


def test_an_episode_is_a_function_of_its_seed_and_actions_to_the_last_bit() -> None:
    noisy = made()
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1, 1, (30, 7)).astype(np.float32)
    runs = []
    for _ in range(2):
        steps: list[Any] = [noisy.reset(seed=9)[0]]
        steps += [noisy.step(action)[0] for action in actions]
        runs.append(steps)
    noisy.close()
    assert len(runs[0]) == 31
    for one, other in zip(*runs, strict=True):
        assert all(np.array_equal(one[name], other[name]) for name in one)


def test_what_cannot_be_is_refused(env: GraspCellMotionEnv) -> None:
    env.reset(seed=0)
    for action in (np.full(7, 2.0), np.full(7, np.nan), np.zeros(6)):
        with pytest.raises(gymnasium.error.InvalidAction):
            env.step(action.astype(np.float32))
