"""The cycle: search, look, decide, then grasp, refine or search on, until every part has had its 20 seconds."""

from collections.abc import Generator
from dataclasses import dataclass, field
from typing import TypeVar

from cell.attempt import Attempt
from cell.errors import LayoutError, PolicyError
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
from cell.records import AttemptRecord, Count, Seen, Slot, State, Transition
from cell.search import SearchRun, refinement_view, search_run
from cell.speed import PRESETS, SpeedPreset
from maskval import Pose

T = TypeVar("T")
Deciding = Generator[Observation, Decision, T]  # yields what calls for a decision, is sent it, and returns a T


@dataclass(frozen=True, slots=True)
class CycleConfig:
    """What the cycle may be told.

    Attributes:
        parts: how many parts lie on the belt; each has one slot of time.
        slot_time: s per part; an attempt that began in time is finished and counts.
        refinements: second looks per search view; more of them look at the same picture again.
        settle_time: s that the arm stands still before a picture.
        speed: limits of the arm's motions.
    """

    parts: int = 8
    slot_time: float = 20.0
    refinements: int = 1
    settle_time: float = 0.05
    speed: SpeedPreset = field(default_factory=lambda: PRESETS["ur-default"])

    def __post_init__(self) -> None:
        for name, least in (("parts", 1), ("refinements", 0), ("settle_time", 0.0)):
            if not getattr(self, name) >= least:
                raise ValueError(f"expected {name} of at least {least}, got {getattr(self, name)}")
        if not self.slot_time > 0:
            raise ValueError(f"expected slot_time above 0 s, got {self.slot_time}")


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
        self._motion = Motion(station, layout, config.speed)
        self._search = self._reachable_search(layout)
        self._state = State.SEARCH
        self._slot = self._view = self._decisions = self._container_slot = 0

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

    def run(self) -> Count:
        """The whole experiment, decided by the policy."""
        if self._policy is None:
            raise ValueError("expected a cycle with a policy to run, got one without: drive `decisions` instead")
        decisions = self.decisions()
        try:
            observation = next(decisions)
            while True:
                observation = decisions.send(_asked(self._policy, observation))
        except StopIteration as end:
            count: Count = end.value
            return count

    def decisions(self) -> Deciding[Count]:
        """The whole experiment: one slot of time per part, decided from outside.

        Yields each observation that calls for a decision, does what it is sent, and at the end returns the count.

        Raises:
            PolicyError: what was sent is no decision, or about a detection that does not exist.
        """
        outcomes: list[Outcome] = []
        timeouts = 0
        for slot in range(self._config.parts):
            self._slot = slot
            start = self._station.time
            ended_by = yield from self._run_slot(start + self._config.slot_time, outcomes)
            timeouts += ended_by is None
            self._tell(Slot(self._slot, start, self._station.time, ended_by))
        self._enter(State.DONE, "every part had its time")
        return Count(
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
            outcome = yield from self._run_view(deadline)
            if outcome is None:
                self._view += 1
                continue
            outcomes.append(outcome)
            if outcome is not Outcome.PLACED:  # the rest of a view that gave a part is worth another look
                self._view += 1
            if outcome.is_true_positive or outcome.is_false_positive:
                return outcome
        return None

    def _run_view(self, deadline: float) -> Deciding[Outcome | None]:
        """One view of the search run, its second looks and the attempt that may follow; None without one."""
        self._enter(State.SEARCH, f"view {self._view}")
        contact = self._move_camera(self._search.view(self._view))
        for look in range(self._config.refinements + 1):
            if contact is not None:
                return self._referee.verdict(contact)
            seen = yield from self._look(refining=look > 0)
            action = seen.decision.action
            in_time = self._station.time < deadline
            if action is Action.GRASP and in_time:
                return self._attempt(seen)
            if action is Action.GRASP:
                self._view -= 1  # the next part's time begins with this view: there is something to grasp
            if action is not Action.REFINE or look == self._config.refinements or not in_time:
                return None
            X_BC = self._refinement_view(seen)
            self._enter(State.REFINE, f"detection {seen.decision.detection}")
            try:
                contact = self._move_camera(X_BC)
            except Unreachable as reason:
                self._enter(State.SEARCH, str(reason))
                return None
        return None

    def _move_camera(self, X_BC: Pose) -> Contact | None:
        """Moves the camera; after a contact back to where the move began, with nothing watched on that way."""
        q_before = self._station.q
        contact = self._motion.to_camera(X_BC)
        if contact is not None:
            self._enter(State.RETREAT, f"{contact.force:.0f} N against {contact.touch}")
            self._motion.to_joints(q_before, watch=frozenset())
        return contact

    def _look(self, refining: bool) -> Deciding[Seen]:
        self._enter(State.LOOK, "camera in place")
        self._station.wait(self._config.settle_time, frozenset())
        observation = self._perception.look(self._station, refining)
        self._enter(State.DECIDE, f"{len(observation.detections)} detections")
        decision = yield observation
        _check(decision, observation, self._policy)
        seen = Seen(self._slot, self._decisions, observation, decision)
        self._decisions += 1
        self._tell(seen)
        return seen

    def _refinement_view(self, seen: Seen) -> Pose:
        frame = seen.observation.frame
        X_CO_est = seen.observation.poses[0][_detection(seen.decision)]
        return refinement_view(frame.X_BC, X_CO_est, self._perception.part.mesh.bounds.mean(axis=0))

    def _attempt(self, seen: Seen) -> Outcome:
        observation, index = seen.observation, _detection(seen.decision)
        X_BO_est = observation.frame.X_BC @ observation.poses[0][index]
        start = self._station.time
        self._referee.attempt_begins(self._container_slot)
        reach = Attempt(self._motion, self._perception.part, self._enter).run(X_BO_est, self._container_slot)
        outcome = Outcome.UNREACHABLE if reach.grasp is None else self._referee.verdict(reach.contact)
        self._tell(
            AttemptRecord(
                slot=self._slot,
                decision_index=seen.decision_index,
                frame=observation.frame.index,
                detection=index,
                u=float(observation.uncertainties[index]),
                threshold=seen.decision.threshold,
                X_BO_est=X_BO_est,
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
        return outcome

    def _enter(self, state: State, reason: str) -> None:
        self._tell(Transition(self._station.time, self._state, state, reason))
        self._state = state


def _asked(policy: Policy, observation: Observation) -> Decision:
    """The policy's decision.

    Raises:
        PolicyError: the policy raised.
    """
    try:
        return policy.decide(observation)
    except Exception as error:
        raise PolicyError(f"{_who(policy, observation)}: raised {type(error).__name__}: {error}") from error


def _check(decision: object, observation: Observation, policy: Policy | None) -> None:
    """Raises PolicyError unless it is a decision, and about a detection that exists."""
    who = _who(policy, observation)
    if not isinstance(decision, Decision):
        raise PolicyError(f"{who}: expected a cell.interfaces.Decision, got {type(decision).__name__}")
    count = len(observation.detections)
    if decision.action is not Action.SEARCH and decision.detection not in range(count):
        raise PolicyError(
            f"{who}: expected a detection in 0..{count - 1} to {decision.action}, got {decision.detection}"
        )


def _who(policy: Policy | None, observation: Observation) -> str:
    name = "the decision" if policy is None else type(policy).__name__
    return f"{name} on frame {observation.frame.index}"


def _detection(decision: Decision) -> int:
    assert decision.detection is not None  # `_check` has seen to it
    return decision.detection
