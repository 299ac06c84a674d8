"""The scripts of examples/ run as a user would run them, from another folder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


def run(folder: Path, script: str, *arguments: str) -> str:
    """What a script prints, run in a folder."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}  # where graspcell is not installed
    command = [sys.executable, str(EXAMPLES / script), *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_there_are_five_examples_and_each_says_how_to_run_it() -> None:
    scripts = sorted(EXAMPLES.glob("*.py"))
    assert len(scripts) == 5
    assert all(f"python {script.name}" in script.read_text(encoding="utf-8") for script in scripts)


def test_the_uncertainty_of_ones_own_poses_is_0_for_the_true_one_and_rises_with_the_error(tmp_path: Path) -> None:
    u = [float(line.split("u = ")[1]) for line in run(tmp_path, "own_poses.py").splitlines()]
    assert len(u) == 4
    assert u[0] == 0.0
    assert all(0.1 < wrong <= 1.0 for wrong in u[1:])


def test_a_threshold_of_ones_own_is_derived(tmp_path: Path) -> None:
    told = run(tmp_path, "thresholds.py")
    assert "the paper's rule at 15 mm: trust u up to 0." in told
    assert "AUC" in told


def test_a_rule_decides_in_the_environment(tmp_path: Path) -> None:
    assert run(tmp_path, "decide.py", "1").splitlines()[-1].endswith("of 1 placed")


def test_a_method_of_ones_own_runs_in_the_cell_and_its_attempts_are_listed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    told = run(tmp_path, "own_method.py", "--experiments", "1", "--parts", "1", "--jobs", "1", "--out", str(out))
    assert "own_method:Area" in told
    lines = run(tmp_path, "failed_attempts.py", str(out)).splitlines()
    assert lines
    assert all("u = 0." in line and ("true error" in line) for line in lines)


@pytest.mark.parametrize("script", ["own_poses.py", "thresholds.py"])
def test_the_examples_of_the_library_need_no_engine(tmp_path: Path, script: str) -> None:
    code = f"import runpy, sys; runpy.run_path({str(EXAMPLES / script)!r}); sys.exit('mujoco' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=False
    )
    assert done.returncode == 0
