from typing import Any

from experiments.reporting.pictures.choice import by_experiment, chosen

Row = dict[str, Any]


def experiment(method: str, kinds: str) -> Row:
    """Items of kinds f (failed), t (time-out), p (placed) and s (a time-out without a detection)."""
    names = {"f": "failed", "t": "time-out", "p": "placed", "s": "time-out"}
    items = [{"k": names[kind], **({} if kind == "s" else {"f": 0})} for kind in kinds]
    return {"o": "handle", "m": method, "p": "always", "failure": None, "items": items}


def test_failures_come_first_and_the_methods_take_turns_with_their_worst_experiments() -> None:
    listed = [experiment("none", "pf"), experiment("none", "ffp"), experiment("maskval", "pt")]
    assert chosen(listed, 4) == [(1, 0), (1, 1), (2, 1), (0, 1)]


def test_what_is_left_goes_to_the_other_items_of_the_experiments_that_are_simulated_anyway() -> None:
    listed = [experiment("none", "pfp"), experiment("none", "ppp")]
    assert chosen(listed, 3) == [(0, 1), (0, 0), (0, 2)]
    assert chosen(listed, 9) == [(0, 1), (0, 0), (0, 2)]


def test_without_failures_each_method_has_one_experiment_pictured() -> None:
    listed = [experiment("none", "p"), experiment("none", "p"), experiment("maskval", "p")]
    assert chosen(listed, 9) == [(0, 0), (2, 0)]


def test_time_outs_without_a_detection_and_experiments_without_a_result_have_no_pictures() -> None:
    failed = experiment("none", "f") | {"failure": "no result"}
    assert chosen([experiment("none", "s"), failed], 9) == []
    assert chosen([experiment("none", "f")], 0) == []


def test_places_are_gathered_by_experiment() -> None:
    assert by_experiment([(1, 0), (2, 1), (1, 3)]) == {1: [0, 3], 2: [1]}
