"""Runs the experiments of a folder that have not ended yet, wherever that may be, and keeps each as it ends."""

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass

from experiments.errors import UsageError
from experiments.progress import bar
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.pool import Died, completed
from experiments.units.identity import describe
from experiments.units.run_folder import RunFolder
from experiments.units.unit import Unit, failed_unit, run_unit
from sim.errors import SimError

Ran = tuple[str, bool, bytes]  # a unit's place, whether it has a result, its bytes
Stream = Generator[tuple[ExperimentSpec, Ran | Died], None, None]
Executor = Callable[[Sequence[ExperimentSpec]], Stream]
_MOST_DEATHS = 5  # in a row: then something is wrong with the machine, not with an experiment


@dataclass(frozen=True, slots=True)
class Ended:
    """How a run came to an early end: in words, with the exit code."""

    reason: str
    code: int


def locally(jobs: int) -> Executor:
    """Runs experiments in so many processes of this machine."""
    return lambda specs: completed(run_unit, specs, jobs)


def missing(folder: RunFolder, specs: Iterable[ExperimentSpec], *, retry_failed: bool) -> list[ExperimentSpec]:
    """Those that have not ended; those that failed are among them if they are to be tried again."""
    left = []
    for spec in specs:
        description = describe(spec)
        if not folder.has(description) and (retry_failed or not folder.has(description, failed=True)):
            left.append(spec)
    return left


def execute(
    folder: RunFolder,
    specs: Sequence[ExperimentSpec],
    total: int,
    executor: Executor,
    enough: Callable[[Unit], bool] | None = None,
) -> Ended | None:
    """Runs experiments and adds their units to the folder.

    Args:
        folder: where they go.
        specs: those to run.
        total: how many there are with those that had ended before, for the progress bar.
        executor: runs them.
        enough: is told every unit that is new; the run ends where it says yes.

    Returns:
        How it ended early; None if it ran all of them, or enough.

    Raises:
        SimError: the cell cannot be set up.
        UsageError: a unit cannot be written.
    """
    deaths, kept = 0, total - len(specs)
    with bar("experiment", total=total, done=total - len(specs)) as progress, closing(executor(specs)) as stream:
        try:
            for spec, ran in stream:
                deaths = deaths + 1 if isinstance(ran, Died) else 0
                if deaths == _MOST_DEATHS:
                    return Ended(f"{deaths} worker processes died one after the other (out of memory?); ended", 1)
                place, ok, packed = _died(spec, ran.times) if isinstance(ran, Died) else ran
                _add(folder, place, packed, ok=ok, kept=f"{kept} of {total}")
                kept += 1
                progress.set_postfix_str(f"{spec.part} × {spec.method}", refresh=False)
                progress.update()
                if enough is not None and enough(Unit.from_bytes(packed, place)):
                    return None
        except KeyboardInterrupt as interrupt:
            return Ended("interrupted", getattr(interrupt, "code", 130))
        except (SimError, UsageError):
            progress.leave = False  # the error is to be the only line
            raise
    return None


def _add(folder: RunFolder, place: str, packed: bytes, *, ok: bool, kept: str) -> None:
    try:
        folder.add(place, packed, ok=ok)
    except UsageError as error:
        raise UsageError(f"{error}; {kept} experiments are kept, and the same command goes on") from error


def _died(spec: ExperimentSpec, times: int) -> Ran:
    unit = failed_unit(spec, f"its worker process died {times} times (out of memory, or killed by what it called)")
    return unit.place, False, unit.to_bytes()
