"""The environment whose steps are decisions, held against the experiment that it is, and against Gymnasium's rules."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from cell.interfaces import Outcome
from experiments.setup.experiment import ExperimentSpec, run_experiment
from experiments.setup.thresholds import load_thresholds
from maskval import METHODS
from policies import ThresholdPolicy
from sim.errors import DivergenceError, GraphicsError
from sim.gym.decision_env import SEARCH, GraspCellEnv
from sim.gym.options import Rewards
from sim.runtime.world import World
from tests.sim.gym.decisions import GRASP, REFINE, SEED, N, made, same


def by_threshold(observation: dict[str, Any], u_grasp: float, u_refine: float) -> int:
    """The paper's policy on what a learner sees."""
    valid = observation["valid"].astype(bool)
    if not valid.any():
        return SEARCH
    best = int(observation["u_maskval"][valid].argmin())
    u = observation["u_maskval"][best]
    if u <= u_grasp:
        return GRASP + best
    # The policy itself refines once per view.
    return REFINE + best if u <= u_refine and not observation["refining"][0] else SEARCH


def random_episode(env: GraspCellEnv, seed: int) -> list[tuple[Any, ...]]:
    rng = np.random.default_rng(seed)
    steps: list[tuple[Any, ...]] = [env.reset(seed=seed)]
    over = False
    while not over:
        action = rng.choice(np.flatnonzero(env.action_masks()))
        steps.append(env.step(action))
        over = steps[-1][2] or steps[-1][3]
    return steps


def test_gymnasium_finds_nothing_to_complain_about() -> None:
    check_env(made(n_parts=1, methods=tuple(METHODS)))


@pytest.mark.study
def test_stable_baselines3_finds_nothing_to_complain_about() -> None:
    from stable_baselines3.common.env_checker import check_env as check_for_baselines  # noqa: PLC0415

    check_for_baselines(made(n_parts=1, methods=tuple(METHODS)))


def test_deciding_like_the_policy_gives_the_experiment_that_compare_runs(env: GraspCellEnv) -> None:
    thresholds = load_thresholds("paper")
    policy = ThresholdPolicy(thresholds.of("antenna", "maskval"), thresholds.refine)
    for experiment in range(2):
        spec = ExperimentSpec("antenna", "maskval", "noisy", thresholds, "ur-default", 2, SEED, experiment)
        expected = run_experiment(spec).count
        observation, info = env.reset(seed=SEED if experiment == 0 else None)
        assert info["experiment"] == experiment
        over = False
        while not over:
            action = by_threshold(observation, policy.u_grasp, policy.u_refine)
            observation, _, over, _, info = env.step(np.int64(action))
        assert expected is not None
        for name, value in info["count"].items():
            assert value == getattr(expected, name)


def test_an_episode_is_a_function_of_its_seed_and_actions_to_the_last_bit(env: GraspCellEnv) -> None:
    first, again, other = random_episode(env, 3), random_episode(env, 3), random_episode(env, 4)
    assert len(first) == len(again) > 4
    assert all(same(one, two) for steps in zip(first, again, strict=True) for one, two in zip(*steps, strict=True))
    assert not same(first[0][1]["truth"]["X_BO"], other[0][1]["truth"]["X_BO"])


def test_a_reset_without_a_seed_goes_on_to_the_next_experiment_of_the_seed(env: GraspCellEnv) -> None:
    env.reset(seed=SEED)
    second = env.reset()[1]
    chosen = env.reset(seed=SEED, options={"experiment": 1})[1]
    assert second["experiment"] == chosen["experiment"] == 1
    assert same(second["truth"]["X_BO"], chosen["truth"]["X_BO"])


def test_the_reward_is_the_weighted_sum_of_what_the_events_name() -> None:
    weights = Rewards(true_positive=100.0, false_positive=-10.0, second=-0.5, invalid=-1000.0)
    env = made(rewards=weights, methods=("none",))
    observation, info = env.reset(seed=1)
    began, total, outcomes, over = info["time"], 0.0, [], False
    while not over:
        action = GRASP if observation["valid"][0] else SEARCH
        observation, reward, over, _, info = env.step(np.int64(action))
        total += float(reward)
        outcomes += [event["outcome"] for event in info["events"]]
        if observation["valid"][0]:
            assert observation["time_left"][0] <= 20.0
    env.close()
    count = info["count"]
    assert total == pytest.approx(100.0 * count["tp"] - 10.0 * count["fp"] - 0.5 * (count["duration"] - began))
    assert outcomes.count("placed") == count["tp"]
    assert outcomes.count("time-out") == count["timeouts"]
    assert outcomes.count("void") == count["void"]
    failed = {outcome.value for outcome in Outcome if outcome.is_false_positive}
    assert sum(outcome in failed for outcome in outcomes) == count["fp"]
    assert len(outcomes) >= 2
    assert (observation["parts_left"][0], observation["valid"].sum()) == (0, 0)


def test_an_invalid_action_searches_on_and_costs_its_weight(env: GraspCellEnv) -> None:
    env.reset(seed=SEED)
    mask = env.action_masks()
    invalid = int(np.flatnonzero(~mask)[0])
    expected, reward, *_ = env.step(np.int64(SEARCH))
    env.reset(seed=SEED)
    observation, less, _, _, info = env.step(np.int64(invalid))
    assert same(observation, expected)
    assert info["invalid_action"] is True
    assert float(less) == pytest.approx(float(reward) - 0.1)


def test_the_mask_allows_the_search_and_the_detections_that_are_there(env: GraspCellEnv) -> None:
    found = set()
    for observation, *_, info in random_episode(env, 8)[:-1]:
        valid = observation["valid"].astype(bool)
        in_time = observation["time_left"][0] > 0
        assert info["action_mask"].tolist() == [1, *(valid & in_time), *valid]
        found.add(int(valid.sum()))
    assert max(found) > 0


def test_an_episode_that_is_over_needs_a_reset_and_actions_must_exist(env: GraspCellEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        GraspCellEnv().step(np.int64(0))
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.InvalidAction, match=f"got {2 * N + 1}"):
        env.step(np.int64(2 * N + 1))
    random_episode(env, 0)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.int64(0))


def test_physics_that_fails_truncates_with_the_reason(env: GraspCellEnv, monkeypatch: pytest.MonkeyPatch) -> None:
    env.reset(seed=SEED)

    def diverge(_: World) -> None:
        raise DivergenceError("physics diverged")

    monkeypatch.setattr(World, "check", diverge)
    observation, _, terminated, truncated, info = env.step(np.int64(SEARCH))
    assert (terminated, truncated, info["failure"]) == (False, True, "physics diverged")
    assert env.observation_space.contains(observation)


def test_the_overview_is_rendered_and_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    env = made(render_mode="rgb_array", render_size=(60, 80))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.render()
    env.reset(seed=0)
    picture = env.render()
    assert (picture.shape, picture.dtype) == ((60, 80, 3), np.uint8)
    assert picture.std() > 10
    env.close()
    env.close()
    blind = made(render_mode="human")
    with pytest.raises(GraphicsError, match="needs a display"):
        blind.reset(seed=0)


def test_environments_in_processes_of_their_own_do_what_one_does_here(env: GraspCellEnv) -> None:
    actions = [SEARCH, GRASP, SEARCH]
    vector = gymnasium.make_vec(
        "graspcell:GraspCell-v0",
        num_envs=2,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
        n_parts=2,
        truth=True,
    )
    there = [vector.reset(seed=SEED)[0]]
    there += [vector.step(np.array([action, action]))[0] for action in actions]
    vector.close()
    for index in range(2):
        here = [env.reset(seed=SEED + index)[0]]
        here += [env.step(np.int64(action))[0] for action in actions]
        for one, both in zip(here, there, strict=True):
            assert same(one, {name: values[index] for name, values in both.items()})
