import json
import re
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest

from experiments.commands.config import Compare
from experiments.results import provenance
from experiments.results.provenance import manifest, write_json

CONFIG = Compare(objects=("handle",), seed=11, out=Path("somewhere/else"))


def round_trip(folder: Path, content: object) -> dict[str, object]:
    path = folder / "manifest.json"
    write_json(path, content)
    read: dict[str, object] = json.loads(path.read_text(encoding="utf-8"))
    return read


def test_a_manifest_is_json_and_holds_the_whole_configuration(tmp_path: Path) -> None:
    config = round_trip(tmp_path, manifest(CONFIG))["config"]
    assert config == {
        "objects": ["handle"],
        "methods": ["none", "ensemble-add", "maskval"],
        "experiments": 5,
        "parts": 8,
        "seed": 11,
        "actors": {"estimator": "noisy", "recorded": None, "gap": "none", "policy": None, "time_limit": 300.0},
        "thresholds": "derived",
        "u_grasp": [],
        "speed": "ur-default",
        "fresh_look": True,
        "conditions": {
            "light": 1.0,
            "reflections": 0.0,
            "hand_eye_error_mm": [0.0, 0.0, 0.0],
            "hand_eye_error_deg": [0.0, 0.0, 0.0],
            "focal_error_percent": 0.0,
            "principal_point_error_px": [0.0, 0.0],
            "friction": 1.0,
            "mass": 1.0,
            "latency_s": 0.0,
            "belt_speed": 0.0,
            "belt_speed_error_percent": 0.0,
            "takt_s": 15.0,
            "clutter": "none",
        },
        "jobs": 0,
        "out": "somewhere/else",
    }


def test_a_manifest_names_the_versions_of_what_makes_the_numbers() -> None:
    versions = manifest(CONFIG)["versions"]
    assert {"python", "graspcell", "mujoco", "numpy", "numba", "scipy", "ruckig", "trimesh", "pyarrow"} <= set(versions)
    assert versions["mujoco"] == version("mujoco")
    assert all(re.match(r"\d+\.\d+", number) for number in versions.values())


def answering(monkeypatch: pytest.MonkeyPatch, answers: dict[str, str]) -> None:
    """Git answers its subcommands so."""

    def run(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 0, stdout=answers[command[3]])

    monkeypatch.setattr(provenance.subprocess, "run", run)


@pytest.mark.parametrize(("status", "dirty"), [("", False), (" M sim/runtime/world.py\n", True)])
def test_a_manifest_has_the_commit_and_whether_the_tree_differed(
    monkeypatch: pytest.MonkeyPatch, status: str, dirty: bool
) -> None:
    answering(monkeypatch, {"rev-parse": 40 * "a" + "\n", "status": status})
    made = manifest(CONFIG)
    assert (made["commit"], made["dirty"]) == (40 * "a", dirty)


@pytest.mark.parametrize("error", [FileNotFoundError("git"), subprocess.CalledProcessError(128, "git")])
def test_outside_of_git_the_commit_is_null(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: Exception) -> None:
    def run(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(provenance.subprocess, "run", run)
    read = round_trip(tmp_path, manifest(CONFIG))
    assert (read["commit"], read["dirty"]) == (None, None)


def test_a_commit_is_forty_hexadecimal_digits_or_null() -> None:
    commit = manifest(CONFIG)["commit"]
    assert commit is None or re.fullmatch(r"[0-9a-f]{40}", commit)
