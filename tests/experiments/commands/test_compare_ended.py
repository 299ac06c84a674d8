"""A comparison that ends early."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

from experiments.setup import experiment
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from experiments.units.interruption import Terminated
from tests.experiments.comparisons import compared, contents, rows, table_of

ROOT = Path(__file__).parents[3]


def interrupting(monkeypatch: pytest.MonkeyPatch, after: int, error: BaseException) -> None:
    """From now on, experiments end with this error after so many."""
    finished: list[ExperimentResult] = []

    def run(spec: ExperimentSpec) -> ExperimentResult:
        if len(finished) == after:
            raise error
        finished.append(run_experiment(spec))
        return finished[-1]

    monkeypatch.setattr(experiment, "run_experiment", run)


@pytest.mark.parametrize(
    ("error", "code"), [(KeyboardInterrupt(), 130), (Terminated(signal.SIGTERM), 143), (Terminated(signal.SIGHUP), 129)]
)
@pytest.mark.parametrize("after", [0, 1])
def test_what_ends_compare_early_keeps_what_is_finished_and_the_same_command_goes_on(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
    after: int,
) -> None:
    arguments = ("--objects", "antenna", "--methods", "none", "--experiments", 2)
    interrupting(monkeypatch, after, error)
    told = compared(capsys, tmp_path / "run", *arguments)
    assert told.code == code
    assert f"interrupted: 2 experiments expected = {after} completed + 0 failed + {2 - after} to do" in told.out
    assert [cell["experiments"] for cell in table_of(tmp_path / "run")] == after * [1]
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["finished"], manifest["planned"]) == (after, 2)
    assert [row["experiment"] for row in rows(tmp_path / "run", "experiments")] == list(range(after))
    monkeypatch.undo()
    assert "2 experiments expected = 2 completed + 0 failed" in compared(capsys, tmp_path / "run", *arguments).out
    assert compared(capsys, tmp_path / "whole", *arguments).code == 0
    assert contents(tmp_path / "run") == contents(tmp_path / "whole")


def read_from(terminal: int) -> str:
    """What has come to a terminal within a moment; nothing once its program has ended and all is read."""
    if not select.select([terminal], [], [], 0.05)[0]:
        return ""
    try:
        return os.read(terminal, 65536).decode()
    except OSError:
        return ""


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
    arguments = ["compare", "--experiments", "40", "--parts", "1", "--jobs", "2", "--out", str(tmp_path / "out")]
    terminal, stderr = pty.openpty()
    termios.tcsetwinsize(stderr, (24, 120))
    # A shell without job control starts what it puts into the background with interrupts ignored.
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
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
        os.close(stderr)
    begun, told = time.monotonic(), ""
    while not re.search(shown, told):  # by the progress bar
        assert process.poll() is None, told
        assert time.monotonic() - begun < 60
        told += read_from(terminal)
    time.sleep(then_wait)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the command and its workers
    pressed = time.monotonic()
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 130
    assert time.monotonic() - pressed < 10
    while more := read_from(terminal):
        told += more
    os.close(terminal)
    assert "Traceback" not in told
    assert "interrupted: 240 experiments expected" in out
    assert len(rows(tmp_path / "out", "experiments")) >= finished
    assert len(table_of(tmp_path / "out")) >= finished
