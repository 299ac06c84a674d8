"""Progress is for those who sit at a terminal."""

import io
import sys

import pytest

from experiments.progress import bar, counted, saying


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_is_told_what_is_done_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)  # pytest sets its own before each test
    assert list(counted([10, 20, 30], "part", "lay out")) == [10, 20, 30]
    with bar("image", total=4, done=1) as progress:
        progress.update(3)
    with saying("run again"):
        assert terminal.getvalue().endswith("run again …\r")
    told = terminal.getvalue()
    assert "lay out" in told
    assert "3/3" in told
    assert "4/4" in told
    assert told.endswith(" \r")  # the last line is gone


def test_where_there_is_no_terminal_nothing_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(counted(iter([1, 2]), "part", total=2)) == [1, 2]
    with bar("image", total=4) as progress, saying("run again"):
        progress.update(4)
    told = capsys.readouterr()
    assert (told.out, told.err) == ("", "")


def test_what_is_over_soon_is_not_counted_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert list(counted([1, 2], "part", after=60.0)) == [1, 2]
    assert terminal.getvalue() == ""
    assert list(counted([1, 2], "part", after=1e-9)) == [1, 2]
    assert "part" in terminal.getvalue()
