from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.reporting.pictures import illustrate
from tests.experiments.reporting.conftest import data_of, report


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "expected 1 to 24 different folders of runs, got none"),
        (["a", "a/."], "expected 1 to 24 different folders of runs, got a a"),
        (["a", "--out", "page.txt"], "expected --out to end in .html, got page.txt"),
        (["a", "--pictures", "-1"], "--pictures"),
        (["a"], "a"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(
    arguments: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert report(*arguments) == 2
    error = capsys.readouterr().err.strip()
    assert told in error
    assert len(error.splitlines()) == 1


def test_pictures_are_counted_and_failures_have_them_first(page: Path) -> None:
    items = [item for one in data_of(page)["experiments"] for item in one["items"]]
    with_pictures = [item for item in items if "wrist" in item]
    assert len(with_pictures) == 3
    failures = [item for item in items if item["k"] in ("failed", "time-out") and "f" in item]
    assert 0 < len(failures) < 3
    assert all("wrist" in item and item["overview"].startswith("data:image/jpeg") for item in failures)
    assert all(item["gripper"].startswith("data:image/jpeg") for item in with_pictures if item["n"] is not None)
    assert not any("gripper" in item for item in with_pictures if item["n"] is None)
    assert data_of(page)["runs"][0]["pictured"].startswith(f"3 of {len(items)} attempts and time-outs")


def test_a_run_that_cannot_be_simulated_again_is_shown_without_pictures_unless_they_were_asked_for(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def changed(*_: object) -> None:
        raise UsageError("experiment x cannot be simulated again")

    monkeypatch.setattr(illustrate, "finished", changed)
    out = tmp_path / "page.html"
    assert report(small_run, "--out", out) == 0
    assert "No pictures and no true poses of run: experiment x cannot" in capsys.readouterr().out
    assert report(small_run, "--out", out, "--pictures", 3) == 2
    assert "experiment x cannot be simulated again" in capsys.readouterr().err


def test_pictures_stop_where_the_page_would_become_too_large(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(illustrate, "MOST_BYTES", 0)
    out = tmp_path / "page.html"
    assert report(small_run, "--out", out, "--pictures", 1) == 0
    assert "1 of 1 pictures were left out" in capsys.readouterr().out
    items = [item for one in data_of(out)["experiments"] for item in one["items"]]
    assert sum("truth" in item for item in items) == 1
    assert not any("wrist" in item for item in items)
