import json
import math
from pathlib import Path

import pytest

from cell.records import Tally
from experiments.results.provenance import write_json
from experiments.results.table import Cell, make_cell

# What issue "The cell runs" promises to whoever reads table.json.
KEYS = [
    *("object", "method", "policy", "experiments", "failed", "parts", "tp", "fp", "fn", "void", "timeouts"),
    *("ap", "ar", "ap_pooled", "ar_pooled", "ap_ci", "ar_ci", "cycle_time_s"),
    *("worlds", "ap_pooled_ci", "ar_pooled_ci", "ap_first", "ap_first_ci", "parts_failed", "same"),
]
RATES = ("ap", "ar", "ap_pooled", "ar_pooled", "ap_ci", "ar_ci", "ap_pooled_ci", "ar_pooled_ci", "cycle_time_s")


def count(tp: int = 0, fp: int = 0, fn: int = 0, void: int = 0, parts: int = 8, duration: float = 100.0) -> Tally:
    return Tally(
        parts=parts,
        tp=tp,
        fp=fp,
        fn=fn,
        void=void,
        unreachable=0,
        timeouts=parts - tp - fp,
        duration=duration,
    )


def cell(*counts: Tally | None) -> Cell:
    return make_cell(("antenna", "maskval", "threshold"), counts)


def test_ap_and_ar_are_averaged_over_experiments_and_pooled_over_attempts() -> None:
    made = cell(count(tp=2, fp=2, fn=3), count(tp=6, fp=0, fn=2))
    assert made.ap == pytest.approx((2 / 4 + 6 / 6) / 2)
    assert made.ar == pytest.approx((2 / 5 + 6 / 8) / 2)
    assert made.ap_pooled == pytest.approx((2 + 6) / (4 + 6))
    assert made.ar_pooled == pytest.approx((2 + 6) / (5 + 8))
    assert made.ap != pytest.approx(made.ap_pooled)


def test_the_papers_ensemble_cell_comes_from_averages_and_from_no_pooling() -> None:
    # 96.0 / 50.0 of 5 × 8 parts: four experiments of 4 placed and 4 left, one of 4 placed, 1 failed, 4 left.
    made = cell(*4 * [count(tp=4, fn=4)], count(tp=4, fp=1, fn=4))
    assert (made.ap, made.ar) == (pytest.approx(0.960), pytest.approx(0.500))
    assert made.ap_pooled == pytest.approx(20 / 21)


def test_an_experiment_without_attempts_has_no_ap_and_is_left_out_of_the_mean() -> None:
    made = cell(count(tp=3, fp=1, fn=5), count(fn=8))
    assert made.ap == pytest.approx(3 / 4)
    assert made.ar == pytest.approx((3 / 8 + 0 / 8) / 2)
    assert made.experiments == 2


def test_an_experiment_that_leaves_nothing_and_places_nothing_has_no_ar() -> None:
    made = cell(count(fp=8), count(tp=8))
    assert made.ar == 1.0
    assert made.ap == (0 / 8 + 8 / 8) / 2


def test_void_attempts_and_time_outs_are_counted_and_change_no_rate() -> None:
    made = cell(count(tp=3, fp=1, fn=4, void=7), count(tp=3, fp=1, fn=4, void=2))
    assert (made.void, made.timeouts) == (7 + 2, (8 - 4) + (8 - 4))
    assert (made.ap, made.ar) == (3 / 4, pytest.approx(3 / 7))


def test_counts_are_sums_over_the_experiments_that_have_a_result() -> None:
    made = cell(count(tp=5, fp=1, fn=2), None, count(tp=7, fp=0, fn=1), None)
    assert (made.experiments, made.failed) == (2, 2)
    assert (made.parts, made.tp, made.fp, made.fn) == (16, 5 + 7, 1 + 0, 2 + 1)


def test_failed_experiments_weigh_nothing_in_any_rate() -> None:
    alone = cell(count(tp=5, fp=1, fn=2))
    beside = cell(None, count(tp=5, fp=1, fn=2), None)
    assert [getattr(beside, rate) for rate in RATES] == [getattr(alone, rate) for rate in RATES]


def test_what_is_undefined_is_none() -> None:
    nothing_happened = cell(count(fn=0, parts=0))
    assert [getattr(nothing_happened, rate) for rate in RATES] == len(RATES) * [None]
    only_failed = cell(None)
    assert [getattr(only_failed, rate) for rate in RATES] == len(RATES) * [None]
    assert (only_failed.experiments, only_failed.failed, only_failed.parts) == (0, 1, 0)


@pytest.mark.parametrize("n", [1, 8, 40])
def test_the_pooled_interval_of_n_out_of_n_begins_where_its_likelihood_is_a_fortieth(n: int) -> None:
    # Clopper-Pearson: the lower end p of n of n solves pⁿ = α / 2 with α = 5 %.
    made = cell(count(tp=n, parts=n))
    assert made.ap_pooled_ci == (pytest.approx(0.025 ** (1 / n)), 1.0)
    assert made.ar_pooled_ci == (pytest.approx(0.025 ** (1 / n)), 1.0)


@pytest.mark.parametrize("n", [1, 8, 40])
def test_the_pooled_interval_of_none_out_of_n_is_that_of_n_out_of_n_mirrored(n: int) -> None:
    made = cell(count(fp=n, fn=n, parts=n))
    assert made.ap_pooled_ci == (0.0, pytest.approx(1 - 0.025 ** (1 / n)))


def test_a_pooled_interval_ends_where_the_binomial_tails_hold_a_fortieth_each() -> None:
    placed, tried = 20, 26
    ends = cell(count(tp=12, fp=4), count(tp=8, fp=2)).ap_pooled_ci
    assert ends is not None

    def at_least(successes: int, p: float) -> float:
        return sum(math.comb(tried, k) * p**k * (1 - p) ** (tried - k) for k in range(successes, tried + 1))

    assert at_least(placed, ends[0]) == pytest.approx(0.025)
    assert 1 - at_least(placed + 1, ends[1]) == pytest.approx(0.025)


def test_the_cycle_time_is_all_time_per_placed_part() -> None:
    made = cell(count(tp=2, duration=60.0), count(tp=0, fn=8, duration=160.0), count(tp=6, duration=90.0))
    assert made.cycle_time_s == pytest.approx((60 + 160 + 90) / (2 + 0 + 6))


def test_nothing_placed_has_no_cycle_time() -> None:
    assert cell(count(fp=8)).cycle_time_s is None


def test_as_json_has_the_keys_of_the_contract_in_their_order() -> None:
    assert list(cell(count(tp=1)).as_json()) == KEYS


def test_json_has_null_for_undefined_and_the_interval_as_two_numbers(tmp_path: Path) -> None:
    path = tmp_path / "table.json"
    write_json(path, {"cells": [cell(count(fn=8)).as_json()]})
    text = path.read_text(encoding="utf-8")
    assert "NaN" not in text
    (read,) = json.loads(text)["cells"]
    assert read["ap"] is None
    assert read["ap_ci"] is None
    assert read["ar"] == 0.0
    assert read["ar_pooled_ci"] == [0.0, pytest.approx(1 - 0.025 ** (1 / 8))]


def test_json_refuses_not_a_number(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "table.json", {"ap": math.nan})


def test_as_many_failed_or_left_as_placed_is_a_rate_of_one_half() -> None:
    made = cell(count(tp=2, fp=2, fn=2))
    assert (made.ap, made.ar, made.ap_pooled, made.ar_pooled) == (0.5, 0.5, 0.5, 0.5)
