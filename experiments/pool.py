"""Runs many tasks in several processes; results come in the order of the tasks for any number of workers."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(job: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Generator[Result, None, None]:
    """Yields one result per task, in order. Closing the generator early drops what has not begun.

    Args:
        job: a module's function, so that other processes can import it.
        tasks: what to call it with.
        jobs: worker processes; 1 runs in this one.
    """
    jobs = min(jobs, len(tasks))
    if jobs <= 1:
        yield from map(job, tasks)
        return
    # One thread per worker: the workers themselves fill the cores. Spawned, because OpenGL does not survive a fork.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_leave_interrupts_to_parent)
    try:
        yield from pool.map(job, tasks)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
