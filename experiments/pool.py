"""Runs many experiments in several processes; results come in the order of the specs for any number of workers."""

import multiprocessing
import os
import signal
from collections.abc import Generator, Sequence
from concurrent.futures import ProcessPoolExecutor

from experiments.experiment import ExperimentSpec, Result, run_experiment


def run_all(specs: Sequence[ExperimentSpec], jobs: int) -> Generator[Result, None, None]:
    """Yields one result per spec. Closing the iterator early drops what has not begun.

    Args:
        specs: the experiments.
        jobs: worker processes; 1 runs in this one.
    """
    if jobs == 1 or len(specs) <= 1:
        yield from map(run_experiment, specs)
        return
    # One thread per worker: the workers themselves fill the cores. Spawned, because OpenGL does not survive a fork.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_leave_interrupts_to_parent)
    try:
        yield from pool.map(run_experiment, specs)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
