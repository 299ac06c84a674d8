import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.cli import COMMANDS, options
from tests.experiments.command import Told, command

ROOT = Path(__file__).parents[2]

WRONG = [  # arguments, words that the one line of error must hold
    ([], ["compare", "run"]),
    (["compere"], ["compere", "compare", "run"]),
    (
        ["compare", "--objet", "antenna"],
        ["--objet", "valid options of compare", "--hand-eye-error-mm", "mean --objects?"],
    ),
    (["run", "--experment", "1"], ["--experment", "valid options of run", "--object", "did you mean --experiment?"]),
    (["compare", "--objects"], ["expected at least one value for --objects, got none"]),
    (["compare", "--methods"], ["expected at least one value for --methods, got none"]),
    (["compare", "--objects", "cup"], ["unknown object 'cup'", "antenna, handle", ".toml"]),
    (["compare", "--objects", "handle", "cup"], ["unknown object 'cup'", "antenna, handle"]),
    (["compare", "--objects", "cup.toml"], ["cup.toml does not exist"]),
    (["compare", "--objects", "handle", "handle"], ["expected different values for --objects, got handle handle"]),
    (["compare", "--methods", "mask"], ["unknown method 'mask'", "none, maskval, ", "package.module:Class"]),
    (["compare", "--methods", "none", "none"], ["expected different values for --methods, got none none"]),
    (["compare", "--experiments", "0"], ["--experiments of at least 1", "got 0"]),
    (["compare", "--experiments", "many"], ["error: --experiments: ", "'many'", "expected --experiments INT"]),
    (
        ["run", "--u-grasp", "x"],
        ["error: --u-grasp: expected a number such as 0.12, got 'x'", "expected --u-grasp {None}|FLOAT"],
    ),
    (["compare", "--parts", "0"], ["--parts in 1..8", "got 0"]),
    (["compare", "--parts", "9"], ["--parts in 1..8", "got 9"]),
    (["compare", "--seed", "-1"], ["--seed of at least 0", "got -1"]),
    (["compare", "--seed", "99999999999999999999"], ["--seed", "at most 2147483647", "got 99999999999999999999"]),
    (
        ["compare", "--methods", "inliers"],
        ["--estimator networks with inliers", "judges correspondences", "got noisy"],
    ),
    (
        ["compare", "--networks", "weights"],
        ["--networks weights is only for --estimator networks", "got --estimator noisy"],
    ),
    (
        ["run", "--estimator", "networks", "--networks", "nowhere"],
        ["--estimator networks: expected trained networks in nowhere", "`graspcell train`"],
    ),
    (
        ["compare", "--estimator", "perfect"],
        ["unknown estimator 'perfect'", "noisy, oracle, networks, replay", "package.module:Cla"],
    ),
    (["compare", "--estimator", "no_such_module:Net"], ["no_such_module:Net", "no module no_such_module"]),
    (["compare", "--estimator", "replay"], ["--estimator replay", "expected --recorded FOLDER"]),
    (["compare", "--recorded", "out"], ["--recorded out is only for --estimator replay", "got --estimator noisy"]),
    (
        ["run", "--estimator", "replay", "--recorded", "no-such"],
        ["expected --recorded to be an existing folder, got no-such"],
    ),
    (
        ["compare", "--policy", "bold"],
        ["unknown policy 'bold'", "always, best-of-view, threshold", "package.module:Class"],
    ),
    (["compare", "--policy", "math:inf"], ["math:inf", "expected a class", "got inf"]),
    (["compare", "--policy", "math:sqrt"], ["math:sqrt", "called with (PolicySetup), it raised TypeError"]),
    (["run", "--policy", "pathlib:Path"], ["pathlib:Path", "PolicySetup"]),
    (["run", "--time-limit", "0"], ["--time-limit above 0 s", "got 0"]),
    (["run", "--time-limit", "nan"], ["--time-limit above 0 s", "got nan"]),
    (["compare", "--u-grasp", "maskval"], ["--u-grasp METHOD=U of none, ensemble-add, maskval", "got 'maskval'"]),
    (["compare", "--u-grasp", "depth=0.5"], ["--u-grasp METHOD=U of none, ensemble-add, maskval", "got 'depth=0.5'"]),
    (["run", "--u-grasp", "1.5"], ["--u-grasp maskval=U with U in [0, 1]", "1.5"]),
    (
        ["compare", "--methods", "score", "--thresholds", "paper"],
        ["paper have no grasp.antenna.score", "--u-grasp score=U"],
    ),
    (["compare", "--thresholds", "papr"], ["unknown thresholds 'papr'", "derived, paper", ".toml"]),
    (["compare", "--thresholds", "my.toml"], ["my.toml does not exist"]),
    (["compare", "--speed", "warp"], ["unknown speed 'warp'", "ur-default, moderate, fast"]),
    (["compare", "--jobs", "-1"], ["--jobs of at least 0", "got -1"]),
    (["compare", "--hand-eye-error-mm", "1", "2"], ["--hand-eye-error-mm", "3 values"]),
    (["compare", "--hand-eye-error-mm", "nan", "0", "0"], ["--hand-eye-error-mm within -100 and 100", "nan"]),
    (["compare", "--gap", "no.json"], ["no gap for antenna in no.json", "expected none, fitted, or a gap.json"]),
    (["run", "--gap", "fitted", "--estimator", "oracle"], ["--estimator noisy with --gap fitted", "got oracle"]),
    (["run", "--friction", "9"], ["--friction within 0.05 and 3", "9"]),
    (["run", "--object", "cup"], ["unknown object 'cup'", "antenna, handle"]),
    (["run", "--method", "mask"], ["unknown method 'mask'", "none, maskval, ", "package.module:Class"]),
    (["run", "--experiment", "-1"], ["--experiment of at least 0", "got -1"]),
    (["run", "--parts", "9"], ["--parts in 1..8", "got 9"]),
]


def is_one_line(told: Told) -> bool:
    return told.err.startswith("graspcell: error: ") and told.err.count("\n") == 1 and told.err.endswith("\n")


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_a_wrong_argument_ends_with_code_2_and_one_line_that_names_what_is_valid(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: list[str]
) -> None:
    told = command(capsys, *arguments)
    assert told.code == 2
    assert is_one_line(told)
    assert [word for word in words if word not in told.err] == []
    assert told.out == ""


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_the_line_is_the_same_on_every_terminal(encoding: str) -> None:
    for arguments, line in (
        (["gap", "--seed", "1.5"], "--seed: expected a whole number such as 12, got '1.5'; expected --seed INT"),
        (["run", "--friction", "9"], "expected --friction within 0.05 and 3, got 9"),
        (["run", "--clutter", "x"], "invalid choice 'x' for argument '--clutter'. Expected one of"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "experiments.cli", *arguments],
            cwd=ROOT,
            env=os.environ | {"PYTHONIOENCODING": encoding},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert done.stderr.startswith(f"graspcell: error: {line}")


def test_a_malformed_threshold_file_is_refused_in_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('refine = "much"\n[grasp]\n[ensemble_add_minimum_m]\n')
    told = command(capsys, "compare", "--thresholds", path)
    assert (told.code, is_one_line(told)) == (2, True)
    assert "expected refine in [0, 1], got 'much'" in told.err


@pytest.mark.parametrize("job", ["compare", "run"])
def test_a_folder_that_cannot_be_written_to_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, job: str
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    for folder in (blocked, blocked / "below"):
        told = command(capsys, job, "--out", folder)
        assert (told.code, is_one_line(told)) == (2, True)
        assert f"cannot write to {folder}" in told.err
        assert "expected a writable folder" in told.err
    assert blocked.read_text() == "in the way"


def test_a_folder_without_permission_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(dir: Path) -> None:
        raise PermissionError(13, "Permission denied", str(dir))

    monkeypatch.setattr("experiments.setup.checks.TemporaryFile", refuse)  # the superuser may write anywhere
    told = command(capsys, "compare", "--out", tmp_path)
    assert (told.code, is_one_line(told)) == (2, True)
    assert f"cannot write to {tmp_path}: Permission denied" in told.err


def test_help_names_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "--help")
    assert (told.code, told.err) == (0, "")
    assert {"compare", "run"} <= set(COMMANDS)
    assert [name for name in COMMANDS if name not in told.out] == []


@pytest.mark.parametrize("job", COMMANDS)
def test_help_of_a_command_names_every_option_with_its_default(capsys: pytest.CaptureFixture[str], job: str) -> None:
    told = command(capsys, job, "--help")
    bare = {
        "merge": {"--folders"},
        "query": {"--run", "--sql"},
        "plan": {"--run", "--conditions"},
        "export": {"--run"},
    }.get(job, set())  # words, not options
    names = [name for name in options(COMMANDS[job][0]) if name not in bare]
    assert (told.code, told.err) == (0, "")
    assert len(names) >= {"doctor": 0, "merge": 2, "query": 2, "plan": 2, "report": 3}.get(job, 5)
    assert [name for name in names if name not in told.out] == []
    words = " ".join(told.out.replace("│", " ").split())
    assert words.count("(default: ") + words.count("(required)") + words.count("(optional)") >= len(names)


def test_the_defaults_of_compare_are_the_papers_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    out = " ".join(command(capsys, "compare", "--help").out.replace("│", " ").split())
    defaults = ("antenna handle", "none ensemble-add maskval", "5", "8", "0", "derived", "ur-default")
    assert [default for default in defaults if f"(default: {default})" not in out] == []


def loaded_by(arguments: list[str]) -> set[str]:
    """Modules that a fresh `graspcell` has loaded when it ends."""
    script = (
        "import atexit, sys; atexit.register(lambda: print(sorted({name.split('.')[0] for name in sys.modules}), "
        f"file=sys.stderr)); from experiments.cli import main; main({arguments!r})"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded: list[str] = ast.literal_eval(done.stderr.strip().splitlines()[-1])
    return set(loaded)


def test_help_does_not_wait_for_the_engine() -> None:
    loaded = loaded_by(["compare", "--help"])
    assert "tyro" in loaded
    assert loaded & {"mujoco", "numba", "trimesh", "pyarrow", "ruckig"} == set()
