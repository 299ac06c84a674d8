"""Calls to code from elsewhere: with a time limit, failures in its name, and its decisions checked."""

import math
import multiprocessing
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import FrameType
from typing import TypeVar

from cell.errors import PolicyError
from cell.interfaces import Action, Decision, Observation, Policy
from maskval import Pose

T = TypeVar("T")

TIME_LIMIT = 300.0  # s of the wall clock per call: a first call on a busy machine may compile for more than 60 s
_AGAIN = 1.0  # s after which time is called once more, if the called code has swallowed the first call


class _TimeUp(BaseException):  # no Exception, so that `except Exception` of the called code does not swallow it
    pass


def guarded_call(call: Callable[[], T], time_limit: float, error_of: Callable[[str], Exception]) -> T:
    """What a call returns, ended after a time limit; whatever it raises becomes one error.

    The limit is kept by an alarm of the operating system: in a process's main thread, on POSIX, and as soon as
    Python runs. A call that swallows the alarm fails when it returns. A worker process that does not come back at all
    is ended after twice the limit and a minute. A process that the call has forked ends here, if it returns.

    Args:
        call: what to do.
        time_limit: s of the wall clock, above 0.
        error_of: makes the error to raise of what went wrong.
    """
    process = os.getpid()
    try:
        with _worker_ended_after(2 * time_limit + 60.0), _limited_to(time_limit):
            return call()
    except _TimeUp:
        raise error_of(f"took longer than {time_limit:g} s") from None
    except (Exception, SystemExit) as error:
        raise error_of(f"raised {describe_error(error)}") from error
    finally:
        if os.getpid() != process:
            os._exit(1)


def describe_error(error: BaseException) -> str:
    """An error in one line: what it is, and the place in which file it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


@contextmanager
def _limited_to(seconds: float) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return
    previous, begun = signal.signal(signal.SIGALRM, _raise_time_up), time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    finally:
        signal.signal(signal.SIGALRM, previous)
    if time.monotonic() - begun > seconds:
        raise _TimeUp  # once more, since the called code has swallowed every alarm


@contextmanager
def _worker_ended_after(seconds: float) -> Iterator[None]:
    """Ends a worker process that is still in here after so many seconds; its parent then knows of it."""
    if multiprocessing.parent_process() is None:
        yield
        return
    _watch()
    _deadline[0] = time.monotonic() + seconds
    try:
        yield
    finally:
        _deadline[0] = math.inf


_deadline = [math.inf]  # when this worker process ends, by the monotonic clock


@cache
def _watch() -> None:
    """Has a thread of this process look at the deadline every second."""

    def look() -> None:
        while time.monotonic() < _deadline[0]:
            time.sleep(_AGAIN)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


def _raise_time_up(_: int, __: FrameType | None) -> None:
    raise _TimeUp


def guarded_decision(policy: Policy, observation: Observation, time_limit: float) -> Decision:
    """The policy's decision.

    Args:
        policy: decides.
        observation: about what.
        time_limit: s of the wall clock, see `ask`.

    Raises:
        PolicyError: the policy raised, or took too long.
    """
    return guarded_call(
        lambda: policy.decide(observation),
        time_limit,
        lambda what: PolicyError(f"{_who(policy, observation)}: {what}"),
    )


def check_decision(decision: object, observation: Observation, policy: Policy | None) -> None:
    """Raises PolicyError unless it is a decision, and about a detection that exists."""
    who = _who(policy, observation)
    if not isinstance(decision, Decision):
        raise PolicyError(f"{who}: expected a cell.interfaces.Decision, got {type(decision).__name__}")
    if not isinstance(decision.action, Action):
        raise PolicyError(f"{who}: expected a cell.interfaces.Action, got {decision.action!r}")
    count, chosen = len(observation.detections), decision.detection
    none_is_due = chosen is None and decision.action is Action.SEARCH
    if not (none_is_due or (isinstance(chosen, Integral) and 0 <= chosen < count)):
        raise PolicyError(f"{who}: expected a detection in 0..{count - 1} to {decision.action}, got {chosen}")
    for name in ("threshold", "u"):
        number = getattr(decision, name)
        if not (number is None or (isinstance(number, Real) and math.isfinite(number))):
            raise PolicyError(f"{who}: expected {name} to be a finite number or None, got {number!r}")
    for name in ("X_BO_est", "X_BC"):
        pose = getattr(decision, name)
        if not (pose is None or isinstance(pose, Pose)):
            raise PolicyError(f"{who}: expected {name} to be a maskval.Pose or None, got {type(pose).__name__}")


def _who(policy: Policy | None, observation: Observation) -> str:
    name = "the decision" if policy is None else type(policy).__name__
    return f"{name} on frame {observation.frame.index}"
