import json
import math
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
        "actors": {"estimator": "noisy", "recorded": None, "networks": None, "gap": "none", "time_limit": 300.0},
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
        "policy": [],
        "until": [],
        "jobs": 0,
        "ray": None,
        "shard": None,
        "retry_failed": False,
        "overwrite": False,
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


def git(folder: Path, *arguments: str) -> str:
    who = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
    done = subprocess.run(["git", "-C", str(folder), *who, *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_the_commit_is_what_git_says_of_the_folder_of_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(provenance, "__file__", str(tmp_path / "source.py"))
    assert [manifest(CONFIG)[name] for name in ("commit", "dirty")] == [None, None]  # no checkout
    git(tmp_path, "init", "--quiet")
    assert manifest(CONFIG)["commit"] is None  # nor a commit
    (tmp_path / "source.py").write_text("1")
    git(tmp_path, "add", "source.py")
    git(tmp_path, "commit", "--quiet", "--message", "first")
    (tmp_path / "results.txt").write_text("untracked files are no other source")
    assert [manifest(CONFIG)[name] for name in ("commit", "dirty")] == [git(tmp_path, "rev-parse", "HEAD"), False]
    (tmp_path / "source.py").write_text("2")
    assert manifest(CONFIG)["dirty"] is True
    assert capfd.readouterr() == ("", "")  # what git says of it is nobody's business


def test_json_is_indented_text_that_people_read_too_and_knows_no_nan(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_json(path, {"name": "größer", "file": Path("a/b"), "rates": [0.5, None]})
    expected = '{\n  "name": "größer",\n  "file": "a/b",\n  "rates": [\n    0.5,\n    null\n  ]\n}\n'
    assert path.read_text(encoding="utf-8") == expected
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, math.nan)
    assert path.read_text(encoding="utf-8") == expected
