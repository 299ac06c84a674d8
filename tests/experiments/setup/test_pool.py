import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from experiments.setup import pool
from experiments.setup.pool import run_all


def doubled(number: int) -> int:
    return 2 * number


def process_and(number: int) -> tuple[int, int]:
    time.sleep(0.2)
    return number, os.getpid()


def killed(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def ignores_interrupts(_: int) -> bool:
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_results_come_in_the_order_of_the_tasks(jobs: int) -> None:
    assert list(run_all(doubled, [3, 1, 2], jobs)) == [6, 2, 4]


def test_tasks_run_in_as_many_processes_as_asked_for_and_one_means_this_one() -> None:
    alone = list(run_all(process_and, range(3), 1))
    assert alone == [(number, os.getpid()) for number in range(3)]
    shared = list(run_all(process_and, range(6), 2))
    assert [number for number, _ in shared] == list(range(6))
    processes = {process for _, process in shared}
    assert len(processes) == 2
    assert os.getpid() not in processes


def test_workers_leave_interrupts_to_this_process_which_goes_on_to_hear_them() -> None:
    before = signal.getsignal(signal.SIGINT)
    assert list(run_all(ignores_interrupts, range(2), 2)) == [True, True]
    assert signal.getsignal(signal.SIGINT) is before


def test_closing_early_ends_the_workers_and_what_has_begun() -> None:
    before = multiprocessing.active_children()
    stream = run_all(time.sleep, [0.0, 20.0, 20.0, 20.0], 2)
    next(stream)
    begun = time.monotonic()
    stream.close()
    assert time.monotonic() - begun < 10  # of 20 to 40 s that are left to do
    assert multiprocessing.active_children() == before


def test_a_worker_that_dies_is_an_error_and_no_wait_without_end() -> None:
    with pytest.raises(BrokenProcessPool):
        list(run_all(killed, [0, 1, 2, 3], 2))


def tells_its_process(folder: str) -> None:
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(60)


def begins_and_is_killed(folder: str) -> None:
    stream = run_all(tells_its_process, [folder] * 4, 2)
    next(stream)


def test_workers_end_when_the_process_that_began_them_is_killed(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    parent = context.Process(target=begins_and_is_killed, args=(str(tmp_path),))
    parent.start()
    wait_until(lambda: len(list(tmp_path.iterdir())) == 2)
    workers = [int(path.name) for path in tmp_path.iterdir()]
    assert all(map(is_alive, workers))
    parent.kill()
    parent.join()
    wait_until(lambda: not any(map(is_alive, workers)))


def is_alive(process: int) -> bool:
    """Whether it runs; a process that ended and that nobody has asked about, a zombie, does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 30
    while not holds():
        assert time.monotonic() < end, "waited for 30 s"
        time.sleep(0.05)


@pytest.mark.parametrize("other_threads", [0, 1])
def test_an_interrupt_while_a_task_is_handed_over_is_heard_afterwards(other_threads: int) -> None:
    done = threading.Event()  # a signal to a process goes to any of its threads that does not block it
    for _ in range(other_threads):
        threading.Thread(target=done.wait, daemon=True).start()
    heard = []
    # A shell without job control starts what it puts into the background with interrupts ignored.
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pool._interrupts_held_back():
            os.kill(os.getpid(), signal.SIGINT)
            heard.append("held back")
        heard.append("lost")
    except KeyboardInterrupt:
        heard.append("heard")
    finally:
        signal.signal(signal.SIGINT, previous)
        done.set()
    assert heard == ["held back", "heard"]
