import errno
import os
from concurrent.futures.process import _ExceptionWithTraceback

import pytest

from experiments.commands import run as run_module
from experiments.failure import explained
from sim.model.parts import load_part
from tests.experiments.command import command


def mistaken(name: str) -> float:
    return load_part(name).mass + "kg"  # type: ignore[operator,no-any-return]


@pytest.mark.parametrize("arguments", [("run",), ("--debug", "run"), ("run", "--debug", "--parts", "1")])
def test_an_unexpected_error_is_one_line_with_its_place_and_with_debug_the_traceback_before_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("one\nand two")

    monkeypatch.setattr(run_module, "run_experiment", fail)
    told = command(capsys, *arguments)
    *before, line, _ = told.err.split("\n")
    assert told.code == 1
    assert line.startswith("graspcell: error: unexpected ZeroDivisionError: one and two (experiments/commands/run.py:")
    assert line.endswith("); graspcell --debug COMMAND shows the traceback")
    assert ("Traceback (most recent call last):" in before) == ("--debug" in arguments)
    assert bool(before) == ("--debug" in arguments)


def test_an_expected_error_too_has_a_traceback_with_debug(capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "--debug", "compare", "--parts", 9)
    assert told.code == 2
    assert told.err.startswith("Traceback")
    assert told.err.endswith("graspcell: error: expected --parts in 1..8, the container's slots, got 9\n")


def test_the_place_is_the_innermost_of_the_package() -> None:
    with pytest.raises(AttributeError) as caught:
        load_part(None)  # type: ignore[arg-type]
    line, code = explained(caught.value)
    assert (code, "(sim/model/parts.py:" in line) == (1, True)


def test_without_a_place_in_the_package_it_is_where_it_was_raised() -> None:
    with pytest.raises(TypeError) as caught:
        mistaken("antenna")
    assert f"({__file__}:{mistaken.__code__.co_firstlineno + 1})" in explained(caught.value)[0]


def test_the_place_of_an_error_in_a_worker_is_the_workers() -> None:
    with pytest.raises(AttributeError) as caught:
        load_part(None)  # type: ignore[arg-type]
    rebuild, parts = _ExceptionWithTraceback(caught.value, caught.value.__traceback__).__reduce__()  # as the pool does
    assert "(sim/model/parts.py:" in explained(rebuild(*parts))[0]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_no_mistake_of_the_program(number: int) -> None:
    error = OSError(number, os.strerror(number), "frames.parquet")
    assert explained(error) == (f"cannot write the results: {os.strerror(number)}", 2)
