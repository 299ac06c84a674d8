from dataclasses import replace

import pytest

from cell.records import Tally
from experiments.commands.config import Compare
from experiments.results import paired
from experiments.results.pair_tests import Contrast, PairTest
from experiments.results.paired import Paired, difference_interval, format_paired
from experiments.setup.actors import Actors
from experiments.setup.experiment import ExperimentResult
from experiments.statistics.mcnemar import PairedParts
from experiments.units.summary import counted_of, make_pairs
from experiments.units.unit import unit_of


def count(tp: int, fp: int) -> Tally:
    return Tally(parts=8, tp=tp, fp=fp, fn=8 - tp, void=0, unreachable=0, timeouts=8 - tp - fp, duration=100.0)


def pair(part: str, counts: dict[str, list[list[Tally | None]]]) -> list[Paired]:
    """Methods with one policy."""
    return paired.pair(part, {(method, "threshold"): groups for method, groups in counts.items()})


def singles(*counts: Tally | None) -> list[list[Tally | None]]:
    return [[one] for one in counts]


def test_differences_are_taken_within_experiments_and_the_interval_is_students() -> None:
    # Placed +1, +3, +2: mean 2, standard error 1 / sqrt(3), and t at 97.5 % with 2 degrees of freedom is 4.3027.
    (row,) = pair(
        "antenna",
        {
            "contour": singles(count(3, 1), count(7, 0), count(8, 0)),
            "maskval": singles(count(2, 1), count(4, 2), count(6, 1)),
        },
    )
    assert (row.object, row.method, row.reference, row.experiments) == ("antenna", "contour", "maskval", 3)
    assert row.placed == pytest.approx(2.0)
    assert row.placed_ci == pytest.approx((2 - 4.3027 / 3**0.5, 2 + 4.3027 / 3**0.5), abs=1e-4)
    assert row.failed == pytest.approx(-1.0)
    assert row.failed_ci == pytest.approx((-1 - 4.3027 / 3**0.5, -1 + 4.3027 / 3**0.5), abs=1e-4)


def test_experiments_that_one_of_both_did_not_finish_are_left_out() -> None:
    (row,) = pair(
        "antenna",
        {"maskval": singles(count(4, 0), None, count(4, 0)), "none": singles(count(5, 3), count(8, 0), None)},
    )
    assert (row.experiments, row.placed, row.placed_ci, row.failed) == (1, 1.0, None, 3.0)
    assert pair("antenna", {"maskval": singles(None), "none": singles(count(8, 0))}) == []


def test_experiments_of_one_world_count_once_in_the_interval() -> None:
    # Two worlds that differ by +2 and +4 on average: one degree of freedom, t = 12.706, standard error 1.
    (row,) = pair(
        "handle",
        {
            "maskval": [[count(4, 0), count(4, 0)], [count(2, 0), count(2, 0)]],
            "none": [[count(5, 0), count(7, 0)], [count(6, 0), count(6, 0)]],
        },
    )
    assert (row.experiments, row.placed) == (4, 3.0)
    assert row.placed_ci == pytest.approx((3 - 12.706, 3 + 12.706), abs=1e-3)


def test_equal_differences_of_twenty_experiments_are_bounded_by_none_of_n() -> None:
    # 160 slots correlated by a half within experiments of 8 count as 160 / 4.5; none of n: 1 - .025^(1/n).
    share = 1 - 0.025 ** (4.5 / 160)
    (row,) = pair(
        "antenna",
        {"maskval": singles(*20 * [count(4, 0)]), "none": singles(*20 * [count(5, 0)])},
    )
    assert row.placed_ci == pytest.approx((1 - 8 * share, 1 + 8 * share))
    assert row.failed_ci == pytest.approx((-8 * share, 8 * share))
    assert 8 * share == pytest.approx(0.79, abs=0.005)


def test_fewer_worlds_have_a_wider_bound_and_more_experiments_in_them_hardly_a_narrower_one() -> None:
    few, many = (difference_interval(n * [0.0], n * [[8]]) for n in (2, 40))
    assert few[0] < many[0] < 0 < many[1] < few[1]
    again = difference_interval(2 * [0.0], 2 * [[8, 8, 8, 8]])
    assert 0.85 * few[1] < again[1] < few[1]


def test_a_difference_is_never_more_than_all_parts() -> None:
    assert difference_interval([7.0, 7.0], [[8], [8]])[1] == 8.0
    assert difference_interval([-7.0, -7.0], [[8], [8]])[0] == -8.0


def test_differences_that_vary_keep_students_interval_and_one_world_has_none() -> None:
    assert difference_interval([1.0, 3.0], [[8], [8]]) == pytest.approx((2 - 12.706, 2 + 12.706), abs=1e-3)
    assert difference_interval([1.0], [[8, 8]]) is None
    assert difference_interval([], []) is None


def test_without_maskval_the_first_method_is_the_reference() -> None:
    rows = pair("antenna", {"none": singles(count(4, 0)), "a": singles(count(5, 0)), "b": singles(count(2, 0))})
    assert [(row.method, row.reference, row.placed) for row in rows] == [("a", "none", 1.0), ("b", "none", -2.0)]


def test_policies_are_named_where_a_method_has_several() -> None:
    counts = {("maskval", "threshold"): 4, ("maskval", "fuse"): 5, ("none", "always"): 2}
    rows = paired.pair("antenna", {who: singles(count(tp, 0)) for who, tp in counts.items()})
    assert [(row.policy, row.reference_policy, row.placed) for row in rows] == [
        ("fuse", "threshold", 1.0),
        ("always", "threshold", -2.0),
    ]
    told = format_paired(rows)
    assert "less those of maskval + threshold" in told
    assert "antenna  maskval + fuse  +1.00" in told


def test_one_experiment_has_no_interval_and_one_method_has_no_lines() -> None:
    (row,) = pair("antenna", {"maskval": singles(count(4, 0)), "a": singles(count(5, 0))})
    assert row.placed_ci is None
    told = format_paired([row])
    assert "less those of maskval" in told
    assert "  +1.00 [–]" in told
    assert format_paired(pair("antenna", {"maskval": singles(count(4, 0))})) == ""


def test_the_lines_hold_both_intervals() -> None:
    row = Paired("handle", "contour", "threshold", "maskval", "threshold", 20, 0.75, (0.21, 1.29), -0.1, (-0.3, 0.1))
    told = format_paired([row])
    assert "handle  contour  +0.75 [+0.21, +1.29]  " in told
    assert "  -0.10 [-0.30, +0.10]  " in told
    assert told.endswith("    20")


def test_the_p_of_a_row_is_that_of_its_pair_whichever_comes_first() -> None:
    row = Paired("handle", "contour", "threshold", "maskval", "threshold", 20, 0.75, (0.21, 1.29), -0.1, (-0.3, 0.1))
    nothing = Contrast(0.0, None, 1.0)
    test = PairTest(
        *("handle", ("maskval", "threshold"), ("contour", "threshold"), 20, 20, PairedParts(1, 1, 1, 1), 1.0),
        *((-1.0, 1.0), nothing, nothing, None, None, None),
    )
    for p, shown in ((0.034, " .03"), (0.0001, "<.01"), (1.0, "1.00"), (0.5, " .50")):
        told = format_paired([row], [replace(test, p_holm=p)]).splitlines()
        assert f"[+0.21, +1.29]    {shown}  -0.10" in told[2]
        assert told[1].index("p ") == told[2].index(shown)
        assert max(map(len, told)) <= 85


def test_experiments_of_compare_with_one_error_model_are_a_group() -> None:
    config = Compare(
        objects=("handle",), methods=("none", "maskval"), experiments=21, actors=Actors(gap="fitted"), jobs=1
    )
    specs = config.specs()
    assert specs[20].noise == specs[0].noise  # the worlds begin anew
    # "none" places 4 more in the experiments 0 and 20 and as many in the others: world 0 counts once, so 4 / 20.
    more = {("none", 0): 4, ("none", 20): 4}
    results = [
        ExperimentResult(
            spec, count(2 + more.get((spec.method, spec.experiment), 0), 0), None, {"attempts": [], "estimates": []}
        )
        for spec in specs
    ]
    (row,) = make_pairs([counted_of(unit_of(result)) for result in results])
    assert (row.experiments, row.placed) == (21, pytest.approx(4 / 20))
    plain = [replace(result, spec=replace(result.spec, noise=())) for result in results]
    (row,) = make_pairs([counted_of(unit_of(result)) for result in plain])
    assert row.placed == pytest.approx(8 / 21)
