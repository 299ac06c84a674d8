"""Environments whose steps are decisions, and what is done in them."""

from typing import Any

import gymnasium
import numpy as np

from sim.gym.decision_env import SEARCH, GraspCellEnv
from sim.gym.options import EnvOptions

N = EnvOptions().max_detections
REFINE, GRASP = 1, 1 + N  # the first of each kind
SEED = 5


def made(**options: Any) -> GraspCellEnv:
    env = gymnasium.make("graspcell:GraspCell-v0", **{"n_parts": 2, "truth": True} | options).unwrapped
    assert isinstance(env, GraspCellEnv)
    return env


def same(one: Any, other: Any) -> bool:
    """Equal to the last bit, with dtypes and in nested dicts and lists."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return type(one) is type(other) and bool(one == other)


def first_sight(env: GraspCellEnv) -> tuple[dict[str, Any], dict[str, Any]]:
    observation, info = env.reset(seed=SEED)
    while not observation["valid"].any():
        observation, *_, info = env.step(np.int64(SEARCH))
    return observation, info
