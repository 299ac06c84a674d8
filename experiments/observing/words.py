"""A moment of an experiment in words."""

from cell.interfaces import Action, Outcome
from cell.records import DecisionRecord
from experiments.observing.observer import Status

TIME_OUT = "time-out"
SHOWN_FOR = 1.5  # s of the cell's clock that an outcome is told


def in_words(decided: DecisionRecord) -> str:
    """A decision with the u and the threshold that it was made upon; ASCII, which OpenCV can draw."""
    decision = decided.decision
    if decision.detection is None:
        return "nothing found: search"
    u = decided.observation.u(decision, decision.detection)
    if decision.threshold is None:
        return f"u = {u:.3f}: {decision.action}"
    sign = ">" if decision.action is Action.SEARCH else "<="
    return f"u = {u:.3f} {sign} {decision.threshold:.3f}: {decision.action}"


def slot_in_words(status: Status, parts: int) -> str:
    """The time slot that goes on, by its number in the logs, and which there are; the last one where all are over.

    Args:
        status: what is known.
        parts: how many the experiment has, at least 1: as many as time slots.
    """
    return f"time slot {min(len(status.slots), parts - 1)} of 0..{parts - 1}"


def named(outcome: Outcome | None) -> str:
    """The outcome of a time slot; None is a time-out."""
    return TIME_OUT if outcome is None else str(outcome)


def headline(status: Status, time: float, parts: int) -> str:
    """Clock, time slot, state, the newest decision, and what has just ended; one line.

    Args:
        status: what is known.
        time: s.
        parts: how many the experiment has.
    """
    told = [f"{time:6.2f} s", slot_in_words(status, parts), str(status.state)]
    if status.decided is not None:
        told.append(in_words(status.decided))
    ended = just_ended(status, time)
    return " | ".join(told if ended is None else [*told, ended[0].upper()])


def just_ended(status: Status, time: float) -> tuple[str, Outcome | None] | None:
    """What ended a moment ago, in words with the force that stopped it, and its outcome; None of a time-out."""
    attempt = status.attempt
    if attempt is not None and time - attempt.end <= SHOWN_FOR:
        force = f", {attempt.contact.force:.0f} N" if attempt.contact else ""
        return f"{attempt.outcome}{force}", attempt.outcome
    if status.timed_out is not None and time - status.timed_out <= SHOWN_FOR:
        return TIME_OUT, None
    return None
