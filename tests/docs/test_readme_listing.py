"""The README's table and listing are what its commands print, character by character."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
OMITTED = "...\n"  # a line of the README that stands for several


def block(name: str) -> str:
    """The text between the README's markers of this name."""
    (text,) = re.findall(rf"^<!-- {name}: begin -->\n```\n(.*?)^```\n<!-- {name}: end -->$", README, re.M | re.S)
    return str(text)


def printed(arguments: list[str]) -> str:
    """What `graspcell` prints, with these arguments."""
    command = [sys.executable, "-m", "experiments.cli", *arguments]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout


def assert_shows(shown: str, told: str) -> None:
    """The text shown is the one told, but for what it says that it omits."""
    assert shown.count(OMITTED) <= 1
    if OMITTED not in shown:
        assert told == shown
        return
    begin, end = shown.split(OMITTED)
    assert told[: len(begin)] == begin
    assert told[-len(end) :] == end
    assert len(told) > len(begin) + len(end)


def test_an_omission_hides_nothing_but_the_lines_in_its_place() -> None:
    assert_shows("a\n...\nd\n", "a\nb\nc\nd\n")
    for told in ("a\nd\n", "b\nc\nd\n", "a\nb\nc\n", "x\nb\nd\n"):
        with pytest.raises(AssertionError):
            assert_shows("a\n...\nd\n", told)
    with pytest.raises(AssertionError):
        assert_shows("a\n", "a\nb\n")


def test_the_markers_of_the_readme_enclose_the_table_and_the_listing() -> None:
    assert block("table").startswith("object ")
    assert block("run").startswith("$ graspcell run ")


@pytest.mark.study
def test_make_run_prints_the_table_of_the_readme(tmp_path: Path) -> None:
    (line,) = re.findall(r"^\t\$\(BIN\)/graspcell (compare .*) --out \$\(OUT\)$", (ROOT / "Makefile").read_text(), re.M)
    assert_shows(
        f"{block('table')}120 experiments expected = 120 completed + 0 failed; results in {tmp_path}\n",
        printed([*shlex.split(line), "--out", str(tmp_path)]),
    )


@pytest.mark.study
def test_run_prints_the_listing_of_the_readme() -> None:
    command, shown = block("run").split("\n", 1)
    assert_shows(shown, printed(shlex.split(command)[2:]))
