"""Only pictures need OpenGL: everything else runs where no OpenGL library is to be found."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.experiments.command import Told, command
from tests.experiments.own import folder_with

ROOT = Path(__file__).parents[2]

# Runs commands one after the other where no library of OpenGL can be loaded: prints each one's exit code and error,
# and the libraries of OpenGL that are there in the end.
NO_LIBRARY = """
import contextlib, ctypes, ctypes.util, io, itertools, json, sys
load = ctypes.CDLL.__init__
def refuse(self, name, *args, **kwargs):
    if name and ("GL" in str(name) or "OSMesa" in str(name)):
        raise OSError(f"{name}: cannot open shared object file")
    load(self, name, *args, **kwargs)
ctypes.CDLL.__init__ = refuse
ctypes.util.find_library = lambda name: None

from experiments.cli import main

def shorten_the_grid_of_gaps():
    from experiments.prediction import gap_command
    count_all = gap_command.count_all
    gap_command.count_all = lambda specs, jobs, text: [*count_all(specs[:1], jobs, text)] * len(specs)

told = {}
for name, arguments in json.loads(sys.argv[1]).items():
    if name == "gap":
        shorten_the_grid_of_gaps()
    errors = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        try:
            main([name, *arguments])
        except SystemExit as end:
            told[name] = [end.code, errors.getvalue()]
with open("/proc/self/maps") as maps:
    loaded = sorted({line.split("/")[-1] for line in maps if "GL" in line or "OSMesa" in line})
print(json.dumps({"told": told, "loaded": loaded}))
"""
TARGETS = """
[target.mask]
ap_50_95 = { value = 0.8, sd = 0.002 }
[prior.mask]
field_cells = { center = 0.15, spread = 0.5 }
"""
JOBS: dict[str, list[object]] = {
    "compare": ["--objects", "handle", "--methods", "maskval", "--experiments", 1, "--parts", 1],
    "run": ["--object", "handle", "--parts", 1, "--clutter", "distractors"],
    "dataset": ["--objects", "handle", "--methods", "maskval", "--images", 8, "--resamples", 1],
    "tolerance": ["--objects", "handle", "--mdd-mm", 0, "--trials", 1],
    "calibrate": ["--part", "handle", "--targets", "targets.toml", "--images", 8, "--draws", 1, "--rounds", 1],
    "gap": ["--part", "handle", "--draws", 1],
    "predict": ["--objects", "handle", "--methods", "none", "--gap", "none", "--worlds", 1, "--experiments", 1],
}
NEEDS_A_PICTURE = {"picture": ["--out", "a.png"], "render-dataset": ["--images", 1, "--jobs", 1, "--out", "b"]}


def without_library(folder: Path, mujoco_gl: str | None, jobs: dict[str, list[object]]) -> dict[str, Any]:
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    environment |= {"PYTHONPATH": str(ROOT)} | ({"MUJOCO_GL": mujoco_gl} if mujoco_gl else {})
    arguments = {name: [str(argument) for argument in given] for name, given in jobs.items()}
    done = subprocess.run(
        [sys.executable, "-c", NO_LIBRARY, json.dumps(arguments)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def without_opengl(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("without")
    (folder / "targets.toml").write_text(TARGETS)
    jobs = {
        name: [*arguments, *([] if name == "run" else ["--jobs", 1]), "--out", folder / name]
        for name, arguments in JOBS.items()
    }
    return without_library(folder, "disable", jobs)


@pytest.mark.parametrize("name", JOBS)
def test_a_job_without_pictures_runs_without_an_opengl_library(without_opengl: dict[str, Any], name: str) -> None:
    code, errors = without_opengl["told"][name]
    assert code == 0, errors


def test_no_opengl_library_is_opened_where_none_is_needed(without_opengl: dict[str, Any]) -> None:
    assert without_opengl["told"].keys() == JOBS.keys()
    assert without_opengl["loaded"] == []


@pytest.mark.parametrize("mujoco_gl", [None, "disable"])
def test_what_makes_pictures_says_in_one_line_what_it_misses(tmp_path: Path, mujoco_gl: str | None) -> None:
    found = without_library(tmp_path, mujoco_gl, NEEDS_A_PICTURE)
    for code, errors in found["told"].values():
        assert code == 2, errors
        line = errors.splitlines()[-1]  # after the progress of a job that had begun
        assert line.startswith("graspcell: error: no off-screen OpenGL, which pictures need")
        assert "apt-get install libegl1 libgl1 libosmesa6" in line
    assert found["told"].keys() == NEEDS_A_PICTURE.keys()


def test_an_opengl_that_the_environment_names_but_the_machine_lacks_is_one_line(tmp_path: Path) -> None:
    found = without_library(tmp_path, "egl", {"run": ["--parts", 1], "uq": ["--dataset", tmp_path, "--masks", "mask"]})
    code, line = found["told"]["run"]
    assert (code, line.count("\n")) == (2, 1)
    assert "MUJOCO_GL names, 'egl'" in line
    assert "expected it unset" in line
    assert "OpenGL" not in found["told"]["uq"][1]


LOOKING = """
from cell.interfaces import Image

class Looking:
    inference_time, images = 0.1, frozenset({Image.RGB})

    def __init__(self, setup):
        self.detector, self.pose_estimators = self, (self, self)

    def detect(self, frame):
        return []

    def estimate(self, frame, detections):
        return []
"""


def test_networks_that_look_at_pictures_end_compare_with_the_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setenv("MUJOCO_EGL_DEVICE_ID", "99")  # this process may have its display already; its workers have none
    job = ["compare", "--experiments", 2, "--parts", 1, "--jobs", 2, "--out", tmp_path / "out"]
    with folder_with(tmp_path, {"looking": LOOKING}, monkeypatch):
        told: Told = command(capsys, *job, "--estimator", "looking:Looking")
    assert told.code == 2
    assert told.err.rstrip().splitlines()[-1].startswith("graspcell: error: no off-screen OpenGL")
    assert "apt-get install libegl1 libgl1 libosmesa6" in told.err
    assert not (tmp_path / "out" / "table.json").exists()
