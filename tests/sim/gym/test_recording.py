"""Videos of learning environments."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from sim.errors import EnvOptionError
from sim.gym.decision_env import GraspCellEnv
from sim.gym.recording import RecordMotion
from tests.fakes import moviepy


def placed(env: gymnasium.Env[Any, Any]) -> tuple[int, float]:
    """Grasps until the episode is over; how many steps it took, and when it ended, s."""
    _, info = env.reset(seed=3)
    steps, over = 0, False
    while not over:
        grasp = np.flatnonzero(info["action_mask"])[-1]
        _, _, terminated, truncated, info = env.step(grasp)
        steps, over = steps + 1, terminated or truncated
    env.close()
    return steps, info["time"]


def test_a_video_of_decisions_shows_the_motion_between_them_in_real_time_and_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moviepy.install(monkeypatch)
    cell = GraspCellEnv("rgb_array", (30, 40), n_parts=1, estimator="oracle")
    steps, end = placed(RecordMotion(cell, str(tmp_path / "videos"), fps=2))
    assert moviepy.Clip.written is not None
    frames, fps, path = moviepy.Clip.written
    assert (fps, Path(path).suffix) == (2, ".mp4")
    assert steps < 4
    assert len(frames) == pytest.approx(2 * end, abs=2)  # the episode begins with a first look of less than a second
    assert {frame.shape for frame in frames} == {(30, 40, 3)}
    moved = [bool((one != other).any()) for one, other in pairwise(frames)]
    assert sum(moved) > 0.6 * len(moved)
    assert placed(GraspCellEnv(n_parts=1, estimator="oracle")) == (steps, end)


def test_what_takes_no_pictures_cannot_be_recorded() -> None:
    env = GraspCellEnv(n_parts=1, estimator="oracle")
    env.reset(seed=3)
    with pytest.raises(EnvOptionError, match="expected render_mode rgb_array to record, got None"):
        env.frames(10)
    env.close()
