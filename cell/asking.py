"""Asks code from elsewhere a question: in its name whatever goes wrong, and not for ever."""

import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TypeVar

T = TypeVar("T")

TIME_LIMIT = 300.0  # s of the wall clock per question: a first call on a busy machine may compile for more than 60 s
_AGAIN = 1.0  # s after which time is called once more, if the code asked has swallowed the first call


class _TimeUp(BaseException):  # no Exception, so that `except Exception` of the code asked does not swallow it
    pass


def ask(question: Callable[[], T], time_limit: float, refusal: Callable[[str], Exception]) -> T:
    """The answer.

    The limit is kept by an alarm of the operating system: in a process's main thread, on POSIX, and as soon as
    Python runs; code that never comes back from C is not ended. Elsewhere there is no limit.

    Args:
        question: the call.
        time_limit: s of the wall clock, above 0.
        refusal: makes the error to raise of what went wrong.
    """
    try:
        with _limited_to(time_limit):
            return question()
    except _TimeUp:
        raise refusal(f"took longer than {time_limit:g} s") from None
    except (Exception, SystemExit) as error:
        raise refusal(f"raised {told(error)}") from error


def told(error: BaseException) -> str:
    """An error in one line: what it is, and the place in which file it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


@contextmanager
def _limited_to(seconds: float) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return
    previous = signal.signal(signal.SIGALRM, _call_time)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    finally:
        signal.signal(signal.SIGALRM, previous)


def _call_time(_: int, __: FrameType | None) -> None:
    raise _TimeUp
