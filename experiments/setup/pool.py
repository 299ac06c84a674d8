"""Runs many tasks in several processes; results come in the order of the tasks for any number of workers."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(job: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Generator[Result, None, None]:
    """Yields one result per task, in order. Closing the generator early ends the workers at once.

    Args:
        job: a module's function, so that other processes can import it.
        tasks: what to call it with.
        jobs: worker processes; 1 runs in this process.

    Raises:
        BrokenProcessPool: a worker died, for example without memory.
    """
    with workers(min(jobs, len(tasks))) as run:
        yield from run(job, tasks)


Run = Callable[[Callable[[Any], Any], Sequence[Any]], Iterator[Any]]  # of a job on tasks, in order


@contextmanager
def workers(jobs: int) -> Iterator[Run]:
    """Processes that stay for several rounds of tasks, with what a job keeps in memory; 1 runs in this process."""
    if jobs <= 1:
        yield map
        return
    # One thread per worker: the workers themselves fill the cores. Spawned, because OpenGL does not survive a fork.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_end_with_parent)

    def run(job: Callable[[Task], Result], tasks: Sequence[Task]) -> Iterator[Result]:
        with _interrupts_ignored():
            futures = deque(pool.submit(job, task) for task in tasks)
        return (futures.popleft().result() for _ in tasks)  # what was yielded is forgotten

    try:
        yield run
    except BaseException:
        # Nothing is cancelled: Python 3.11's pool fails on cancelled tasks when its workers end.
        for worker in set(multiprocessing.active_children()) - before:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


def _end_with_parent() -> None:
    """Ends this process when its parent has ended, for whatever reason; otherwise it would go on without use."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        sentinel = parent.sentinel
        threading.Thread(target=lambda: (wait([sentinel]), os._exit(1)), daemon=True).start()


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes started meanwhile ignore Ctrl-C, which a terminal sends to all: the parent ends them."""
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
