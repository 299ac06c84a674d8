"""Calls to code from elsewhere: with a time limit, failures in its name, and its decisions checked."""

import math
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
    Python runs; code that never comes back from C is not ended. Elsewhere there is no limit.

    Args:
        call: what to do.
        time_limit: s of the wall clock, above 0.
        error_of: makes the error to raise of what went wrong.
    """
    try:
        with _limited_to(time_limit):
            return call()
    except _TimeUp:
        raise error_of(f"took longer than {time_limit:g} s") from None
    except (Exception, SystemExit) as error:
        raise error_of(f"raised {describe_error(error)}") from error


def describe_error(error: BaseException) -> str:
    """An error in one line: what it is, and the place in which file it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"


@contextmanager
def _limited_to(seconds: float) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return
    previous = signal.signal(signal.SIGALRM, _raise_time_up)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
    finally:
        signal.signal(signal.SIGALRM, previous)


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
