import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from cell.interfaces import Detection, Frame
from cell.layout import Layout
from experiments.cli import main
from experiments.commands import compare as compare_module
from experiments.results.store import SCHEMAS
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, kept_cell, make_cycle, run_experiment
from experiments.setup.methods import METHODS
from experiments.setup.thresholds import load_thresholds
from maskval import Pose, mask_from_rle
from sim.networks.ground_truth import LatestTruth
from sim.runtime import episode as episode_module
from sim.runtime.world import World
from tests.experiments.command import Told, command

ROOT = Path(__file__).parents[3]
PARTS = 2  # per experiment: enough for a second slot of time, and two of them share a picture
OBJECTS, NAMES, EXPERIMENTS = ("antenna", "handle"), ("maskval", "none", "ensemble-add"), 2
KEY = ("object", "method", "experiment")
Row = dict[str, Any]


def compared(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object, jobs: int = 1) -> Told:
    return command(capsys, "compare", "--parts", PARTS, "--jobs", jobs, "--seed", 5, "--out", out, *arguments)


def rows(folder: Path, table: str, **of: object) -> list[Row]:
    """The rows of a log, of those experiments that are asked for, one experiment after the other."""
    read: list[Row] = pq.read_table(folder / f"{table}.parquet").to_pylist()
    kept = [row for row in read if all(row[name] == value for name, value in of.items())]
    return sorted(kept, key=lambda row: tuple(row[name] for name in KEY))


def table_of(folder: Path) -> list[Row]:
    cells: list[Row] = json.loads((folder / "table.json").read_text(encoding="utf-8"))["cells"]
    return cells


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of every object and method, in this process."""
    folder = tmp_path_factory.mktemp("compare")
    arguments = ["--objects", *OBJECTS, "--methods", *NAMES, "--experiments", EXPERIMENTS, "--parts", PARTS]
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["compare", *map(str, arguments), "--jobs", "1", "--seed", "5", "--out", str(folder)])
    return folder


def spec(method: str = "none", experiment: int = 0, **other: Any) -> ExperimentSpec:
    plain = ExperimentSpec("antenna", method, "oracle", load_thresholds("paper"), "fast", PARTS, 5, experiment)
    return replace(plain, **other)


# --- what is written


def test_compare_writes_table_manifest_and_all_logs(whole: Path) -> None:
    wanted = {"table.json", "manifest.json", *(f"{name}.parquet" for name in SCHEMAS)}
    assert {path.name for path in whole.iterdir()} == wanted


def test_the_table_has_a_cell_per_object_and_method_in_the_order_asked_for(whole: Path) -> None:
    cells = table_of(whole)
    assert [(cell["object"], cell["method"]) for cell in cells] == [(o, m) for o in OBJECTS for m in NAMES]
    assert all((cell["experiments"], cell["failed"]) == (EXPERIMENTS, 0) for cell in cells)
    assert all(cell["parts"] == EXPERIMENTS * PARTS for cell in cells)


def test_every_cell_is_the_sum_of_its_rows(whole: Path) -> None:
    cells = table_of(whole)
    assert len(cells) == 6
    for cell in cells:
        own = rows(whole, "experiments", object=cell["object"], method=cell["method"])
        assert [cell[name] for name in ("tp", "fp", "fn", "void")] == [
            sum(row[name] for row in own) for name in ("tp", "fp", "fn", "void")
        ]


def test_the_manifest_has_the_seed_the_configuration_and_how_much_is_finished(whole: Path) -> None:
    manifest = json.loads((whole / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["seed"] == 5
    assert manifest["config"]["parts"] == PARTS
    assert manifest["finished"] == manifest["planned"] == len(OBJECTS) * len(NAMES) * EXPERIMENTS
    assert {"versions", "commit", "platform"} <= set(manifest)


def test_every_method_appears_in_one_comparison_and_what_is_not_derived_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ("--objects", "handle", "--methods", "all", "--experiments", 1, "--speed", "fast")
    told = compared(capsys, tmp_path, *arguments, "--u-grasp", "score=0.25")
    assert told.code == 0
    assert [cell["method"] for cell in table_of(tmp_path)] == list(METHODS)
    used = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))["u_grasp"]["handle"]
    assert list(used) == [name for name in METHODS if name != "none"]
    derived = load_thresholds("derived")
    assert (used["maskval"], used["score"]) == (derived.of("handle", "maskval"), 0.25)
    assert "handle × temporal: u_t,g = 0.300: the thresholds derived have none; it is the method's own" in told.out
    assert "× score: u_t,g" not in told.out


def test_a_method_with_a_memory_forgets_between_experiments(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ("--objects", "handle", "--methods", "temporal", "--experiments", 2, "--speed", "fast")
    assert compared(capsys, tmp_path, *arguments).code == 0
    alone = run_experiment(spec("temporal", experiment=1, part="handle", estimator="noisy"))
    seen = [row["u"] for row in rows(tmp_path, "estimates", experiment=1)]
    assert len(seen) >= 3
    assert seen[0] == 1.0
    assert min(seen) < 0.3
    assert seen == [row["u"] for row in alone.tables["estimates"]]


def test_slots_outcomes_and_counts_agree(whole: Path) -> None:
    experiments = rows(whole, "experiments")
    assert len(experiments) == len(OBJECTS) * len(NAMES) * EXPERIMENTS
    for row in experiments:
        of = {name: row[name] for name in KEY}
        slots, attempts = rows(whole, "slots", **of), rows(whole, "attempts", **of)
        assert len(slots) == row["parts"] == row["tp"] + row["fp"] + row["timeouts"]
        assert row["tp"] == sum(attempt["outcome"] == "placed" for attempt in attempts)
        assert row["void"] == sum(attempt["outcome"] == "void" for attempt in attempts)
        assert row["timeouts"] == sum(slot["outcome"] is None for slot in slots)
        assert row["duration_s"] == max(slot["end_s"] for slot in slots)


def pose(numbers: Sequence[float]) -> Pose:
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])


def test_every_attempt_can_be_traced_to_decision_estimate_mask_and_frame(whole: Path) -> None:
    attempts = rows(whole, "attempts")
    assert len(attempts) >= len(OBJECTS) * len(NAMES) * EXPERIMENTS
    camera = Layout().camera
    for attempt in attempts:
        of = {name: attempt[name] for name in KEY}
        (decision,) = rows(whole, "decisions", **of, decision=attempt["decision"])
        (frame,) = rows(whole, "frames", **of, frame=decision["frame"])
        (estimate,) = rows(whole, "estimates", **of, frame=decision["frame"], detection=decision["detection"])
        (_,) = rows(whole, "slots", **of, slot=attempt["slot"])
        assert (decision["action"], decision["slot"]) == ("grasp", attempt["slot"])
        assert (attempt["frame"], attempt["detection"]) == (decision["frame"], decision["detection"])
        assert attempt["u"] == decision["u"] == estimate["u"]
        assert attempt["threshold"] == decision["threshold"]
        assert attempt["threshold"] is None or attempt["u"] <= attempt["threshold"]
        assert frame["time_s"] <= attempt["start_s"] <= attempt["end_s"]
        X_BO_est = pose(frame["X_BC"]) @ pose(estimate["X_CO_est"])
        logged = pose(attempt["X_BO_est"])
        np.testing.assert_allclose(X_BO_est.translation, logged.translation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(X_BO_est.rotation, logged.rotation, rtol=0, atol=1e-12)
        mask = mask_from_rle(estimate["mask_rle"], camera.height, camera.width)
        assert mask.any()


def test_every_detection_of_every_frame_has_its_estimate(whole: Path) -> None:
    frames = rows(whole, "frames")
    assert len(frames) >= len(OBJECTS) * len(NAMES) * EXPERIMENTS
    estimates = [tuple(row[name] for name in (*KEY, "frame", "detection")) for row in rows(whole, "estimates")]
    wanted = [(*(row[name] for name in KEY), row["frame"], i) for row in frames for i in range(row["detections"])]
    assert sorted(estimates) == sorted(wanted)


def test_only_the_ensemble_pays_for_a_second_network(whole: Path) -> None:
    estimates = rows(whole, "estimates")
    assert {row["method"] for row in estimates if row["X_CO_est_2"] is not None} == {"ensemble-add"}
    assert {row["method"] for row in estimates if row["X_CO_est_2"] is None} == {"maskval", "none"}


# --- the same seed, the same rows


def test_the_same_command_again_writes_equal_bytes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ("--objects", "antenna", "--methods", "maskval", "--experiments", 2)
    folders = tmp_path / "one", tmp_path / "other"
    for folder in folders:
        kept_cell.cache_clear()
        assert compared(capsys, folder, *arguments).code == 0
    names = ["table.json", *(f"{name}.parquet" for name in SCHEMAS)]
    one, other = ({name: (folder / name).read_bytes() for name in names} for folder in folders)
    assert one == other


def test_more_workers_and_another_order_of_objects_and_methods_change_no_row(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, whole: Path
) -> None:
    arguments = ("--objects", *OBJECTS[::-1], "--methods", *NAMES[::-1], "--experiments", EXPERIMENTS)
    assert compared(capsys, tmp_path, *arguments, jobs=2).code == 0
    assert [rows(tmp_path, name) for name in SCHEMAS] == [rows(whole, name) for name in SCHEMAS]
    assert table_of(tmp_path) == table_of(whole)[::-1]


def test_an_experiment_run_alone_has_the_rows_that_it_has_among_others(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, whole: Path
) -> None:
    kept_cell.cache_clear()
    of: dict[str, object] = {"object": "handle", "method": "ensemble-add", "experiment": 1}
    arguments = [text for name, value in of.items() for text in (f"--{name}", value)]
    told = command(capsys, "run", *arguments, "--parts", PARTS, "--seed", 5, "--out", tmp_path)
    assert told.code == 0
    assert rows(whole, "frames", **of)
    assert [rows(tmp_path, name) for name in SCHEMAS] == [rows(whole, name, **of) for name in SCHEMAS]


def beginning(spec: ExperimentSpec) -> list[float]:
    """Where all parts lie when the experiment begins, and where the arm is."""
    cell = kept_cell(*spec.cell)
    make_cycle(spec, cell, LatestTruth(), lambda _: None)
    qpos: list[float] = cell.world.data.qpos.tolist()
    assert len(qpos) == 6 + 2 + 7 * PARTS
    return qpos


def test_every_method_begins_with_the_same_parts_in_the_same_poses() -> None:
    kept_cell.cache_clear()
    first = beginning(spec("none", experiment=1))
    run_experiment(spec("none", experiment=0))  # what happened before leaves no trace
    assert [beginning(spec(method, experiment=1)) for method in NAMES] == 3 * [first]
    assert beginning(spec(estimator="noisy", speed="moderate", experiment=1)) == first


def test_another_experiment_or_seed_begins_with_other_poses() -> None:
    first = beginning(spec())
    assert beginning(spec(experiment=1)) != first
    assert beginning(spec(seed=6)) != first


# --- what fails


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
    reset, step, resets = World.reset, World.step, []

    def counted_reset(world: World, X_WO: Sequence[Pose]) -> None:
        resets.append(world)
        reset(world, X_WO)

    def diverging_step(world: World) -> None:
        if len(resets) == 2 and world.time > 3.0:
            world.data.qvel[0] = np.nan
        step(world)

    monkeypatch.setattr(World, "reset", counted_reset)
    monkeypatch.setattr(World, "step", diverging_step)
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


# --- what ends early


def ending(monkeypatch: pytest.MonkeyPatch, after: int, error: BaseException) -> None:
    """From now on, compare's experiments end with this error after so many."""
    finished: list[ExperimentResult] = []

    def run(spec: ExperimentSpec) -> ExperimentResult:
        if len(finished) == after:
            raise error
        finished.append(run_experiment(spec))
        return finished[-1]

    monkeypatch.setattr(compare_module, "run_experiment", run)


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "interrupted after 1 of 3 experiments"),
        (BrokenProcessPool("killed"), 1, "a worker process died (out of memory?); ended after 1 of 3 experiments"),
    ],
)
def test_what_ends_compare_early_leaves_what_is_finished(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
    words: str,
) -> None:
    ending(monkeypatch, after=1, error=error)
    told = compared(capsys, tmp_path, "--objects", "antenna", "--methods", "none", "--experiments", 3)
    assert told.code == code
    assert words in told.out
    (cell,) = table_of(tmp_path)
    assert (cell["experiments"], cell["failed"]) == (1, 0)
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["finished"], manifest["planned"]) == (1, 3)
    assert [row["experiment"] for row in rows(tmp_path, "experiments")] == [0]
    assert rows(tmp_path, "frames")


@pytest.mark.parametrize(
    ("shown", "then_wait", "finished"),
    [
        pytest.param(r" 0/240 ", 0.7, 0, id="while the workers start"),
        pytest.param(r" [1-9]\d*/240 ", 0.0, 1, id="when an experiment is finished"),
    ],
)
def test_ctrl_c_in_a_terminal_ends_command_and_workers_within_seconds(
    tmp_path: Path, shown: str, then_wait: float, finished: int
) -> None:
    errors = tmp_path / "stderr"
    arguments = ["compare", "--experiments", "40", "--parts", "1", "--jobs", "2", "--out", str(tmp_path / "out")]
    # A shell without job control starts what it puts into the background with interrupts ignored.
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with errors.open("w") as stderr:
            process = subprocess.Popen(
                [sys.executable, "-m", "experiments.cli", *arguments],
                cwd=ROOT,
                start_new_session=True,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
            )
    finally:
        signal.signal(signal.SIGINT, previous)
    begun = time.monotonic()
    while not re.search(shown, errors.read_text()):  # by the progress bar
        assert process.poll() is None, errors.read_text()
        assert time.monotonic() - begun < 60
        time.sleep(0.05)
    time.sleep(then_wait)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the command and its workers
    pressed = time.monotonic()
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 130
    assert time.monotonic() - pressed < 10
    assert "Traceback" not in errors.read_text()
    assert "interrupted after" in out
    if "after 0 of" in out:
        assert (finished, list((tmp_path / "out").iterdir())) == (0, [])
        return
    assert len(rows(tmp_path / "out", "experiments")) >= finished
    assert len(table_of(tmp_path / "out")) >= finished
