"""A run's experiments simulated again, bit for bit, for what the run did not keep: images, motions, videos.

Shared by whatever makes something of a finished experiment that its tables do not hold.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from experiments.commands.config import Compare
from experiments.errors import UsageError
from experiments.results.counted import Of
from experiments.setup.actors import Actors
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from experiments.setup.policies import policy_name
from experiments.units.asked import Asked
from experiments.units.identity import Description, describe, differences
from experiments.units.run_folder import RunFolder
from experiments.units.summary import of
from experiments.units.unit import Unit, content_digest, unit_of
from sim.model.conditions import Conditions
from sim.model.parts import load_part
from sim.networks.ground_truth import LatestTruth
from sim.runtime.episode import SimCell


@dataclass(frozen=True, slots=True)
class Choice:
    """Which experiments of a run: those of all objects, methods, policies and numbers, or of the named ones."""

    objects: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    policies: tuple[str, ...] = ()
    experiments: tuple[int, ...] = ()

    def takes(self, unit: Unit) -> bool:
        """Whether a unit is one of them."""
        chosen = self.objects, self.methods, self.policies, self.experiments
        own = *of(unit.description), unit.description["experiment"]
        return all(not names or name in names for names, name in zip(chosen, own, strict=True))


ALL = Choice()


def specs_of(folder: RunFolder) -> list[ExperimentSpec]:
    """The experiments that a run was asked for, cell by cell, as the options in its run.json say.

    Raises:
        UsageError: the options are not of this version, or name what does not exist here.
    """
    return [spec for cell in folder.asked for spec in _specs_of_cell(cell, folder.path)]


def finished(
    folder: RunFolder, choice: Choice = ALL
) -> tuple[list[ExperimentSpec], Iterator[tuple[ExperimentSpec, Unit]]]:
    """The experiments of a run that have a result: all of them, then one by one with its unit, cell by cell, by number.

    Args:
        folder: the run's.
        choice: which of them.

    Raises:
        UsageError: there is none; or one cannot be simulated again, since what decides it has changed: the message
            says what.
    """
    asked = {_key(describe(spec)): spec for spec in specs_of(folder)}

    def pairs() -> Iterator[tuple[ExperimentSpec, Unit]]:
        for unit in folder.units():
            if unit.failure is None and choice.takes(unit):
                yield _matching(asked.get(_key(unit.description)), unit, folder.path), unit

    specs = [spec for spec, _ in pairs()]
    if not specs:
        has = ", ".join(
            f"{' × '.join(cell.of[key] for key in ('object', 'method', 'policy'))} 0 to {cell.experiments - 1}"
            for cell in folder.asked
        )
        raise UsageError(f"{folder.path}: expected an experiment with a result, of {has}; got none of what was chosen")
    return specs, pairs()


def resimulate(
    spec: ExperimentSpec,
    unit: Unit,
    tell: Callable[[object, LatestTruth], None] | None = None,
    cell: SimCell | None = None,
) -> ExperimentResult:
    """Runs an experiment once more; see `run_experiment` for `tell` and `cell`.

    Raises:
        UsageError: it came to something else than its unit, in any bit.
    """
    result = run_experiment(spec, tell, cell)
    again = unit_of(result)
    if content_digest(again.to_bytes()) != content_digest(unit.to_bytes()):
        raise UsageError(
            f"experiment {unit.place} came to something else when it was simulated again: "
            f"{', '.join(_differing(unit, again))} differ; expected the machine and the settings of the run"
        )
    return result


def _specs_of_cell(cell: Asked, path: Path) -> Iterator[ExperimentSpec]:
    try:
        config = replace(_compare_of(cell.options), experiments=cell.experiments, out=path)
    except (TypeError, KeyError, AttributeError) as error:
        raise UsageError(f"{path}: expected the options of this version's compare in run.json: {error}") from error
    for spec in config.specs():
        name, policy = load_part(spec.part).part.name, policy_name(spec.policy, spec.method)
        if (name, spec.method, policy) == of(cell.description):
            yield spec


def _compare_of(options: dict[str, Any]) -> Compare:
    """The command's options, as JSON has them, as they were parsed."""
    given = _with_tuples(options)
    folders = {name: given["actors"].get(name) for name in ("recorded", "networks")}
    paths = {name: None if folder is None else Path(folder) for name, folder in folders.items()}
    actors = Actors(**{**given["actors"], **paths})
    return Compare(**{**given, "actors": actors, "conditions": Conditions(**given["conditions"])})


def _with_tuples(value: Any) -> Any:
    """JSON's lists as the tuples that they were."""
    if isinstance(value, dict):
        return {name: _with_tuples(one) for name, one in value.items()}
    return tuple(map(_with_tuples, value)) if isinstance(value, list) else value


def _key(description: Description) -> tuple[Of, int]:
    return of(description), description["experiment"]


def _matching(spec: ExperimentSpec | None, unit: Unit, path: Path) -> ExperimentSpec:
    """The experiment of a unit, if this version and this machine have what it was made from."""
    if spec is None:
        raise UsageError(f"{path}: expected options in run.json that ask for experiment {unit.place}, got others")
    changed = differences(unit.description, describe(spec))
    if changed:
        raise UsageError(
            f"experiment {unit.place} cannot be simulated again: {'; '.join(changed)}; expected the version, parts and "
            "files of the run"
        )
    return spec


def _differing(unit: Unit, again: Unit) -> list[str]:
    named = [field.name for field in fields(Unit) if field.name != "tables"]
    return [
        *(name for name in named if getattr(unit, name) != getattr(again, name)),
        *(name for name in unit.tables if unit.tables[name] != again.tables.get(name)),
    ]
