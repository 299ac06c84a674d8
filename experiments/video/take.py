"""An experiment run again, bit for bit, with where everything was and what the controller did at every time."""

from bisect import bisect_right
from dataclasses import dataclass, field, replace

from cell.interfaces import Action, Outcome
from cell.records import AttemptRecord, DecisionRecord, State, TimeSlot, Transition
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, kept_cell, run_experiment
from sim.networks.ground_truth import LatestTruth
from sim.runtime.episode import SimCell
from sim.runtime.film import Film

TIME_OUT = "time-out"


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
class Take:
    """One experiment to show.

    Attributes:
        cell: where it ran.
        film: where everything was.
        history: what was known, in the order of time.
        attempts: every attempt, with the decision that caused it.
        result: what it came to.
    """

    cell: SimCell
    film: Film = field(default_factory=Film)
    history: list[Status] = field(default_factory=lambda: [Status()])
    attempts: list[tuple[DecisionRecord, AttemptRecord]] = field(default_factory=list)
    result: ExperimentResult | None = None

    def status(self, time: float) -> Status:
        """What was known at a time, s."""
        return self.history[max(0, bisect_right(self.history, time + 1e-6, key=lambda status: status.time) - 1)]

    def span(self, attempt: int | None) -> tuple[float, float]:
        """Begin and end of what is to be shown, s: the experiment, or an attempt from the look that caused it on.

        Raises:
            LookupError: there was no attempt of this number; the message says how many there were.
        """
        if attempt is None:
            return 0.0, self.film.duration
        if not 0 <= attempt < len(self.attempts):
            count = len(self.attempts)
            raise LookupError(f"in 0..{count - 1}" if count else "of an experiment that has attempts")
        decided, tried = self.attempts[attempt]
        return decided.observation.frame.time, tried.end

    def keep(self, record: object, _: LatestTruth | None = None) -> None:
        """Takes down what a record changes."""
        now = replace(self.history[-1], time=self.cell.world.time)
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


def take(spec: ExperimentSpec) -> Take:
    """Runs an experiment again and takes down what happens.

    Raises:
        SimError: the cell cannot be set up.
    """
    taken = Take(kept_cell(*spec.cell))
    with taken.film.recording(taken.cell.world):
        taken.result = run_experiment(spec, taken.keep, taken.cell)
    return taken


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
