import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from cell import guards
from cell.guards import guarded_call


def refusal(what: str) -> Exception:
    return ValueError(f"it {what}")


def busy() -> None:
    while True:
        sum(range(1000))


def swallows() -> None:
    begun = time.monotonic()
    while time.monotonic() - begun < 20:
        with contextlib.suppress(Exception):
            time.sleep(20)


def swallows_and_returns() -> int:
    begun = time.monotonic()
    while time.monotonic() - begun < 0.2:
        with contextlib.suppress(BaseException):
            time.sleep(0.2)
    return 7


def never_returns() -> None:
    while True:
        with contextlib.suppress(BaseException):
            time.sleep(20)


def in_a_worker(_: int) -> None:
    guards._deadline[0] = 0.0  # as if twice the limit and a minute were over
    guards._watch()
    never_returns()


def raises() -> None:
    raise ZeroDivisionError("by nothing")


def test_an_answer_is_handed_on_and_no_alarm_is_left() -> None:
    before = signal.getsignal(signal.SIGALRM)
    assert guarded_call(lambda: 7, 5.0, refusal) == 7
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is before


@pytest.mark.parametrize("hangs", [busy, swallows, lambda: time.sleep(20)])
def test_what_hangs_is_ended_after_the_limit_and_no_alarm_is_left(hangs: Callable[[], Any]) -> None:
    before, begun = signal.getsignal(signal.SIGALRM), time.monotonic()
    with pytest.raises(ValueError, match=r"^it took longer than 0\.05 s$"):
        guarded_call(hangs, 0.05, refusal)
    assert 0.05 <= time.monotonic() - begun < 5.0
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is before


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (raises, "it raised ZeroDivisionError: by nothing"),
        (lambda: sys.exit("bye"), "it raised SystemExit: bye"),
    ],
)
def test_what_is_raised_is_refused_with_its_kind_and_cause(question: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=rf"^{words} \(test_guards\.py:\d+\)$") as refused:
        guarded_call(question, 5.0, refusal)
    assert refused.value.__cause__ is not None


def test_ctrl_c_is_nobodys_failure() -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        guarded_call(interrupted, 5.0, refusal)


def test_a_call_that_swallows_its_alarms_and_returns_has_failed() -> None:
    with pytest.raises(ValueError, match=r"^it took longer than 0\.05 s$"):
        guarded_call(swallows_and_returns, 0.05, refusal)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_a_worker_that_never_comes_back_ends() -> None:
    process = multiprocessing.get_context("spawn").Process(target=in_a_worker, args=(0,))
    process.start()
    process.join(30)
    assert process.exitcode == 1


def test_a_process_that_the_call_has_forked_ends_where_the_call_does() -> None:
    this, report = os.getpid(), os.pipe()

    def forks() -> int:
        return os.fork()

    child = guarded_call(forks, 5.0, refusal)
    if os.getpid() != this:  # it has come out of the call, which it must not
        os.write(report[1], b"x")
        os._exit(0)
    os.close(report[1])
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1
    assert os.read(report[0], 1) == b""
    os.close(report[0])


def test_outside_of_the_main_thread_there_is_no_limit() -> None:
    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(guarded_call, lambda: time.sleep(0.05) or 7, 0.01, refusal).result() == 7
