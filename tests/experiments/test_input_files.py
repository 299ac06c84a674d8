"""What a command reads must be a regular file: a device fills the memory, a pipe never answers."""

import os
from pathlib import Path

import pytest

from tests.experiments.command import command

UQ = ("uq", "--dataset", ".")


@pytest.mark.parametrize(
    "arguments",
    [
        ("compare", "--gap"),
        ("run", "--gap"),
        (*UQ, "--masks", "mask", "--results"),
        (*UQ, "--results", "results.csv", "--masks"),
        ("compare", "--thresholds"),
        ("compare", "--objects"),
        ("calibrate", "--targets"),
        ("calibrate", "--start"),
    ],
    ids=" ".join,
)
def test_a_pipe_is_refused_in_one_line_instead_of_waiting_for_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("models", "test"):  # an empty data set
        (tmp_path / folder).mkdir()
    (tmp_path / "results.csv").write_text(
        "scene_id,im_id,obj_id,score,R,t,time\n0,0,1,1.0,1 0 0 0 1 0 0 0 1,0 0 500,0.1\n"
    )
    name = "pipe.json" if arguments[-1] == "--masks" else "pipe.toml"
    os.mkfifo(tmp_path / name)
    told = command(capsys, *arguments, name)
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert f"{name}: expected a regular file, got a pipe" in told.err


def test_a_device_as_gap_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "compare", "--gap", "/dev/full")
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert "/dev/full: expected a regular file, got a device" in told.err
