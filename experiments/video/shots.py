"""The experiments that a video shows: by options, or those of a run's folder."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from experiments.errors import UsageError
from experiments.observing.take import Run, Take, Tell, take
from experiments.reading.resimulation import Choice, finished, resimulate
from experiments.setup.experiment import ExperimentResult, ExperimentSpec
from experiments.units.run_folder import RunFolder
from experiments.units.unit import Unit

MOST = 9  # experiments in one picture


@dataclass(frozen=True, slots=True)
class Shot:
    """An experiment to show, and how it is run again; by default as it stands there."""

    spec: ExperimentSpec
    run: Run | None = None

    def take(self) -> Take:
        """Runs it again.

        Raises:
            UsageError: it came to something else than in the run that it is of.
            SimError: the cell cannot be set up.
        """
        return take(self.spec, self.run)


def shots_of_run(path: Path, choice: Choice) -> list[Shot]:
    """The experiments of a run that were chosen; each is checked to come to the same, bit for bit.

    Args:
        path: the run's folder.
        choice: which; of one part, one number and at most `MOST` methods and policies.

    Raises:
        UsageError: there is no such run or experiment, or too many; or what decides one has changed since.
    """
    specs, pairs = finished(RunFolder.read(path), choice)
    _check(specs)
    return [Shot(spec, partial(_run_again, spec, unit)) for spec, unit in pairs]


def _run_again(spec: ExperimentSpec, unit: Unit, tell: Tell) -> ExperimentResult:
    return resimulate(spec, unit, tell)


def _check(specs: Sequence[ExperimentSpec]) -> None:
    parts = list(dict.fromkeys(spec.part for spec in specs))
    if len(parts) > 1:
        raise UsageError(f"expected --object, one of {', '.join(parts)}, for a run of several")
    if len(specs) > MOST:
        named = ", ".join(dict.fromkeys(spec.method for spec in specs))
        raise UsageError(f"expected --methods, at most {MOST} of {named}, got all of them and every policy")
