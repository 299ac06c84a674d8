from importlib import util
from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.training.command import _render, _sets
from experiments.training.config import Train
from tests.experiments.command import command

WRONG = [
    (["--object", "mug"], ["unknown object 'mug'", "antenna, handle"]),
    (["--images", "0"], ["--images", "0"]),
    (["--pose-steps", "1"], ["--pose-steps", "1"]),
    (["--seed", "-1"], ["--seed", "-1"]),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_unfit_options_are_refused_in_one_line(
    arguments: list[str], words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = command(capsys, "train", *arguments, "--out", tmp_path)
    assert told.code == 2
    assert all(word in told.err for word in words)
    assert told.err.count("\n") == 1


def test_missing_packages_are_named_with_their_extra(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    find = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda name: None if name == "torch" else find(name))
    told = command(capsys, "train", "--out", tmp_path)
    assert told.code == 2
    assert "train needs torch" in told.err
    assert "graspcell[train]" in told.err


def test_pictures_of_both_styles_and_held_out_ones_share_their_views(tmp_path: Path) -> None:
    sets = _sets(Train(out=tmp_path, images=20, held_out=5, seed=3))
    assert [(one.style, one.split, one.images, one.seed) for one in sets] == [
        ("s1", "train", 20, 3),
        ("s2", "train", 20, 3),
        ("s1", "held-out", 5, 3),
    ]
    assert {(one.distance_m, one.elevation_deg) for one in sets} == {((0.35, 0.8), (50.0, 90.0))}
    assert [one.out for one in sets] == [tmp_path / "pictures" / name for name in ("s1", "s2", "held-out")]


def test_pictures_that_are_there_are_used_and_others_are_refused(tmp_path: Path) -> None:
    pictures = _sets(Train(out=tmp_path, images=2))[0]
    rgb = pictures.out / "train" / "000000" / "rgb"
    rgb.mkdir(parents=True)
    (rgb / "000000.jpg").touch()
    with pytest.raises(UsageError, match="not complete: delete the folder"):
        _render(pictures)
    (pictures.out / "manifest.json").touch()
    with pytest.raises(UsageError, match="holds 1 pictures, expected 2"):
        _render(pictures)
    (rgb / "000001.jpg").touch()
    _render(pictures)
