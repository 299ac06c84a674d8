"""What is said where an experiment cannot be watched."""

import sys
from pathlib import Path

import pytest

from tests.experiments.command import command

SHORT = ("run", "--object", "handle", "--method", "maskval", "--parts", 2)


def test_without_a_display_the_window_is_refused_and_the_browser_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("experiments.viewing.watch.load_rerun", lambda: None)  # as if the extra were installed
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for view in (("--view",), ("--view", "window"), ("--view", "--rerun", tmp_path / "a.rrd")):
        told = command(capsys, *SHORT, *view)
        assert told.code == 2
        assert "--view opens a window and needs a display with OpenGL, but there is none here" in told.err
        assert "expected --view web" in told.err
        assert told.out == ""
        assert len(told.err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("module", "options", "extra"),
    [("viser", ("--view", "web"), "view"), ("rerun", ("--rerun", "a.rrd"), "rerun")],
)
def test_a_missing_extra_is_named_before_anything_runs(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    module: str,
    options: tuple[str, ...],
    extra: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setattr("experiments.commands.run.run_experiment", lambda *_: pytest.fail("an experiment was run"))
    told = command(capsys, *SHORT, *options)
    assert told.code == 2
    assert f"expected the extra: pip install 'graspcell[{extra}]'" in told.err
    assert told.out == ""
    assert len(told.err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--view", "phone"), "unknown view 'phone': expected one of window, web"),
        (("--view", "web", "window"), "expected --view, --view window or --view web, got web window"),
        (("--rerun", "a.mp4"), "expected --rerun to end in .rrd, got a.mp4"),
    ],
)
def test_bad_options_are_one_line(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str) -> None:
    told = command(capsys, *SHORT, *options)
    assert told.code == 2
    assert words in told.err
