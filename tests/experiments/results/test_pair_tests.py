import pytest

from cell.records import Tally
from experiments.results.counted import Counted, parts_placed
from experiments.results.pair_tests import PairTest, letters, pair_tests
from experiments.statistics.mcnemar import PairedParts, mcnemar_p, tango_interval


def counted(method: str, experiment: int, placed: str, fp: int = 0, part: str = "antenna") -> Counted:
    """An experiment whose parts were placed (1) or not (0), in 10 s a part."""
    tp, parts = placed.count("1"), len(placed)
    count = Tally(parts, tp, fp, parts - tp, 0, 0, parts - tp, 10.0 * parts)
    return Counted(
        (part, method, "threshold"), experiment, experiment, count, None, tuple(one == "1" for one in placed)
    )


def by_pair(*ones: Counted) -> dict[tuple[str, str], PairTest]:
    return {(test.first[0], test.second[0]): test for test in pair_tests(ones)}


def test_parts_are_paired_within_experiments_that_both_have() -> None:
    ones = [counted("a", 0, "1110"), counted("a", 1, "1111"), counted("b", 0, "1000"), counted("b", 2, "0000")]
    test = by_pair(*ones)["a", "b"]
    assert (test.experiments, test.worlds) == (1, 1)
    assert test.parts == PairedParts(both=1, first_only=2, second_only=0, neither=1)
    assert (test.mcnemar_p, test.share_ci) == (mcnemar_p(test.parts), tango_interval(test.parts))
    assert test.placed.difference == 2.0


def test_figures_are_ratios_of_sums_and_their_p_is_over_worlds() -> None:
    a = [counted("a", number, "1111") for number in range(8)]
    b = [counted("b", number, "1100", fp=2) for number in range(8)]
    test = by_pair(*a, *b)["a", "b"]
    assert test.placed.difference == pytest.approx(2.0)
    assert test.failed.difference == pytest.approx(-2.0)
    assert test.ap is not None
    assert test.ap.difference == pytest.approx(1 - 2 / 4)
    assert test.ar is not None
    assert test.ar.difference == pytest.approx(1 - 2 / 4)
    assert test.cycle_time_s is not None
    assert test.cycle_time_s.difference == pytest.approx(10 - 20)  # 40 s for 4 parts, and for 2
    assert test.placed.p == pytest.approx(2 / 2**8)  # all eight worlds one way: two of all choices of signs
    assert test.mcnemar_p == pytest.approx(2 / 2**16)


def test_a_figure_that_one_of_both_lacks_has_no_contrast() -> None:
    test = by_pair(counted("a", 0, "11"), counted("b", 0, "00"))["a", "b"]
    assert (test.cycle_time_s, test.ap) == (None, None)  # b has placed none and tried none
    assert test.ar is not None


def test_p_is_adjusted_for_all_pairs_of_the_table_by_holm() -> None:
    ones = [counted("a", n, "1111") for n in range(8)] + [counted("b", n, "1100") for n in range(8)]
    ones += [counted("c", n, "1111" if n else "0111") for n in range(8)]
    tests = by_pair(*ones)
    raw = 2 / 2**8
    assert tests["a", "b"].placed.p == tests["b", "c"].placed.p == pytest.approx(raw)
    assert tests["a", "b"].p_holm == pytest.approx(3 * raw)  # the smallest of three
    assert tests["a", "c"].p_holm == tests["a", "c"].placed.p == 1.0  # one world differs: either sign is as far


def test_methods_share_a_letter_unless_they_are_told_apart() -> None:
    ones = [counted("a", n, "1111") for n in range(10)] + [counted("b", n, "1000") for n in range(10)]
    ones += [counted("c", n, "1111" if n else "0111") for n in range(10)]
    found = letters(pair_tests(ones), ones)
    assert found == {
        ("antenna", "a", "threshold"): "a",
        ("antenna", "c", "threshold"): "a",
        ("antenna", "b", "threshold"): "b",
    }


def test_objects_are_apart_and_failed_experiments_left_out() -> None:
    failed = Counted(("antenna", "b", "threshold"), 0, 0, None, None, (), "no room")
    assert pair_tests([counted("a", 0, "11"), failed, counted("b", 0, "11", part="handle")]) == []


def test_a_part_is_placed_by_the_attempt_on_a_detection_that_shows_it() -> None:
    estimates = [{"frame": 0, "detection": 0, "true_part": 2}, {"frame": 1, "detection": 0, "true_part": None}]
    attempts = [
        {"frame": 0, "detection": 0, "outcome": "placed"},
        {"frame": 1, "detection": 0, "outcome": "placed"},
    ]
    assert parts_placed({"estimates": estimates, "attempts": attempts}, 3) == (False, False, True)
    attempts[0]["outcome"] = "void"
    assert parts_placed({"estimates": estimates, "attempts": attempts}, 3) == (False, False, False)
