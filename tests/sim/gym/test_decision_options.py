"""Options of the environment whose steps are decisions."""

from typing import Any

import numpy as np
import pytest

from sim.errors import EnvOptionError, NoiseFileError
from sim.gym.decision_env import GraspCellEnv
from sim.gym.options import Rewards
from tests.sim.gym.decisions import same


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
