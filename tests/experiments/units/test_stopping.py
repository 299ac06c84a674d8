"""--until: a run stops where its conditions are answered, with the same experiments for any number of workers."""

from pathlib import Path

import pytest

from cell.records import Tally
from experiments.commands.config import Compare
from experiments.errors import UsageError
from experiments.results.counted import Counted
from experiments.setup import experiment
from experiments.units.stopping import Stopping
from tests.experiments.command import Told, command, overriding
from tests.experiments.comparisons import contents, table_of

SPECS = Compare(objects=("antenna",), methods=("none", "maskval"), experiments=200).specs()
OF = {"none": ("antenna", "none", "always"), "maskval": ("antenna", "maskval", "threshold")}


def counted(method: str, experiment: int, tp: int) -> Counted:
    return Counted(OF[method], experiment, experiment, Tally(8, tp, 8 - tp, 8 - tp, 0, 0, 0, 100.0), None)


def test_an_answer_comes_with_the_leading_experiments_only() -> None:
    forward, backward = (Stopping(["ap(maskval) >= 0.5"], SPECS) for _ in range(2))
    count = 0
    while not forward.add(counted("maskval", count, 8)):
        count += 1
    for number in range(199, count, -1):  # later ones that are there already say nothing
        assert not backward.add(counted("maskval", number, 8))
    for number in range(count, 0, -1):
        assert not backward.add(counted("maskval", number, 8))
    assert backward.experiments is None
    assert backward.add(counted("maskval", 0, 8))
    assert forward.experiments == backward.experiments == count + 1


def test_two_methods_are_compared_on_the_experiments_that_both_have() -> None:
    stopping = Stopping(["placed(maskval) > placed(none)"], SPECS)
    assert not any(stopping.add(counted("maskval", number, 8)) for number in range(200))
    added = [stopping.add(counted("none", number, 4)) for number in range(50)]
    assert True in added
    assert stopping.experiments == added.index(True) + 1
    (line,) = stopping.lines()
    assert line.startswith("antenna: placed(maskval) > placed(none): yes, after ")


def test_a_condition_that_is_false_is_answered_no() -> None:
    stopping = Stopping(["ap(maskval) >= 0.9"], SPECS)
    assert True in [stopping.add(counted("maskval", number, 2)) for number in range(100)]
    assert "0.9: no, after " in stopping.lines()[0]


def test_an_experiment_without_a_result_counts_neither_way() -> None:
    stopping = Stopping(["ap(maskval) >= 0.5"], SPECS)
    stopping.add(Counted(OF["maskval"], 0, 0, None, None, (), "no room"))
    assert stopping.lines() == ["antenna: ap(maskval) >= 0.5: nothing is known yet"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ap(maskvall) >= 0.9", "expected one of none, maskval in --until, got maskvall"),
        ("mug:ap(maskval) >= 0.9", "expected an object of antenna in"),
        ("ap(maskval)", "expected a condition such as"),
    ],
)
def test_conditions_on_what_is_not_compared_are_refused(text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words.replace("(", r"\(")):
        Stopping([text], SPECS)


def test_a_method_with_several_policies_is_refused() -> None:
    specs = Compare(objects=("antenna",), methods=("maskval",), policy=("fuse", "threshold")).specs()
    with pytest.raises(UsageError, match="expected one policy with --until, got 2 for maskval"):
        Stopping(["ap(maskval) >= 0.9"], specs)


def compared(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object) -> Told:
    small = ("--objects", "antenna", "--methods", "none", "--parts", 1, "--estimator", "oracle", "--speed", "fast")
    return command(capsys, "compare", *overriding(*small, "--experiments", 60, "--out", out, *arguments))


def test_a_run_stops_where_it_is_answered_for_any_number_of_workers(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    condition = ("--until", "ap(none) >= 0.5")
    told = compared(capsys, tmp_path / "one", *condition, "--jobs", 1)
    assert told.code == 0
    assert "ap(none) >= 0.5: yes, after " in told.out
    (cell,) = table_of(tmp_path / "one")
    assert 4 < cell["experiments"] < 30
    assert compared(capsys, tmp_path / "two", *condition, "--jobs", 2).code == 0
    one, two = (
        {name: file for name, file in contents(tmp_path / run).items() if "units" not in name} for run in ("one", "two")
    )
    assert one == two
    monkeypatch.setattr(experiment, "run_experiment", None)  # nothing runs again
    assert compared(capsys, tmp_path / "one", *condition, "--jobs", 1).code == 0
    assert {name: file for name, file in contents(tmp_path / "one").items() if "units" not in name} == one


def test_a_share_cannot_answer(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    told = compared(capsys, tmp_path, "--until", "ap(none) >= 0.5", "--shard", "1/2")
    assert (told.code, "expected --until without --shard" in told.err) == (2, True)
