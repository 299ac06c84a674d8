"""What the controller writes down: one record per frame, decision, attempt, slot and change of state."""

from dataclasses import dataclass
from enum import StrEnum

from cell.interfaces import Contact, Decision, Frame, Observation, Outcome
from maskval import Pose


class State(StrEnum):
    """The states of the cycle."""

    SEARCH = "search"
    LOOK = "look"
    DECIDE = "decide"
    REFINE = "refine"
    APPROACH = "approach"
    DESCEND = "descend"
    CLOSE = "close"
    LIFT = "lift"
    TRANSFER = "transfer"
    INSERT = "insert"
    RELEASE = "release"
    RETREAT = "retreat"
    DONE = "done"


# The state machine: from each state to those that may follow. A time slot may end, and the experiment with it, after
# every look, attempt and way back.
TRANSITIONS: dict[State, frozenset[State]] = {
    State.SEARCH: frozenset({State.LOOK, State.SEARCH, State.RETREAT, State.DONE}),
    State.LOOK: frozenset({State.DECIDE}),
    State.DECIDE: frozenset({State.DECIDE, State.SEARCH, State.REFINE, State.APPROACH, State.DONE}),
    State.REFINE: frozenset({State.LOOK, State.DECIDE, State.SEARCH, State.RETREAT}),
    State.APPROACH: frozenset({State.DESCEND, State.RETREAT}),
    State.DESCEND: frozenset({State.CLOSE, State.RETREAT}),
    State.CLOSE: frozenset({State.LIFT, State.RETREAT}),
    State.LIFT: frozenset({State.TRANSFER, State.RETREAT}),
    State.TRANSFER: frozenset({State.INSERT, State.RETREAT}),
    State.INSERT: frozenset({State.RELEASE, State.RETREAT}),
    State.RELEASE: frozenset({State.RETREAT}),
    State.RETREAT: frozenset({State.RETREAT, State.SEARCH, State.DONE}),
    State.DONE: frozenset(),
}


@dataclass(frozen=True, slots=True)
class Transition:
    """From one state to another, at a time (s), for a reason in words."""

    time: float
    source: State
    target: State
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class DecisionRecord:
    """An observation and the decision upon it; `decision_index` counts the decisions of an experiment from 0."""

    slot: int
    decision_index: int
    observation: Observation
    decision: Decision

    @property
    def detection(self) -> int:
        """The detection that the decision is about; there is one unless it is to search on."""
        assert self.decision.detection is not None  # `check_decision` has seen to it
        return self.decision.detection

    @property
    def X_BO_est(self) -> Pose:
        """The pose to act upon: the policy's own, or the detection's."""
        return self.decision.X_BO_est or self.observation.X_BO_est(self.detection)


@dataclass(frozen=True, slots=True, eq=False)
class FailedFrame:
    """A frame upon which nothing was decided, because an estimator, the method or the policy failed.

    Attributes:
        frame: the picture.
        refining: whether it was taken to have another look.
        observation: what was concluded from it; None if that failed.
        reason: who failed, and how.
    """

    frame: Frame
    refining: bool
    observation: Observation | None
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class AttemptRecord:
    """One reach for a part, traceable to frame, detection, pose, u and threshold.

    Attributes:
        slot: the 20 s slot in which it began.
        decision_index: the decision that caused it.
        frame: index of the frame that it was decided upon.
        detection: index in that frame.
        u: the uncertainty that was decided upon.
        threshold: the bound that u met, if there was one.
        X_BO_est: the pose acted upon: the part in the robot's base as the detection, or the policy, has it.
        grasp: name of the grasp, if one was found.
        container_slot: where the part was to go.
        start: s.
        end: s.
        last_state: how far it came.
        contact: what stopped it, if anything.
        outcome: the referee's verdict.
    """

    slot: int
    decision_index: int
    frame: int
    detection: int
    u: float
    threshold: float | None
    X_BO_est: Pose
    grasp: str | None
    container_slot: int
    start: float
    end: float
    last_state: State
    contact: Contact | None
    outcome: Outcome


@dataclass(frozen=True, slots=True)
class TimeSlot:
    """The 20 seconds (more, if an attempt began in time) that one part has; `outcome` is None for a time-out."""

    index: int
    start: float
    end: float
    outcome: Outcome | None


@dataclass(frozen=True, slots=True)
class Tally:
    """What an experiment came to. Every slot is a TP, an FP or a time-out; FN are the parts left on the belt."""

    parts: int
    tp: int
    fp: int
    fn: int
    void: int
    unreachable: int
    timeouts: int
    duration: float

    @property
    def ap(self) -> float | None:
        """TP / (TP + FP); None without attempts that count."""
        return self.tp / (self.tp + self.fp) if self.tp + self.fp else None

    @property
    def ar(self) -> float | None:
        """TP / (TP + FN); None if nothing was placed and nothing was left."""
        return self.tp / (self.tp + self.fn) if self.tp + self.fn else None
