import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from experiments.cli import parse
from experiments.commands.compare import asked_by, options_of
from experiments.errors import UsageError
from experiments.reading.resimulation import Choice, finished, resimulate, specs_of
from experiments.units import identity
from experiments.units.identity import describe
from experiments.units.run_folder import RunFolder
from experiments.units.unit import content_digest, unit_of

ONE = Choice(methods=("none",), experiments=(1,))


def asked(out: Path, *arguments: str) -> None:
    """Has the folder's run.json ask for what compare would, and runs nothing."""
    config = parse(["compare", "--out", str(out), *arguments])
    with RunFolder.opened(out) as folder:
        folder.ask(asked_by(config.specs()), options_of(config))


def test_the_options_of_a_run_lead_to_the_experiments_that_its_units_describe(small_run: Path) -> None:
    folder = RunFolder.read(small_run)
    descriptions = [describe(spec) for spec in specs_of(folder)]
    assert len(descriptions) == 4
    assert descriptions == [unit.description for unit in folder.units()]


def test_each_cell_of_a_run_has_the_options_that_it_was_asked_for_with(tmp_path: Path) -> None:
    asked(tmp_path, "--objects", "antenna", "--methods", "none", "maskval", "--u-grasp", "maskval=0.3")
    asked(tmp_path, "--objects", "handle", "--methods", "none", "--policy", "always", "patient", "--experiments", "2")
    folder = RunFolder.read(tmp_path)
    specs = specs_of(folder)
    assert [cell.experiments for cell in folder.asked] == [5, 5, 2, 2]
    assert len(specs) == 5 + 5 + 2 + 2
    firsts = [specs[0], specs[5], specs[10], specs[12]]
    assert [describe(spec) for spec in firsts] == [cell.description for cell in folder.asked]
    assert describe(specs[5])["cell"]["u_grasp"] == 0.3


def test_an_experiment_simulated_again_comes_to_the_same_bits(small_run: Path) -> None:
    specs, pairs = finished(RunFolder.read(small_run), ONE)
    ((spec, unit),) = pairs
    assert specs == [spec]
    told: list[object] = []
    result = resimulate(spec, unit, lambda record, _: told.append(record))
    assert content_digest(unit_of(result).to_bytes()) == content_digest(unit.to_bytes())
    assert len(told) == sum(len(unit.tables[name]) for name in ("transitions", "decisions", "attempts", "slots"))


def test_an_experiment_that_comes_to_something_else_is_refused_with_what_differs(small_run: Path) -> None:
    ((spec, unit),) = finished(RunFolder.read(small_run), ONE)[1]
    first, *others = unit.tables["estimates"]
    tables = {**unit.tables, "estimates": [{**first, "score": first["score"] + 1e-15}, *others]}
    with pytest.raises(
        UsageError, match=r"000001-.* came to something else when it was simulated again: estimates differ"
    ):
        resimulate(spec, replace(unit, tables=tables))


@pytest.mark.parametrize(
    ("choice", "count"),
    [(Choice(), 4), (Choice(experiments=(0,)), 2), (Choice(objects=("handle",), policies=("always",)), 2), (ONE, 1)],
)
def test_experiments_are_chosen_by_their_names_and_numbers(small_run: Path, choice: Choice, count: int) -> None:
    specs, pairs = finished(RunFolder.read(small_run), choice)
    assert [spec for spec, _ in pairs] == specs
    assert len(specs) == count


def test_a_choice_that_takes_nothing_is_refused(small_run: Path) -> None:
    with pytest.raises(UsageError, match=r"with a result, of .*handle × maskval × \w+ 0 to \d.*; got none"):
        finished(RunFolder.read(small_run), Choice(experiments=(7,)))


def test_a_run_of_another_version_is_refused_with_what_differs(
    small_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = {**identity.versions(), "code": "another"}
    monkeypatch.setattr(identity, "versions", lambda: other)
    with pytest.raises(UsageError, match=r"cannot be simulated again: common.versions.code: \w+ there, another here"):
        finished(RunFolder.read(small_run))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "expected the options of this version's compare in run.json: 'actors'"),
        ({"sorted": True}, "expected the options of this version's compare in run.json: .*'sorted'"),
        ({"seed": 6}, "cannot be simulated again: common.seed: 5 there, 6 here"),
        ({"methods": ["maskval"]}, "expected options in run.json that ask for experiment handle.none.always/000000-"),
    ],
)
def test_options_that_do_not_lead_to_the_units_are_refused(
    small_run: Path, tmp_path: Path, options: dict[str, Any], words: str
) -> None:
    shutil.copytree(small_run, tmp_path / "run")
    folder = RunFolder.read(tmp_path / "run")
    folder.asked = [replace(cell, options={**cell.options, **options} if options else {}) for cell in folder.asked]
    with pytest.raises(UsageError, match=words):
        finished(folder)
