"""The environment whose steps are decisions, held against the experiment that it is, and against Gymnasium's rules."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from cell.interfaces import Outcome
from experiments.setup.experiment import ExperimentSpec, run_experiment
from experiments.setup.thresholds import load_thresholds
from maskval import METHODS, Estimates, MaskVal, Needs, NoUncertainty, Pose
from policies import ThresholdPolicy
from sim.errors import DivergenceError, EnvOptionError, GraphicsError, NoiseFileError
from sim.gym.decision_env import SEARCH, GraspCellEnv
from sim.gym.options import EnvOptions, Rewards
from sim.runtime.world import World
from tests.sim.asserts import CERTAIN, assert_every_method_judges_exact_estimates

N = EnvOptions().max_detections
REFINE, GRASP = 1, 1 + N  # the first of each kind
SEED = 5


def made(**options: Any) -> GraspCellEnv:
    env = gymnasium.make("graspcell:GraspCell-v0", **{"n_parts": 2, "truth": True} | options).unwrapped
    assert isinstance(env, GraspCellEnv)
    return env


@pytest.fixture(scope="module")
def env() -> Iterator[GraspCellEnv]:
    env = made()
    yield env
    env.close()


@pytest.fixture(scope="module")
def oracle() -> Iterator[GraspCellEnv]:
    env = made(estimator="oracle", methods=("maskval", "ensemble-add"), images=("rgb", "depth", "masks"))
    yield env
    env.close()


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


def same(one: Any, other: Any) -> bool:
    """Equal to the last bit, with dtypes and in nested dicts and lists."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return type(one) is type(other) and bool(one == other)


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


def first_sight(env: GraspCellEnv) -> tuple[dict[str, Any], dict[str, Any]]:
    observation, info = env.reset(seed=SEED)
    while not observation["valid"].any():
        observation, *_, info = env.step(np.int64(SEARCH))
    return observation, info


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


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"n_parts": 9}, "expected n_parts of 1 to 8, got 9"),
        ({"slot_time": 0.0}, "expected slot_time above 0 s, got 0.0"),
        ({"max_detections": 0}, "expected max_detections of at least 1, got 0"),
        ({"methods": "maskval"}, "expected methods to be a tuple of names or a mapping, got 'maskval'"),
        ({"methods": ()}, "expected methods to be a tuple of names or a mapping"),
        ({"methods": ("magic",)}, "unknown methods 'magic': expected none, maskval, .*, temporal"),
        ({"images": ("thermal",)}, "unknown images 'thermal': expected rgb, depth, masks"),
        ({"estimator": "perfect"}, "unknown estimator 'perfect': expected oracle, noisy"),
        ({"speed": "warp"}, "unknown speed 'warp': expected ur-default"),
        ({"part": "spoon"}, "spoon"),
        ({"render_mode": "ascii"}, "unknown render_mode 'ascii'"),
    ],
)
def test_options_that_cannot_be_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GraspCellEnv(**options)


def test_rewards_and_reset_options_are_checked(env: GraspCellEnv) -> None:
    with pytest.raises(EnvOptionError, match="expected a finite reward second, got nan"):
        Rewards(second=float("nan"))
    with pytest.raises(EnvOptionError, match="unknown reset options episode: expected experiment, noise"):
        env.reset(options={"episode": 3})
    with pytest.raises(NoiseFileError, match=r"unknown noise parameter 'pose\.lateral'"):
        env.reset(options={"noise": {"pose.lateral": 3.0}})


def test_exact_estimates_take_no_noise(oracle: GraspCellEnv) -> None:
    with pytest.raises(EnvOptionError, match="expected no noise with the estimator oracle"):
        oracle.reset(options={"noise": {"pose.lateral_mm": 3.0}})


def test_other_noise_holds_for_one_episode(env: GraspCellEnv) -> None:
    def u_of(**options: Any) -> Any:
        observation, _ = env.reset(seed=3, options=options)
        return observation["u_maskval"]

    plain, rough = u_of(), u_of(noise={"pose.lateral_mm": 8.0, "pose.outlier_probability": 0.0})
    seen = np.flatnonzero(plain)
    assert (rough[seen] > plain[seen]).mean() > 0.5
    assert same(u_of(), plain)
