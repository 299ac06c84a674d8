"""A video of a run: what it shows is what happened, and options that its record says are refused."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments.observing.take import Take, take
from experiments.reading.resimulation import Choice, finished
from experiments.units.run_folder import RunFolder
from experiments.units.unit import content_digest, unit_of
from experiments.video.tile import Tile
from tests.experiments.command import command
from tests.experiments.video.test_video import frames_of

ONE = Choice(methods=("none",), experiments=(1,))
OPTIONS = ("--methods", "none", "--experiment", 1, "--speed-up", 20, "--frames-per-second", 4, "--height", 120)


def test_the_frames_of_a_run_are_of_an_experiment_that_came_to_the_same_bits(
    capsys: pytest.CaptureFixture[str], small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Take] = []

    def tile(taken: Take, height: int, samples: int) -> Tile:
        drawn.append(taken)
        return Tile(taken, height, samples)

    monkeypatch.setattr("experiments.video.make.Tile", tile)
    told = command(capsys, "video", small_run, *OPTIONS, "--out", tmp_path / "cell.mp4")
    assert told.code == 0
    ((spec, unit),) = finished(RunFolder.read(small_run), ONE)[1]
    (shown,) = drawn
    assert shown.result is not None
    assert content_digest(unit_of(shown.result).to_bytes()) == content_digest(unit.to_bytes())

    again = take(spec)
    assert shown.film.duration == again.film.duration > 5.0
    for time in np.linspace(0.0, again.film.duration, 50):
        assert np.array_equal(shown.film.at(time), again.film.at(time))
    frames, expected = frames_of(tmp_path / "cell.mp4"), Tile(again, 120, 1)
    first, last = expected.draw(0.0).astype(int), expected.draw(again.film.duration).astype(int)
    expected.close()
    compression = 4.0  # grey levels: the mean departure of H.264
    assert np.abs(first - last).mean() > 2 * compression
    assert np.abs(frames[0] - first).mean() < compression
    assert np.abs(frames[-1] - last).mean() < compression


def test_an_experiment_that_comes_to_something_else_is_refused_and_leaves_no_file(
    capsys: pytest.CaptureFixture[str], small_run: Path, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    shutil.copytree(small_run, run)
    ((_, unit),) = finished(RunFolder.read(run), ONE)[1]
    first, *others = unit.tables["estimates"]
    other = replace(unit, tables={**unit.tables, "estimates": [{**first, "score": first["score"] + 1e-15}, *others]})
    (file,) = (path for path in run.rglob("*") if path.is_file() and path.read_bytes() == unit.to_bytes())
    file.write_bytes(other.to_bytes())
    told = command(capsys, "video", run, *OPTIONS, "--out", tmp_path / "cell.mp4")
    assert told.code == 2
    assert "came to something else when it was simulated again: estimates differ" in told.err
    assert len(told.err.strip().splitlines()) == 1
    assert not (tmp_path / "cell.mp4").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--seed", 3), "expected no --seed with a run, whose record says it"),
        (("--parts", 2, "--light", 0.5), "expected no --parts, --light with a run, whose record says it"),
        (("--u-grasp", "none=0.2"), "expected no --u-grasp with a run, whose record says it"),
        (("--experiment", 7), "experiment with a result"),
    ],
)
def test_what_the_runs_record_says_cannot_be_told_anew(
    capsys: pytest.CaptureFixture[str], small_run: Path, tmp_path: Path, options: tuple[Any, ...], words: str
) -> None:
    told = command(capsys, "video", small_run, *options, "--out", tmp_path / "cell.mp4")
    assert told.code == 2
    assert words in told.err
    assert len(told.err.strip().splitlines()) == 1
