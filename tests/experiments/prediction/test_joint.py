import math
from dataclasses import asdict

import pytest

from cell.records import Tally
from experiments.prediction.cells import PredictedCell, predict_cell
from experiments.prediction.joint import joint

EVEN = [0, 1, 2, 3, 4, 4, 5, 6, 7, 8]  # placed of 8, in ten worlds


def rate(successes: int) -> Tally:
    """An experiment whose AP and AR are both an eighth of the successes."""
    fails = 8 - successes
    return Tally(parts=8, tp=successes, fp=fails, fn=fails, void=0, unreachable=0, timeouts=0, duration=100.0)


def cell(successes: list[int], paper: float, method: str = "maskval", part: str = "handle") -> PredictedCell:
    """A cell of one experiment per world; AP and AR of the paper are equal."""
    return predict_cell(part, method, [[rate(one)] for one in successes], (paper, paper), seed=0)


def test_p_is_the_share_of_the_replicates_at_least_as_far_as_the_papers_figures() -> None:
    # From the mean of ten worlds, 4/8, two are as far as 8/8, and four at least as far as 6.5/8.
    assert joint([cell(EVEN, 1.0)], 0)["handle"].p == 2 / 10
    assert joint([cell(EVEN, 6.5 / 8)], 0)["handle"].p == 4 / 10
    assert joint([cell(EVEN, 0.5)], 0)["handle"].p == 1.0


def test_methods_of_one_part_share_their_worlds() -> None:
    # Both methods are equal in every world, so that 7/8 beside 1/8 is impossible, though each alone is common.
    worlds = [1, 1, 1, 4, 4, 4, 4, 7, 7, 7]
    apart = [cell(worlds, 7 / 8, "maskval"), cell(worlds, 1 / 8, "ensemble-add")]
    assert joint(apart, 0)["handle"].p == 0.0
    alike = [cell(worlds, 7 / 8, "maskval"), cell(worlds, 7 / 8, "ensemble-add")]
    assert joint(alike, 0)["handle"].p == 6 / 10
    assert joint(alike, 0)["handle"].figures == 4


def test_figures_that_never_vary_tell_against_others() -> None:
    certain = [cell(9 * [8], 1.0)]
    assert (joint(certain, 0)["handle"].p, joint(certain, 0)["handle"].energy_score) == (1.0, 0.0)
    assert joint([cell(9 * [8], 0.9)], 0)["handle"].p == 0.0


def test_the_energy_score_of_two_points_is_the_sum_worked_by_hand() -> None:
    # The points (0, 0) and (1, 1), as often; the paper at one of them: √2/2 - (√2/2)/2.
    found = joint([cell([0, 8], 1.0)], 0)["handle"]
    assert found.energy_score == pytest.approx(math.sqrt(2) / 4, abs=0.03)  # of 2,000 drawn: √2/2 · 3 · .5/√2000


def test_a_random_tables_score_is_that_of_the_unit_square() -> None:
    # Mean distance of the square's points from its centre, (√2 + asinh 1)/6, less half of that between two, .5214.
    found = joint([cell([4, 4], 0.5)], 0)["handle"]
    expected = (math.sqrt(2) + math.asinh(1)) / 6 - 0.521405 / 2
    assert found.random_energy_score == pytest.approx(expected, abs=0.01)
    assert found.energy_score < found.random_energy_score


def test_only_cells_that_the_paper_has_and_the_gap_is_not_fitted_to_are_judged() -> None:
    assert joint([cell([0, 8], 1.0, "none")], 0) == {}
    unknown = predict_cell("handle", "random", [[rate(4)]], None, seed=0)
    assert joint([unknown], 0) == {}
    assert joint([cell([0, 8], 1.0), cell([0, 8], 1.0, "none"), unknown], 0)["handle"].figures == 2


def test_several_parts_have_worlds_of_their_own_and_one_figure_of_all() -> None:
    found = joint([cell(EVEN, 1.0), cell(EVEN, 1.0, part="antenna")], 0)
    assert list(found) == ["handle", "antenna", "all"]
    assert found["all"].figures == 4
    # Both at an end: 4 of 100 pairs of worlds, for the parts are independent.
    assert found["all"].p == pytest.approx(4 / 100, abs=0.015)


def test_replicates_without_attempts_are_left_out_and_none_at_all_has_no_entry() -> None:
    idle = Tally(parts=8, tp=0, fp=0, fn=8, void=0, unreachable=0, timeouts=8, duration=100.0)
    some = predict_cell("handle", "maskval", [[idle], [rate(4)], [rate(6)]], (0.5, 0.5), seed=0)
    assert joint([some], 0)["handle"].p == 1.0
    nothing = predict_cell("handle", "maskval", [[idle]], (0.5, 0.5), seed=0)
    assert joint([nothing], 0) == {}


def test_equal_seeds_give_equal_figures() -> None:
    cells = [predict_cell("handle", "maskval", [[rate(2), rate(7)], [rate(3), rate(8)]], (0.9, 0.9), seed=0)]
    first, again, other = (asdict(joint(cells, seed)["handle"]) for seed in (4, 4, 5))
    assert first == again != other
