from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.prediction.robot_targets import robot_targets
from tests.experiments.command import command
from tests.sim.parts.test_part_file import brick


def test_without_a_file_the_targets_are_the_papers() -> None:
    assert robot_targets("antenna", None) == (0.9, 0.825)


def test_a_part_of_ones_own_takes_the_targets_of_a_file(tmp_path: Path) -> None:
    targets = tmp_path / "targets.toml"
    targets.write_text("ap = 0.7\nar = 1\n")
    assert robot_targets(brick(tmp_path), targets) == (0.7, 1.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ap = 0.7", "expected two lines, ap = A and ar = R, each in 0..1, got {'ap': 0.7}"),
        ("ap = 0.7\nar = 3", "each in 0..1, got"),
        ("ap = true\nar = 0.5", "each in 0..1, got"),
        ("ap = 'x'\nar = 0.5", "each in 0..1, got"),
        ("ap", "no TOML"),
    ],
)
def test_a_malformed_file_is_refused(tmp_path: Path, text: str, words: str) -> None:
    targets = tmp_path / "targets.toml"
    targets.write_text(text)
    with pytest.raises(UsageError) as caught:
        robot_targets("handle", targets)
    assert words in str(caught.value)


def test_a_part_without_figures_is_told_what_to_type(capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "gap", "--part", "bracket")
    assert (told.code, told.err.count("\n")) == (2, 1)
    assert "expected one of antenna, handle" in told.err
    assert "graspcell gap --part FILE.toml --targets TARGETS.toml" in told.err


def test_a_missing_threshold_names_the_command_that_derives_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    part = brick(tmp_path)
    told = command(capsys, "compare", "--objects", part, "--methods", "ensemble-add")
    assert told.code == 2
    assert f"graspcell dataset --objects {part} --methods maskval ensemble-add" in told.err
    assert "graspcell: warning: brick: poses[0]: no grasp from above" in told.err
