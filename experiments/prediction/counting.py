"""Many experiments of which only the counts matter: no logs, one worker pool, results in the order of the specs."""

import sys
from collections.abc import Sequence
from contextlib import closing

from tqdm import tqdm

from cell.records import Tally
from experiments.errors import ExperimentsFailedError
from experiments.setup.experiment import ExperimentSpec, run_experiment
from experiments.setup.pool import run_all


def count_all(specs: Sequence[ExperimentSpec], jobs: int, description: str) -> list[Tally]:
    """What each experiment came to.

    Raises:
        ExperimentsFailedError: one of them failed; the message says which and why.
        BrokenProcessPool: a worker died.
    """
    counts = []
    with (
        tqdm(total=len(specs), unit="experiment", desc=description, dynamic_ncols=True, file=sys.stderr) as progress,
        closing(run_all(count, specs, jobs)) as stream,
    ):
        for spec, (counted, failure) in zip(specs, stream, strict=True):
            if counted is None:
                raise ExperimentsFailedError(
                    f"{spec.part} × {spec.method}, experiment {spec.experiment} failed: {failure}"
                )
            counts.append(counted)
            progress.update()
    return counts


def count(spec: ExperimentSpec) -> tuple[Tally | None, str | None]:
    """An experiment's count, or the reason why there is none."""
    result = run_experiment(spec)
    return result.count, result.failure
