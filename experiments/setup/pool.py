"""Runs many tasks in several processes; results come in the order of the tasks for any number of workers."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from typing import Any, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(
    job: Callable[[Task], Result], tasks: Sequence[Task], jobs: int, *, apart: bool = False
) -> Generator[Result, None, None]:
    """Yields one result per task, in order. Closing the generator early ends the workers at once.

    Args:
        job: a module's function, so that other processes can import it.
        tasks: what to call it with.
        jobs: worker processes; 1 runs in this process.
        apart: whether one worker is a process of its own, too: for libraries that do not bear one another.

    Raises:
        BrokenProcessPool: a worker died, for example without memory.
    """
    with workers(min(jobs, len(tasks)), apart=apart) as run:
        yield from run(job, tasks)


Run = Callable[[Callable[[Any], Any], Sequence[Any]], Iterator[Any]]  # of a job on tasks, in order


@dataclass(frozen=True, slots=True)
class Died:
    """In place of a result: the worker process of a task died, so many times; the last time with this task alone."""

    times: int = 2


def completed(
    job: Callable[[Task], Result], tasks: Iterable[Task], jobs: int
) -> Generator[tuple[Task, Result | Died], None, None]:
    """Yields every task with its result as soon as there is one; only a few tasks are under way at any time.

    When a worker dies, the tasks under way are tried again one by one, each in a process of its own, so that the one
    that kills its worker is found and the others are not lost.

    Args:
        job: a module's function, so that other processes can import it.
        tasks: what to call it with.
        jobs: worker processes; 1 runs in this process.
    """
    left = deque(tasks)
    if jobs <= 1:
        while left:
            task = left.popleft()
            yield task, job(task)
    while left:
        under_way: dict[Future[Result], Task] = {}
        try:
            yield from _completed_in_a_pool(job, left, jobs, under_way)
        except BrokenProcessPool:
            for task in under_way.values():
                yield task, _alone(job, task)


def _completed_in_a_pool(
    job: Callable[[Task], Result], left: deque[Task], jobs: int, under_way: dict[Future[Result], Task]
) -> Iterator[tuple[Task, Result]]:
    """As `completed`, until a worker dies: `under_way` then holds the tasks of which nobody knows how they ended."""
    with _pool(min(jobs, len(left))) as pool:
        while left or under_way:
            while left and len(under_way) < jobs + 1:  # one ahead, so that no worker waits
                with _interrupts_held_back():
                    under_way[pool.submit(job, left[0])] = left[0]
                left.popleft()
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                result = future.result()
                yield under_way.pop(future), result


def _alone(job: Callable[[Task], Result], task: Task) -> Result | Died:
    try:
        with _pool(1) as pool:
            with _interrupts_held_back():
                future = pool.submit(job, task)
            return future.result()
    except BrokenProcessPool:
        return Died()


@contextmanager
def workers(jobs: int, *, apart: bool = False) -> Iterator[Run]:
    """Processes that stay for several rounds of tasks, with what a job keeps in memory; 1 runs here unless `apart`."""
    if jobs <= 1 and not apart:
        yield map
        return
    with _pool(jobs) as pool:

        def run(job: Callable[[Task], Result], tasks: Sequence[Task]) -> Iterator[Result]:
            with _interrupts_held_back():
                futures = deque(pool.submit(job, task) for task in tasks)
            return (futures.popleft().result() for _ in tasks)  # what was yielded is forgotten

        yield run


ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Worker processes, which end with this block; at once if it ends by an error.

    One thread each: the workers themselves fill the cores. Spawned, because OpenGL does not survive a fork.
    """
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_begin_worker)
    try:
        yield pool
    except BaseException:
        # Nothing is cancelled: Python 3.11's pool fails on cancelled tasks when its workers end.
        for worker in set(multiprocessing.active_children()) - before:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


def _begin_worker() -> None:
    """Leaves Ctrl-C to the parent, and ends with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()


def _end_with_parent() -> None:
    """Ends this process when its parent has ended, for whatever reason; otherwise it would go on without use."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        sentinel = parent.sentinel
        threading.Thread(target=lambda: (wait_for([sentinel]), os._exit(1)), daemon=True).start()


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Processes started meanwhile do not hear Ctrl-C, which a terminal sends to all; this one hears it afterwards.

    The mask is for those processes, which inherit it; here another thread may still get the signal, and Python hands
    it to this one, so that it is also noted instead of acted upon.
    """
    heard: list[int] = []
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    handler = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, handler)
        if heard:
            signal.raise_signal(signal.SIGINT)
