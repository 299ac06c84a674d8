"""Kernels where Numba has no folder to keep them in."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
KERNELS = """
from maskval.rendering import depth_kernels, kernels
from maskval.compiled import jit

def twice(number):
    return 2 * number

def half(number):
    return number / 2

print(jit(twice)(21), jit(half)(6), kernels.measure.targetoptions["nogil"], kernels.measure.stats.cache_path)
"""


def run(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    (folder / "own.py").write_text(KERNELS)
    return subprocess.run(
        [sys.executable, folder / "own.py"],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_without_a_folder_that_can_be_written_kernels_compile_and_one_line_says_so(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")  # in which no folder can be made, not even by the superuser
    only = {"NUMBA_CACHE_DIR": str(tmp_path / "file"), "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    done = run(tmp_path, **only)
    assert (done.returncode, done.stdout) == (0, "42 3.0 True None\n"), done.stderr
    assert done.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR=a folder that can be written" in done.stderr


def test_with_a_folder_kernels_are_kept_there_and_nothing_is_said(tmp_path: Path) -> None:
    done = run(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"42 3.0 True {tmp_path / 'cache'}")
    assert {path.name.split("-")[0] for path in tmp_path.rglob("*.nbc")} == {"own.twice", "own.half"}
