import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

from cell.records import Tally
from experiments import learn
from experiments.commands.config import Compare
from experiments.learn import HEADER, LeastUncertain, Worlds, row
from experiments.setup.actors import Actors

N = 3


class Scripted(gymnasium.Env[dict[str, Any], np.int64]):
    """Shows three detections of which the last one is no longer there, and keeps what it is told to do."""

    observation_space = spaces.Dict()
    action_space = spaces.Discrete(1 + 2 * N)

    def __init__(self) -> None:
        self.told: list[int] = []

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        names = {"u_maskval": [0.7, 0.2, 0.0], "score": [0.9, 0.8, 0.0], "visibility": [1.0, 0.6, 0.0]}
        observation = {name: np.array(values, np.float32) for name, values in names.items()}
        observation |= {"valid": np.array([1, 1, 0], np.int8), "mask_area": np.array([0.1, 0.3, 0.0], np.float32)}
        observation |= {"refining": np.array([1], np.int8), "time_left": np.array([5.0], np.float32)}
        return observation, {}

    def step(self, action: np.int64) -> Any:
        self.told.append(int(action))
        return self.reset()[0], 0.0, False, False, {}


def test_the_learner_sees_the_least_uncertain_detection_that_is_there():
    seen, _ = LeastUncertain(Scripted()).reset()
    assert seen.tolist() == pytest.approx([1.0, 0.2, 0.8, 0.6, 0.3, 1.0, 5.0 / 20.0])


def test_its_three_actions_search_refine_and_grasp_that_detection():
    scripted = Scripted()
    env = LeastUncertain(scripted)
    env.reset()
    for action in range(3):
        env.step(np.int64(action))
    assert scripted.told == [0, 1 + 1, 1 + N + 1]


def test_every_experiment_has_the_error_model_that_compare_gives_it():
    told = []

    class Resetting(Scripted):
        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            told.append((seed, options))
            return super().reset()

    env = Worlds(Resetting(), "handle", Actors(gap="fitted"))
    env.reset(seed=7)
    env.reset()
    env.reset(options={"experiment": 5})
    env.reset()
    specs = Compare(objects=("handle",), methods=("none",), experiments=7, actors=Actors(gap="fitted")).specs()
    assert [seed for seed, _ in told] == [7, None, None, None]
    assert [options["experiment"] for _, options in told] == [0, 1, 5, 6]
    assert [options["noise"] for _, options in told] == [dict(specs[number].noise) for number in (0, 1, 5, 6)]
    assert specs[0].noise != specs[1].noise


def test_a_row_has_the_pooled_intervals_and_the_parts_per_hour():
    counts = [
        Tally(parts=8, tp=8, fp=0, fn=0, void=0, unreachable=0, timeouts=0, duration=80.0),
        Tally(parts=8, tp=6, fp=2, fn=1, void=3, unreachable=0, timeouts=0, duration=100.0),
    ]
    told = dict(zip(HEADER, row("some", counts), strict=True))
    assert told["AP %"] == f"{100 * (1.0 + 6 / 8) / 2:.1f}"
    assert told["AR %"] == f"{100 * (1.0 + 6 / 7) / 2:.1f}"
    assert told["parts/h"] == f"{(8 / 80 + 6 / 100) / 2 * 3600:.0f}"
    assert [told[name] for name in ("TP", "FP", "FN", "runs")] == ["14", "2", "1", "2"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--object", "spoon"], "spoon"),
        (["--steps", "0"], "--steps"),
        (["--experiments", "0"], "--experiments"),
        (["--false-positive", "nan"], "false_positive"),
        (["--gap", "none.json"], "no gap for handle in none.json"),
    ],
)
def test_what_cannot_be_learned_is_said_in_one_line(arguments, words, monkeypatch):
    monkeypatch.setattr("sys.argv", ["learn", *arguments])
    with pytest.raises(SystemExit, match=f"^experiments.learn: error: .*{words}"):
        learn.main()


def test_without_stable_baselines3_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.setattr("sys.argv", ["learn"])
    with pytest.raises(SystemExit, match=r"pip install 'graspcell\[learn\]'"):
        learn.main()


@pytest.mark.study
def test_the_example_learns_and_prints_its_table(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["learn", "--steps", "128", "--experiments", "1"])
    learn.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
