import json

import numpy as np
import pytest

from experiments.calibration.command import UNREACHED, miss
from experiments.calibration.images import ErrorModelTrial, ImageSet, run_trial
from experiments.calibration.noise_file import rewrite
from experiments.calibration.targets import FitTarget
from experiments.cli import main
from sim.networks.noise_model import load_noise, noise_text, read_noise

IMAGES = ImageSet("handle", seed=5, images=40)
TARGETS = """
[target.mask]
ap_50_95 = {{ value = {ap}, sd = 0.002 }}
[target.maskval]
spearman = {{ value = {spearman}, sd = 0.005 }}
[prior.mask]
field_cells = {{ center = 0.15, spread = 0.5 }}
[prior.pose]
rotation_deg = {{ center = 0.52, spread = 0.5 }}
lateral_mm = {{ center = 0.5, spread = 0.5 }}
"""


def command(*arguments: str) -> object:
    with pytest.raises(SystemExit) as end:
        main(["calibrate", *arguments])
    return end.value.code


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A fit to what a model with other parameters gives on the same images."""
    folder = tmp_path_factory.mktemp("calibrate")
    truth = load_noise("handle").changed({"mask.field_cells": 0.25, "pose.rotation_deg": 0.8})
    of_masks, of_methods = run_trial(ErrorModelTrial(IMAGES, truth, methods=True))
    (folder / "targets.toml").write_text(TARGETS.format(ap=of_masks.ap_50_95, spearman=of_methods["maskval"].spearman))
    arguments = ["--part", "handle", "--targets", str(folder / "targets.toml"), "--images", "40", "--seed", "5"]
    for jobs in ("1", "2"):
        code = command(*arguments, "--draws", "2", "--rounds", "3", "--jobs", jobs, "--out", str(folder / jobs))
        assert code == 0
    return folder


def test_a_fit_reaches_the_figures_of_a_model_with_other_parameters(fitted) -> None:
    found = json.loads((fitted / "1" / "calibration.json").read_text())
    before = run_trial(ErrorModelTrial(IMAGES, load_noise("handle"), methods=True))
    starts = {"mask": before[0].ap_50_95, "maskval": before[1]["maskval"].spearman}
    assert len(found["targets"]) == 2
    for target in found["targets"]:
        assert abs(target["reached"] - target["value"]) < 0.5 * abs(starts[target["group"]] - target["value"])
        assert abs(target["reached"] - target["value"]) < 3 * target["sd"]


def test_the_noise_file_that_it_writes_holds_the_fitted_values(fitted) -> None:
    found = json.loads((fitted / "1" / "calibration.json").read_text())
    written = read_noise((fitted / "1" / "noise.toml").read_text(), "noise.toml")
    values = {one["name"]: one["fitted"] for one in found["parameters"]}
    assert len(values) == 3
    for name, value in values.items():
        assert written.number(name) == pytest.approx(value, rel=1e-3)  # four digits
    assert written.changed(dict.fromkeys(values, 1.0)) == load_noise("handle").changed(dict.fromkeys(values, 1.0))


def test_the_ensemble_holds_exactly_the_members_that_fit_as_well(fitted) -> None:
    found = json.loads((fitted / "1" / "calibration.json").read_text())
    accepted = [member["values"] for member in found["members"] if member["accepted"]]
    assert len(found["members"]) == 2
    assert json.loads((fitted / "1" / "ensemble.json").read_text()) == accepted
    for member in found["members"]:
        misses = [
            (member["figures"][f"{target['group']} {target['figure']}"] - target["value"]) / target["sd"]
            for target in found["targets"]
        ]
        assert member["accepted"] == (max(map(abs, misses)) <= 3.0)


def test_the_number_of_workers_changes_nothing(fitted) -> None:
    for name in ("calibration.json", "noise.toml", "ensemble.json"):
        assert (fitted / "1" / name).read_bytes() == (fitted / "2" / name).read_bytes()


def test_a_trial_gives_the_figures_that_the_dataset_command_prints(tmp_path) -> None:
    with pytest.raises(SystemExit) as end:
        main(
            ["dataset", "--objects", "handle", "--seed", "5", "--images", "40", "--resamples", "1", "--jobs", "1"]
            + ["--out", str(tmp_path)]
        )
    assert end.value.code == 0
    (one,) = json.loads((tmp_path / "dataset.json").read_text())["objects"]
    of_masks, of_methods = run_trial(ErrorModelTrial(IMAGES, load_noise("handle"), methods=True))
    assert {name: one["mask"][name] for name in of_masks._fields} == pytest.approx(of_masks._asdict())
    for method in ("maskval", "ensemble-add"):
        printed = {name: one["methods"][method][name] for name in of_methods[method]._fields}
        assert printed == pytest.approx(of_methods[method]._asdict())


def test_a_figure_that_does_not_exist_misses_by_the_most() -> None:
    targets = [
        FitTarget("maskval", "u_tg", 0.5, 0.1),
        FitTarget("mask", "ap_50", 0.9, 1e-6),
        FitTarget("mask", "ar_100", 0.9, 0.1),
    ]
    figures = {("maskval", "u_tg"): None, ("mask", "ap_50"): 1.0, ("mask", "ar_100"): 0.75}
    assert miss(targets, figures) == pytest.approx(np.array([-UNREACHED, UNREACHED, -1.5]))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--part", "brick"], "unknown object 'brick'"),
        (["--targets", "brick"], "no calibration for 'brick'"),
        (["--targets", "none.toml"], "calibration file none.toml does not exist"),
        (["--images", "0"], "expected --images of at least 1"),
        (["--rounds", "0"], "expected --rounds of at least 1"),
    ],
)
def test_bad_input_is_one_line_that_says_what_is_valid(capsys, arguments, words) -> None:
    assert command(*arguments) == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1


def test_a_fit_that_starts_at_a_noise_file_keeps_what_it_does_not_fit(fitted) -> None:
    start = fitted / "start.toml"
    start.write_text(rewrite(noise_text("handle"), {"pose.depth_ratio": (3.3, "mine")}))
    arguments = ["--part", "handle", "--targets", str(fitted / "targets.toml"), "--start", str(start)]
    arguments += ["--images", "10", "--rounds", "1", "--draws", "0", "--jobs", "1", "--out", str(fitted / "started")]
    assert command(*arguments) == 0
    assert read_noise((fitted / "started" / "noise.toml").read_text(), "noise.toml").pose.depth_ratio == 3.3
