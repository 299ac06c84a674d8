"""`python -m experiments.learn`: an example. A policy learned in GraspCell-v0, beside the paper's thresholds.

The learner sees the least uncertain detection only, and decides between searching on, looking again and grasping it.
"""

import os
import sys
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
import tyro
from gymnasium import spaces
from numpy.typing import NDArray

from cell.records import Tally
from experiments.commands.config import Compare
from experiments.errors import UsageError
from experiments.results.table import Interval, make_cell
from experiments.setup.actors import Actors
from experiments.setup.checks import all_at_least, check_part_and_method
from experiments.setup.experiment import run_experiment
from experiments.setup.pool import run_all
from experiments.setup.thresholds import load_thresholds
from maskval import bootstrap_mean_interval
from sim.errors import EnvOptionError
from sim.gym.options import Rewards

Array = NDArray[np.float32]

TRAINING_SEED = 1_000_000  # and those after it, one per process; results are made with others
FEATURES = ("valid", "u_maskval", "score", "visibility", "mask_area")  # of the least uncertain detection
HEADER = ("policy", "AP %", "[95 %]", "AR %", "[95 %]", "parts/h", "[95 %]", "TP", "FP", "FN", "time-outs", "runs")


@dataclass(frozen=True)
class Learn:
    """Learn when to grasp, look again or search on, and hold it against the paper's thresholds on other belts."""

    object: str = "handle"
    """Part to be sequenced: antenna or handle."""
    steps: int = 2048
    """Decisions to learn from."""
    gap: str = "fitted"
    """Domain gap that is learned and tested with, as in graspcell compare: none, fitted, or a gap.json."""
    false_positive: float = -1.0
    """Reward of an attempt that ends in a collision, a dropped or a misplaced part; a part in its slot is worth 1."""
    experiments: int = 15
    """Experiments of 8 parts to test with; every policy meets the same ones."""
    seed: int = 0
    """Root of the tests' random numbers; the learning has others."""
    jobs: int = 2
    """Processes."""


class Worlds(gymnasium.Wrapper[Any, np.int64]):
    """Gives each experiment the error model that it has in `graspcell compare --gap`."""

    def __init__(self, env: gymnasium.Env[Any, np.int64], part: str, actors: Actors) -> None:
        super().__init__(env)
        self._part, self._parties, self._next = part, actors, 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """See `gymnasium.Env`."""
        first = 0 if seed is not None else self._next
        experiment = (options or {}).get("experiment", first)
        self._next = experiment + 1
        noise = dict(self._parties.noise(self._part, experiment))
        return self.env.reset(seed=seed, options={"experiment": experiment, "noise": noise})


class LeastUncertain(gymnasium.Wrapper[Array, np.int64]):
    """Shows one detection, with what the controller knows of its time; the actions are search, refine and grasp it."""

    def __init__(self, env: gymnasium.Env[Any, np.int64]) -> None:
        super().__init__(env)
        self.observation_space = spaces.Box(0.0, 1.0, (len(FEATURES) + 2,), np.float32)
        self.action_space = spaces.Discrete(3)
        self._best, self._most = 0, 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """See `gymnasium.Env`."""
        observation, info = self.env.reset(seed=seed, options=options)
        return self._reduced(observation), info

    def step(self, action: np.int64) -> tuple[Array, SupportsFloat, bool, bool, dict[str, Any]]:
        """See `gymnasium.Env`."""
        kind = int(action)
        chosen = np.int64(0 if kind == 0 else 1 + (kind - 1) * self._most + self._best)
        observation, reward, terminated, truncated, info = self.env.step(chosen)
        return self._reduced(observation), reward, terminated, truncated, info

    def _reduced(self, observation: Any) -> Array:
        self._most = len(observation["valid"])
        u = np.where(observation["valid"] == 1, observation["u_maskval"], np.inf)
        self._best = int(u.argmin())
        features = [float(observation[name][self._best]) for name in FEATURES]
        time_left = float(observation["time_left"][0]) / 20.0
        return np.array([*features, float(observation["refining"][0]), time_left], np.float32)


def make_env(config: Learn) -> LeastUncertain:
    """The environment that is learned in."""
    rewards = Rewards(false_positive=config.false_positive)
    env = gymnasium.make("graspcell:GraspCell-v0", part=config.object, rewards=rewards)
    return LeastUncertain(Worlds(env, config.object, Actors(gap=config.gap)))


def learned(config: Learn) -> Any:
    """A stable-baselines3 model, trained with PPO.

    Raises:
        UsageError: stable-baselines3 is not installed.
    """
    try:
        from stable_baselines3 import PPO  # noqa: PLC0415  # an extra
        from stable_baselines3.common.env_util import make_vec_env  # noqa: PLC0415
        from stable_baselines3.common.vec_env import SubprocVecEnv  # noqa: PLC0415
    except ImportError as error:
        raise UsageError(f"expected the extra learn: pip install 'graspcell[learn]' ({error})") from error
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # the environments fill the cores
    belts = make_vec_env(
        partial(make_env, config),
        config.jobs,
        seed=TRAINING_SEED,
        vec_env_cls=SubprocVecEnv,
        vec_env_kwargs={"start_method": "spawn"},  # OpenGL does not survive a fork
    )
    # Short roll-outs and a high rate: a few thousand decisions are all there is. A decision matters for one slot.
    model = PPO("MlpPolicy", belts, n_steps=64, batch_size=64, learning_rate=1e-3, gamma=0.9, seed=config.seed)
    model.learn(config.steps)
    belts.close()
    return model


def tried_learned(model: Any, config: Learn) -> list[Tally]:
    """What each of the test's experiments comes to when the model decides."""
    env, counts = make_env(config), []
    for experiment in range(config.experiments):
        observation, info = env.reset(seed=config.seed, options={"experiment": experiment})
        over = False
        while not over:
            action, _ = model.predict(observation, deterministic=True)
            observation, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        if "count" not in info:
            raise RuntimeError(f"experiment {experiment} failed: {info['failure']}")
        counts.append(Tally(**info["count"]))
    env.close()
    return counts


def tried_method(method: str, thresholds: str, config: Learn) -> list[Tally]:
    """The same experiments with a method of the paper and its policy."""
    compare = Compare(
        objects=(config.object,),
        methods=(method,),
        experiments=config.experiments,
        seed=config.seed,
        thresholds=thresholds,
        actors=Actors(gap=config.gap),
    )
    specs = compare.specs()
    return [_counted(result.count, result.failure) for result in run_all(run_experiment, specs, config.jobs)]


def _counted(count: Tally | None, failure: str | None) -> Tally:
    if count is None:
        raise RuntimeError(f"an experiment failed: {failure}")
    return count


def row(name: str, counts: Sequence[Tally], worlds: Sequence[Hashable] | None = None) -> tuple[str, ...]:
    """A policy's line of the table: averages over experiments with the intervals of `make_cell`, bootstrap of the rest.

    Args:
        name: What the line is called.
        counts: Of each experiment.
        worlds: See `make_cell`.
    """
    cell = make_cell(("", "", name), counts, worlds)
    hourly = [3600.0 * count.tp / count.duration for count in counts]
    between = bootstrap_mean_interval(hourly, np.random.default_rng(0))
    ap = "–" if cell.ap is None else f"{100 * cell.ap:.1f}"
    ar = "–" if cell.ar is None else f"{100 * cell.ar:.1f}"
    return (
        *(name, ap, _interval(cell.ap_ci, 100.0), ar, _interval(cell.ar_ci, 100.0)),
        *(f"{np.mean(hourly):.0f}", _interval(between, 1.0)),
        *(str(number) for number in (cell.tp, cell.fp, cell.fn, cell.timeouts, cell.experiments)),
    )


def _interval(interval: Interval | None, scale: float) -> str:
    return "–" if interval is None else f"{scale * interval[0]:.0f}–{scale * interval[1]:.0f}"


def main() -> None:
    """Learns, tests and prints."""
    config = tyro.cli(Learn, prog="python -m experiments.learn")
    try:
        check_part_and_method(config.object, "maskval", load_thresholds("paper"))
        Actors(gap=config.gap).noise(config.object, 0)
        all_at_least(config, steps=1, experiments=1, jobs=1)
        Rewards(false_positive=config.false_positive)
        model = learned(config)
    except (UsageError, EnvOptionError) as error:
        sys.exit(f"experiments.learn: error: {error}")
    actors = Actors(gap=config.gap)
    worlds = [actors.noise(config.object, experiment) or experiment for experiment in range(config.experiments)]
    rows = [
        HEADER,
        row(f"learned ({model.num_timesteps} decisions)", tried_learned(model, config), worlds),
        row("maskval, the paper's threshold", tried_method("maskval", "paper", config), worlds),
        row("maskval, derived threshold", tried_method("maskval", "derived", config), worlds),
        row("none, always", tried_method("none", "paper", config), worlds),
    ]
    widths = [max(len(line[column]) for line in rows) for column in range(len(HEADER))]
    for line in rows:
        print("  ".join(text.rjust(width) for text, width in zip(line, widths, strict=True)))


if __name__ == "__main__":
    main()
