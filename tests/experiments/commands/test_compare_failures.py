"""A comparison in which experiments fail."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame
from experiments.results.store import SCHEMAS
from experiments.setup.experiment import run_experiment
from maskval import Pose
from sim.runtime import episode as episode_module
from sim.runtime.world import World
from tests.experiments.comparisons import PARTS, compared, rows, spec, table_of


class Bad:
    """A detector or a pose network that answers something else than it should."""

    def __init__(self, good: Any, answer: Callable[[Frame], Any]) -> None:
        self.images, self.inference_time, self._answer = good.images, good.inference_time, answer

    def detect(self, frame: Frame) -> Any:
        return self._answer(frame)

    def estimate(self, frame: Frame, _: Sequence[Detection]) -> Any:
        return self._answer(frame)


def broken(monkeypatch: pytest.MonkeyPatch, experiment: int, which: str, answer: Callable[[Frame], Any]) -> None:
    """From now on, this experiment's detector or first network answers so."""
    make = episode_module.make_estimators

    def make_bad(kind: Any, latest_truth: Any, part: Any, noise: Any, streams: Any) -> Any:
        detector, networks = make(kind, latest_truth, part, noise, streams)
        if streams.experiment != experiment:
            return detector, networks
        if which == "detector":
            return Bad(detector, answer), networks
        return detector, (Bad(networks[0], answer), networks[1])

    monkeypatch.setattr(episode_module, "make_estimators", make_bad)


def fail(_: Frame) -> None:
    raise RuntimeError("out of memory on device 0")


def full(frame: Frame) -> np.ndarray[Any, np.dtype[np.bool_]]:
    return np.ones((frame.camera.height, frame.camera.width), dtype=np.bool_)


RUBBISH: dict[str, tuple[str, Callable[[Frame], Any], str]] = {
    "a detector that raises": ("detector", fail, "raised RuntimeError: out of memory on device 0"),
    "a mask of another size": (
        "detector",
        lambda frame: [Detection(full(frame).T, 1.0)],
        "expected mask 0 to be bool of shape (480, 640), got bool of (640, 480)",
    ),
    "a mask of probabilities": (
        "detector",
        lambda frame: [Detection(0.9 * full(frame), 1.0)],  # type: ignore[arg-type]
        "got float64 of (480, 640)",
    ),
    "a score that is not a number": (
        "detector",
        lambda frame: [Detection(full(frame), float("nan"))],
        "expected score 0 in [0, 1], got nan",
    ),
    "a network that raises": ("network", fail, "raised RuntimeError: out of memory on device 0"),
    "a pose that is not a number": (
        "network",
        lambda _: [Pose(np.eye(3), np.array([0.0, 0.0, np.nan]))],
        "raised InvalidPoseError: translation",
    ),
    "a rotation that is none": ("network", lambda _: [Pose(2 * np.eye(3), np.zeros(3))], "raised InvalidPoseError: ro"),
    "a bare matrix of not a number": (
        "network",
        lambda _: [np.full((4, 4), np.nan)],
        "to be a maskval.Pose, got ndarray",
    ),
    "more poses than detections": ("network", lambda _: 9 * [Pose.identity()], "one per detection, got 9"),
}


@pytest.mark.parametrize("case", RUBBISH)
def test_rubbish_from_an_estimator_fails_the_experiment_with_the_reason(
    monkeypatch: pytest.MonkeyPatch, case: str
) -> None:
    which, answer, words = RUBBISH[case]
    broken(monkeypatch, 0, "detector", lambda frame: [Detection(full(frame), 1.0)])  # so that one pose is right
    broken(monkeypatch, 0, which, answer)
    result = run_experiment(spec())
    assert result.count is None
    assert result.failure is not None
    assert result.failure.startswith("EstimatorError: Bad on frame 0: ")
    assert words in result.failure
    (row,) = result.tables["experiments"]
    assert row["failure"] == result.failure
    assert "tp" not in row


def test_a_failed_experiment_is_recorded_while_the_others_go_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken(monkeypatch, 1, "network", fail)
    told = compared(capsys, tmp_path, "--objects", "antenna", "--methods", "none", "--experiments", 3)
    assert told.code == 3
    (cell,) = table_of(tmp_path)
    assert (cell["experiments"], cell["failed"], cell["parts"]) == (2, 1, 2 * PARTS)
    assert "2 (1 failed)" in told.out
    assert "failed: antenna × none, experiment 1: EstimatorError: Bad on frame" in told.out
    experiments = rows(tmp_path, "experiments")
    assert [row["failure"] is None for row in experiments] == [True, False, True]
    assert "out of memory on device 0" in experiments[1]["failure"]
    assert [experiments[1][name] for name in ("tp", "fp", "fn", "duration_s")] == 4 * [None]
    (frame,) = rows(tmp_path, "frames", experiment=1)
    assert frame["failure"] in experiments[1]["failure"]
    assert (frame["frame"], frame["detections"]) == (0, None)
    assert {row["failure"] for row in rows(tmp_path, "frames") if row["experiment"] != 1} == {None}


def test_diverging_physics_fails_its_experiment_and_leaves_the_next_one_untouched(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings to a file where it runs
    arguments = ("--objects", "antenna", "--methods", "none", "--experiments", 3)
    compared(capsys, tmp_path / "sound", *arguments)
    reset, follow, resets = World.reset, World.follow, []

    def counted_reset(world: World, X_WO: Sequence[Pose]) -> None:
        resets.append(world)
        reset(world, X_WO)

    def diverging_follow(world: World, *arguments: NDArray[np.float64]) -> bool:
        if len(resets) == 2 and world.time > 3.0:
            world.data.qvel[0] = np.nan
        return follow(world, *arguments)

    monkeypatch.setattr(World, "reset", counted_reset)
    monkeypatch.setattr(World, "follow", diverging_follow)
    told = compared(capsys, tmp_path / "ill", *arguments)
    assert len(resets) == 3
    assert "experiment 1: DivergenceError: physics diverged" in told.out
    (cell,) = table_of(tmp_path / "ill")
    assert (cell["experiments"], cell["failed"]) == (2, 1)
    for experiment in (0, 2):
        for name in SCHEMAS:
            ill, sound = (rows(tmp_path / run, name, experiment=experiment) for run in ("ill", "sound"))
            assert ill == sound


def test_a_part_without_room_on_the_belt_fails_its_experiment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.model.placement._fill_belt", lambda *_, **__: None)
    result = run_experiment(spec())
    assert result.failure is not None
    assert result.failure.startswith("PlacementError: no room for 2 × antenna")
