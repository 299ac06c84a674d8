"""Many experiments of which only the counts matter: no logs, one worker pool, results in the order of the specs."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass

from cell.records import Tally
from experiments.errors import ExperimentsFailedError
from experiments.progress import bar
from experiments.results.first_attempts import FirstAttempts
from experiments.setup.experiment import ExperimentSpec, run_experiment
from experiments.setup.pool import run_all


@dataclass(frozen=True, slots=True)
class Counted:
    """What an experiment came to, and what its first attempts did."""

    count: Tally
    first: FirstAttempts


def count_all(specs: Sequence[ExperimentSpec], jobs: int, description: str) -> list[Counted]:
    """What each experiment came to.

    Raises:
        ExperimentsFailedError: one of them failed; the message says which and why.
        BrokenProcessPool: a worker died.
    """
    counts = []
    with (
        bar("experiment", description, total=len(specs)) as progress,
        closing(run_all(count, specs, jobs)) as stream,
    ):
        for spec, (counted, first, failure) in zip(specs, stream, strict=True):
            if counted is None or first is None:
                raise ExperimentsFailedError(
                    f"{spec.part} × {spec.method}, experiment {spec.experiment} failed: {failure}"
                )
            counts.append(Counted(counted, first))
            progress.update()
    return counts


def count(spec: ExperimentSpec) -> tuple[Tally | None, FirstAttempts | None, str | None]:
    """An experiment's counts, or the reason why there are none."""
    result = run_experiment(spec)
    return result.count, result.first, result.failure
