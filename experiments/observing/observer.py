"""What is known of an experiment at every time, as it happens."""

from bisect import bisect_right
from dataclasses import dataclass, field, replace

from cell.interfaces import Outcome
from cell.records import AttemptRecord, DecisionRecord, State, TimeSlot, Transition
from sim.networks.ground_truth import LatestTruth
from sim.runtime.world import World


@dataclass(frozen=True, slots=True)
class Status:
    """What is known at a time.

    Attributes:
        time: from when on, s.
        state: of the controller.
        reason: why it entered it.
        decided: the newest look with the decision upon it, if there has been one.
        attempt: the newest attempt that has ended, if one has.
        slots: outcomes of the time slots that are over; None for a time-out.
        timed_out: when the newest time-out was, s, if there has been one.
    """

    time: float = 0.0
    state: State = State.SEARCH
    reason: str = ""
    decided: DecisionRecord | None = None
    attempt: AttemptRecord | None = None
    slots: tuple[Outcome | None, ...] = ()
    timed_out: float | None = None


@dataclass(slots=True)
class Observer:
    """Takes down what the records of an experiment say; `tell` is for `run_experiment`.

    Attributes:
        world: where it runs.
        history: what was known, in the order of time.
        attempts: every attempt, with the decision that caused it.
    """

    world: World
    history: list[Status] = field(default_factory=lambda: [Status()])
    attempts: list[tuple[DecisionRecord, AttemptRecord]] = field(default_factory=list)

    @property
    def newest(self) -> Status:
        """What is known now."""
        return self.history[-1]

    def at(self, time: float) -> Status:
        """What was known at a time, s."""
        return self.history[max(0, bisect_right(self.history, time + 1e-6, key=lambda status: status.time) - 1)]

    def decisions(self) -> list[DecisionRecord]:
        """Every look with the decision upon it, in the order of time."""
        found = {one.decided.decision_index: one.decided for one in self.history if one.decided is not None}
        return list(found.values())

    def tell(self, record: object, _: LatestTruth | None = None) -> None:
        """Takes down what a record changes."""
        now = replace(self.history[-1], time=self.world.time)
        match record:
            case Transition():
                self.history.append(replace(now, state=record.target, reason=record.reason))
            case DecisionRecord():
                self.history.append(replace(now, decided=record))
            case AttemptRecord():
                causes = [status.decided for status in self.history if status.decided is not None]
                cause = next(one for one in reversed(causes) if one.decision_index == record.decision_index)
                self.attempts.append((cause, record))
                self.history.append(replace(now, attempt=record))
            case TimeSlot():
                timed_out = record.end if record.outcome is None else now.timed_out
                self.history.append(replace(now, slots=(*now.slots, record.outcome), timed_out=timed_out))
