"""A comparison that ends early."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from experiments.commands import compare as compare_module
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from tests.experiments.command import command
from tests.experiments.comparisons import compared, rows, table_of

ROOT = Path(__file__).parents[3]


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
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "interrupted after 0 of 3 experiments"),
        (BrokenProcessPool("killed"), 1, "a worker process died (out of memory?); ended after 0 of 3 experiments"),
    ],
)
def test_what_ends_compare_before_its_first_result_leaves_the_earlier_ones(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
    words: str,
) -> None:
    arguments = ("compare", "--objects", "antenna", "--parts", 1, "--estimator", "oracle", "--speed", "fast")
    arguments += ("--jobs", 1, "--out", tmp_path)
    assert command(capsys, *arguments, "--methods", "none", "--experiments", 1).code == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert {"table.json", "manifest.json", "estimates.parquet"} <= set(before)

    def end(spec: object) -> None:
        raise error

    monkeypatch.setattr(compare_module, "run_experiment", end)
    told = command(capsys, *arguments, "--experiments", 1)
    assert told.code == code
    assert words in told.out
    assert f"{tmp_path} is as it was" in told.out
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


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
