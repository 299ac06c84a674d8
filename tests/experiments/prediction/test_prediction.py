import json
from concurrent.futures.process import BrokenProcessPool

import pytest

from cell.records import Tally
from experiments.cli import main
from experiments.prediction.cells import Rate, predict_cell
from experiments.prediction.counting import Counted
from experiments.prediction.setting import Setting
from experiments.prediction.variants import VARIANTS
from experiments.results.first_attempts import FirstAttempts
from experiments.setup.thresholds import load_thresholds


def count(tp: int, fp: int, fn: int) -> Tally:
    return Tally(parts=8, tp=tp, fp=fp, fn=fn, void=0, unreachable=0, timeouts=8 - tp - fp, duration=100.0)


def test_a_cell_without_variance_predicts_its_rate_and_nothing_else() -> None:
    cell = predict_cell("antenna", "none", [[count(6, 2, 2)] * 5] * 3, (0.75, 0.80), seed=0)
    assert cell.ap == Rate(0.75, (0.75, 0.75), 0.75)
    assert cell.ap.agrees
    assert not cell.ar.agrees
    assert (cell.tp, cell.fp, cell.fn, cell.timeouts, cell.experiments) == (90, 30, 30, 0, 15)


def test_the_interval_is_of_means_over_five_experiments_of_one_world() -> None:
    good, bad = [count(8, 0, 0)] * 5, [count(0, 8, 8)] * 5
    between = predict_cell("antenna", "none", [good, bad], None, seed=0)
    # Five experiments of one world are all good or all bad: the means are 0 and 1, never between.
    assert between.ap == Rate(0.5, (0.0, 1.0), None)
    within = predict_cell("antenna", "none", [[count(8, 0, 0), count(0, 8, 8)] * 5], None, seed=0)
    # In one world, a mean over five is k/5, k binomial of 1/2: P(k = 0) = 1/32 exceeds 2.5 %, so both ends stay in.
    assert within.ap == Rate(0.5, (0.0, 1.0), None)
    steady = predict_cell("antenna", "none", [[count(8, 0, 0)] * 9 + [count(0, 8, 8)]], None, seed=0)
    # k binomial of 1/10 bad ones: P(k >= 2) = 8.1 %, P(k >= 3) = 0.9 %: 95 % reach down to 3/5.
    assert steady.ap.interval == pytest.approx((0.6, 1.0))


def test_an_experiment_without_attempts_is_left_out_of_the_mean_ap() -> None:
    cell = predict_cell("antenna", "none", [[count(0, 0, 8), count(4, 4, 4)]], None, seed=0)
    assert cell.ap.mean == 0.5
    assert cell.ar.mean == pytest.approx((0.0 + 0.5) / 2)


def test_a_cell_without_any_attempt_has_no_ap() -> None:
    cell = predict_cell("antenna", "none", [[count(0, 0, 8)]], (0.9, 0.9), seed=0)
    assert cell.ap == Rate(None, None, 0.9)
    assert cell.ap.agrees is None


def test_every_variant_but_the_base_changes_its_setting() -> None:
    base = Setting(load_thresholds("paper"))
    changed = {name: variant(base) for name, variant in VARIANTS.items() if name != "thresholds-derived"}
    assert changed.pop("base") == base
    assert len(changed) == 20
    assert all(setting != base for setting in changed.values())
    assert len({repr(setting) for setting in changed.values()}) == 20


def test_what_a_variant_changes_stands_above_the_world() -> None:
    setting = VARIANTS["outliers-own"](Setting(load_thresholds("paper")))
    spec = setting.spec("handle", "maskval", (("pose.second_outlier_correlation", 0.5), ("pose.lateral_mm", 0.7)), 3)
    assert dict(spec.noise) == {
        "pose.second_outlier_correlation": 0.0,
        "pose.second_same_content_share": 0.0,
        "pose.lateral_mm": 0.7,
    }
    assert spec.experiment == 3


def test_a_prediction_runs_and_writes_what_it_prints(tmp_path, capsys) -> None:
    with pytest.raises(SystemExit) as end:
        main(
            ["predict", "--objects", "handle", "--methods", "none", "--gap", "none", "--worlds", "1"]
            + ["--experiments", "1", "--jobs", "1", "--out", str(tmp_path)]
        )
    assert end.value.code == 0
    (cell,) = json.loads((tmp_path / "predict.json").read_text())["variants"]["base"]["cells"]
    assert (cell["object"], cell["method"], cell["experiments"]) == ("handle", "none", 1)
    assert cell["tp"] + cell["fp"] + cell["timeouts"] == 8
    assert f"{100 * cell['ap']['mean']:.1f} [" in capsys.readouterr().out


def test_what_ends_a_prediction_early_leaves_the_variants_that_are_finished(tmp_path, capsys, monkeypatch) -> None:
    def counted(specs, jobs, description):
        if description == "speed-fast":
            raise BrokenProcessPool("killed")
        return [Counted(count(8, 0, 0), FirstAttempts(8, 8, 0)) for _ in specs]

    monkeypatch.setattr("experiments.prediction.command.count_all", counted)
    with pytest.raises(SystemExit) as end:
        main(
            ["predict", "--objects", "handle", "--methods", "none", "--worlds", "1", "--experiments", "1"]
            + ["--variants", "base", "speed-fast", "--out", str(tmp_path)]
        )
    told = capsys.readouterr()
    assert (end.value.code, told.err) == (1, "graspcell: error: a worker process died (out of memory?)\n")
    assert "base: mean" in told.out
    assert list(json.loads((tmp_path / "predict.json").read_text())["variants"]) == ["base"]
    assert (tmp_path / "manifest.json").is_file()


def test_compare_with_the_fitted_gap_runs_the_predictions_worlds(tmp_path) -> None:
    for arguments in (
        ["compare", "--gap", "fitted", "--thresholds", "paper", "--experiments", "2"],
        ["predict", "--worlds", "2", "--experiments", "1"],
        ["compare", "--experiments", "2"],
    ):
        with pytest.raises(SystemExit, match=r"^0$"):
            main(
                [*arguments, "--objects", "handle", "--methods", "none", "maskval", "--jobs", "2"]
                + ["--out", str(tmp_path / "-".join(arguments[:2]))]
            )
    table = json.loads((tmp_path / "compare---gap" / "table.json").read_text())
    predicted = json.loads((tmp_path / "predict---worlds" / "predict.json").read_text())["variants"]["base"]
    names = ("method", "tp", "fp", "fn", "timeouts")
    assert [[cell[name] for name in names] for cell in table["cells"]] == [
        [cell[name] for name in names] for cell in predicted["cells"]
    ]
    assert table["paired"] == predicted["paired"]
    assert [row["method"] for row in table["paired"]] == ["none"]
    without = json.loads((tmp_path / "compare---experiments" / "table.json").read_text())
    assert without["cells"][0]["tp"] > table["cells"][0]["tp"]  # real images are harder


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["predict", "--variants", "nonsense"], "unknown variants 'nonsense': expected one of all, base"),
        (["predict", "--objects", "brick"], "unknown objects 'brick': expected one of antenna, handle"),
        (["predict", "--worlds", "0"], "expected --worlds of at least 1"),
        (["predict", "--gap", "nowhere.json"], "no gap for antenna in nowhere.json"),
        (
            ["gap", "--part", "brick"],
            "the paper has no figures of 'brick': expected one of antenna, handle, or a part file",
        ),
        (["gap", "--experiments", "1"], "expected --experiments of at least 2"),
    ],
)
def test_bad_input_is_one_line_that_says_what_is_valid(capsys, arguments, words) -> None:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    told = capsys.readouterr().err
    assert end.value.code == 2
    assert words in told
    assert told.count("\n") == 1
