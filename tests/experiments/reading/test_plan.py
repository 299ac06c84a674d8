"""graspcell plan: from a pilot's scatter to a number of experiments."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from cell.records import Tally
from experiments.commands.compare import asked_by, options_of
from experiments.commands.config import Compare
from experiments.setup.actors import Actors
from experiments.statistics.pilot import correlation_within, measure_pilot
from experiments.statistics.planning import plan_bound, plan_difference
from experiments.units.identity import describe
from experiments.units.run_folder import RunFolder
from experiments.units.unit import Unit
from tests.experiments.command import Told, command

PLACED = {"none": (4, 6, 5, 3, 7, 4), "maskval": (6, 7, 7, 5, 7, 7)}


def pilot(folder: Path, placed: dict[str, Sequence[int]] = PLACED, gap: str = "none") -> Path:
    """A run in which every method has placed so many of 8 parts in its experiments; the others failed."""
    count = len(next(iter(placed.values())))
    config = Compare(objects=("handle",), methods=tuple(placed), experiments=count, actors=Actors(gap=gap))
    specs = config.specs()
    with RunFolder.opened(folder) as run:
        run.ask(asked_by(specs), options_of(config))
        for spec in specs:
            tp = placed[spec.method][spec.experiment]
            tally = Tally(8, tp, 8 - tp, 8 - tp, 0, 0, 0, 90.0)
            unit = Unit(describe(spec), tally, None, None, None, {"attempts": [], "estimates": []})
            run.add(unit.place, unit.to_bytes(), ok=True)
    return folder


def planned(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: object) -> Told:
    return command(capsys, "plan", folder, *arguments)


def test_a_difference_is_planned_by_the_scatter_of_the_pilot(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = planned(capsys, pilot(tmp_path), "placed(maskval) > placed(none)", "--wanted", 0.5)
    scatter = measure_pilot([[a - b] for a, b in zip(PLACED["maskval"], PLACED["none"], strict=True)])
    assert told.code == 0
    assert told.out.startswith("handle: placed(maskval) > placed(none)\n")
    assert "pilot: 6 experiments in 6 worlds, difference +1.667, standard deviation 1.033" in told.out
    for name, one in (("its scatter", scatter), ("the upper end of its scatter", scatter.cautious(0.8))):
        count = plan_difference(one, 0.5).experiments
        assert f"to find 0.500 with a power of 80 % with {name}: {count} experiments" in told.out


def test_a_bound_is_planned_by_the_attempts_and_their_correlation(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = planned(capsys, pilot(tmp_path), "handle:ap(maskval) >= 0.9", "--power", 0.5)
    hits = PLACED["maskval"]
    correlation = correlation_within(hits, [8] * 6)
    assert f"pilot: 39 of 48 in 6 experiments, correlation within them {correlation:.2f}" in told.out
    assert "if the true rate is 0.812: no number, since that is not above the bound" in told.out
    found = plan_bound(0.9, 1.0, 8.0, correlation, power=0.5, confidence=0.975)
    assert f"if the true rate is 1.000: {found.experiments} experiments; {found.attempts} attempts" in told.out


def test_worlds_that_repeat_limit_what_can_be_found(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    placed = {name: [*counts[:5]] * 5 for name, counts in PLACED.items()}  # 25 experiments: five worlds come twice
    told = planned(capsys, pilot(tmp_path, placed, gap="fitted"), "placed(maskval) > placed(none)", "--wanted", 0.01)
    assert "no number over 20 worlds; the power is" in told.out


def test_a_pilot_without_scatter_says_what_is_needed(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    told = planned(capsys, pilot(tmp_path, {"none": (4, 4), "maskval": (5, 5)}), "placed(maskval) > placed(none)")
    assert "it does not vary, or has no difference: a larger pilot, or --wanted, is needed" in told.out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "expected at least one condition"),
        (("ap(maskvall) >= 0.9",), "expected a method of the pilot, none, maskval, got maskvall"),
        (("mug:ap(maskval) >= 0.9",), "expected an object of handle"),
        (("failed(maskval) <= 0.5",), "expected a bound on ap or ar from below"),
        (("ap(maskval)",), "expected a condition such as"),
        (("ap(maskval) >= 0.9", "--power", 1.0), "expected --power above 0.05 and below 1, got 1"),
        (("ap(maskval) >= 0.9", "--wanted", 0), "expected --wanted above 0"),
    ],
)
def test_what_cannot_be_planned_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[object, ...], words: str
) -> None:
    told = planned(capsys, pilot(tmp_path), *arguments)
    assert (told.code, words in told.err) == (2, True)
    assert len(told.err.strip().splitlines()) == 1


def test_a_folder_without_a_run_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    told = planned(capsys, tmp_path, "ap(maskval) >= 0.9")
    assert (told.code, "expected the folder of a run" in told.err) == (2, True)
