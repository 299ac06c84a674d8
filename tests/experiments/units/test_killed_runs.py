"""A run that is killed again and again comes to the bytes of an undisturbed one."""

import subprocess
import sys
from pathlib import Path

from experiments.results.store import SCHEMAS
from tests.experiments.comparisons import contents
from tests.experiments.units.killed_runs import EXPERIMENTS

ROOT = Path(__file__).parents[3]
KILLS = 20


def ran(out: Path, kills: int) -> list[int]:
    """How often it was killed, and how it ended."""
    command = [sys.executable, "-m", "tests.experiments.units.killed_runs", str(out), str(kills)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=300)
    return [int(word) for word in done.stdout.split()]


def test_twenty_kills_at_random_moments_leave_no_trace(tmp_path: Path) -> None:
    assert ran(tmp_path / "killed", KILLS) == [KILLS, 0]
    assert ran(tmp_path / "whole", 0) == [0, 0]
    killed, whole = contents(tmp_path / "killed"), contents(tmp_path / "whole")
    assert (
        len(whole) == EXPERIMENTS + len(SCHEMAS) + 7
    )  # units, logs, run.json, manifest.json, config.toml and the table in four forms
    assert killed == whole
