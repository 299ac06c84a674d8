"""The cycle: search, look, decide, then grasp, refine or search on, until every part has had its 20 seconds."""

from collections.abc import Generator
from dataclasses import dataclass, field
from typing import TypeVar

from cell.arm.conveyor_tracking import BeltSpeed
from cell.arm.limits import PRESETS, SpeedPreset
from cell.attempt import Attempt
from cell.errors import EstimatorError, LayoutError, PolicyError
from cell.grasping import why_unreachable
from cell.guards import TIME_LIMIT, check_decision, guarded_decision
from cell.interfaces import (
    Action,
    Contact,
    Decision,
    Listener,
    Observation,
    Outcome,
    Policy,
    Referee,
    Station,
)
from cell.layout import Layout
from cell.motion import Motion, Unreachable
from cell.perception import Perception
from cell.records import (
    TRANSITIONS,
    AttemptRecord,
    DecisionRecord,
    FailedFrame,
    State,
    Tally,
    TimeSlot,
    Transition,
)
from cell.viewpoints import REFINE_DISTANCE, SearchRun, SecondLook, search_run
from maskval import Pose

T = TypeVar("T")
Deciding = Generator[Observation, Decision, T]  # yields what calls for a decision, is sent it, and returns a T


@dataclass(frozen=True, slots=True)
class CycleConfig:
    """What the cycle may be told.

    Attributes:
        parts: how many parts lie on the belt; each has one slot of time.
        slot_time: s per part; an attempt that began in time is finished and counts.
        settle_time: s that the arm stands still before a picture.
        refine_distance: m from the estimated part at which it is looked at again.
        fresh_look: whether a part on a moving belt is looked at again before it is grasped, which also tells the belt's
            speed.
        time_limit: s of the wall clock that a decision of the policy may take.
        speed: limits of the arm's motions.
    """

    parts: int = 8
    slot_time: float = 20.0
    settle_time: float = 0.05
    refine_distance: float = REFINE_DISTANCE
    fresh_look: bool = True
    time_limit: float = TIME_LIMIT
    speed: SpeedPreset = field(default_factory=lambda: PRESETS["ur-default"])

    def __post_init__(self) -> None:
        for name, least in (("parts", 1), ("settle_time", 0.0)):
            if not getattr(self, name) >= least:
                raise ValueError(f"expected {name} of at least {least}, got {getattr(self, name)}")
        for name, unit in (("slot_time", "s"), ("refine_distance", "m"), ("time_limit", "s")):
            if not getattr(self, name) > 0:
                raise ValueError(f"expected {name} above 0 {unit}, got {getattr(self, name)}")


@dataclass(frozen=True, slots=True)
class _ViewEnd:
    """How a view of the search ended: an attempt's outcome, if there was one, and whether to look at it again."""

    outcome: Outcome | None
    repeat: bool = False


class Cycle:
    """Runs one experiment on a station. Everything that happens is told to the listener as a record."""

    def __init__(
        self,
        *,
        station: Station,
        referee: Referee,
        perception: Perception,
        layout: Layout,
        config: CycleConfig,
        listener: Listener,
        policy: Policy | None = None,
    ) -> None:
        """Without a policy, `decisions` is the way to run it.

        Raises:
            LayoutError: the layout has no slot for every part, or a search view is out of reach.
        """
        self._station, self._referee = station, referee
        self._perception, self._policy = perception, policy
        self._config, self._tell = config, listener
        tracked = BeltSpeed(layout.belt.speed) if config.fresh_look and layout.belt.speed else None
        self._motion = Motion(station, layout, config.speed, tracked)
        self._search = self._reachable_search(layout)
        center_O = perception.part.mesh.center
        self._second_look = SecondLook(self._motion, center_O, config.refine_distance, config.settle_time)
        self._state = State.SEARCH
        self._slot = self._view = self._decisions = self._container_slot = 0
        self._looked_in_vain = False  # whether a second look led to no grasp in this time slot

    def _reachable_search(self, layout: Layout) -> SearchRun:
        slots = layout.container.rows * layout.container.columns
        if self._config.parts > slots:
            raise LayoutError(
                f"expected at most {slots} parts, one per slot of the container, got {self._config.parts}"
            )
        search = search_run(layout)
        for index, X_BC in enumerate(search.views):
            try:
                self._motion.joints_for_camera(X_BC)
            except Unreachable as reason:
                raise LayoutError(f"view {index} of the search run is out of reach: {reason}") from reason
        return search

    def run(self) -> Tally:
        """The whole experiment, decided by the policy."""
        if self._policy is None:
            raise ValueError("expected a cycle with a policy to run, got one without: drive `decisions` instead")
        decisions = self.decisions()
        try:
            observation = next(decisions)
            while True:
                try:
                    decision = guarded_decision(self._policy, observation, self._config.time_limit)
                except PolicyError as error:
                    decisions.throw(error)  # so that the frame is told of
                    raise
                observation = decisions.send(decision)
        except StopIteration as end:
            count: Tally = end.value
            return count

    def decisions(self) -> Deciding[Tally]:
        """The whole experiment: one slot of time per part, decided from outside.

        Yields each observation that calls for a decision, does what it is sent, and at the end returns the count.

        Raises:
            PolicyError: what was sent is not a decision, or names a detection that does not exist.
        """
        outcomes: list[Outcome] = []
        timeouts = 0
        for slot in range(self._config.parts):
            self._slot, self._looked_in_vain = slot, False
            start = self._station.time
            ended_by = yield from self._run_slot(start + self._config.slot_time, outcomes)
            timeouts += ended_by is None
            self._tell(TimeSlot(self._slot, start, self._station.time, ended_by))
        self._enter(State.DONE, "every part had its time")
        return Tally(
            parts=self._config.parts,
            tp=sum(outcome.is_true_positive for outcome in outcomes),
            fp=sum(outcome.is_false_positive for outcome in outcomes),
            fn=self._referee.parts_on_belt(),
            void=outcomes.count(Outcome.VOID),
            unreachable=outcomes.count(Outcome.UNREACHABLE),
            timeouts=timeouts,
            duration=self._station.time,
        )

    def _run_slot(self, deadline: float, outcomes: list[Outcome]) -> Deciding[Outcome | None]:
        """Until a part is placed, an attempt fails or the time is up; appends every outcome on the way."""
        while self._station.time < deadline:
            end = yield from self._run_view(deadline)
            self._view += not end.repeat
            if end.outcome is None:
                continue
            outcomes.append(end.outcome)
            if end.outcome.is_true_positive or end.outcome.is_false_positive:
                return end.outcome
        return None

    def _run_view(self, deadline: float) -> Deciding[_ViewEnd]:
        """One view of the search run, its second looks and the attempt that may follow."""
        self._enter(State.SEARCH, f"view {self._view}")
        contact = self._move_camera(self._search.view(self._view))
        before: DecisionRecord | None = None  # at the same part
        while contact is None:
            seen = yield from self._look(before is not None, deadline)
            action = seen.decision.action
            in_time = self._station.time < deadline
            if action is Action.SEARCH or not in_time:
                self._looked_in_vain |= before is not None
                return _ViewEnd(None, repeat=action is Action.GRASP)  # there is something for the next part's time
            if action is Action.GRASP and not self._wants_fresh_look(before):
                if before is not None and self._second_look.tells_speed(before, seen):
                    self._enter(State.DECIDE, f"two looks say that the belt runs at {self._motion.belt_speed:.4f} m/s")
                return self._attempt(seen)
            try:
                contact = self._look_again(seen)
            except Unreachable as reason:
                if action is Action.GRASP:
                    self._enter(State.DECIDE, f"no fresh look: {reason}")
                    return self._attempt(seen)
                self._enter(State.SEARCH, str(reason))
                return _ViewEnd(None)
            before = seen
        return _ViewEnd(self._referee.verdict(contact))

    def _move_camera(self, X_BC: Pose) -> Contact | None:
        """Moves the camera; after a contact back to where the move began, with nothing watched on that way."""
        q_before = self._station.q
        contact = self._motion.to_camera(X_BC)
        if contact is not None:
            self._enter(State.RETREAT, f"{contact.force:.0f} N against {contact.touch}")
            self._motion.to_joints(q_before, watch=frozenset())
        return contact

    def _look(self, refining: bool, deadline: float) -> Deciding[DecisionRecord]:
        self._enter(State.LOOK, "camera in place")
        self._station.wait(self._config.settle_time, frozenset())
        frame, observation = self._perception.take_frame(self._station), None
        try:
            observation = self._perception.observe(frame, refining, deadline - self._station.time)
            self._enter(State.DECIDE, f"{len(observation.detections)} detections")
            decision = yield observation
            check_decision(decision, observation, self._policy)
        except (EstimatorError, PolicyError) as error:
            self._tell(FailedFrame(frame, refining, observation, str(error)))
            raise
        seen = DecisionRecord(self._slot, self._decisions, observation, decision)
        self._decisions += 1
        self._tell(seen)
        return seen

    def _wants_fresh_look(self, before: DecisionRecord | None) -> bool:
        """Whether a part is to be looked at again before it is grasped; not twice in vain: the error is the view's."""
        return before is None and self._motion.belt is not None and not self._looked_in_vain

    def _look_again(self, seen: DecisionRecord) -> Contact | None:
        """Moves the camera to a second look; raises Unreachable if there is no way."""
        fresh = "fresh look at " if seen.decision.action is Action.GRASP else ""
        self._enter(State.REFINE, f"{fresh}detection {seen.detection}")
        return self._move_camera(self._second_look.view(seen))

    def _attempt(self, seen: DecisionRecord) -> _ViewEnd:
        observation, index, start = seen.observation, seen.detection, self._station.time
        self._referee.attempt_begins(self._container_slot)
        reach = Attempt(self._motion, self._perception.part, self._enter).run(
            seen.X_BO_est, self._container_slot, observation.frame.time
        )
        outcome = Outcome.UNREACHABLE if reach.grasp is None else self._referee.verdict(reach.contact)
        if reach.grasp is None:
            self._enter(State.DECIDE, f"unreachable: {why_unreachable(self._perception.part, seen.X_BO_est)}")
        self._tell(
            AttemptRecord(
                slot=self._slot,
                decision_index=seen.decision_index,
                frame=observation.frame.index,
                detection=index,
                u=observation.u(seen.decision, index),
                threshold=seen.decision.threshold,
                X_BO_est=seen.X_BO_est,
                grasp=reach.grasp,
                container_slot=self._container_slot,
                start=start,
                end=self._station.time,
                last_state=reach.last_state,
                contact=reach.contact,
                outcome=outcome,
            )
        )
        if reach.last_state in (State.INSERT, State.RELEASE, State.RETREAT):
            self._container_slot += 1  # something was put there, well or badly
        return _ViewEnd(outcome, repeat=outcome is Outcome.PLACED)  # the rest of the view is worth another look

    def _enter(self, state: State, reason: str) -> None:
        if state not in TRANSITIONS[self._state]:
            raise RuntimeError(
                f"expected one of {', '.join(TRANSITIONS[self._state])} after {self._state}, got {state}"
            )
        self._tell(Transition(self._station.time, self._state, state, reason))
        self._state = state
