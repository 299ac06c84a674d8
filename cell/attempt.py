"""One attempt: approach, close, lift, transfer, insert, release, and the way out when something touches."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NoReturn

import numpy as np

from cell.arm.conveyor_tracking import RAMP_TIME, TRACKING_TIME
from cell.grasping import RELEASE_GAP, GraspPlan, PlacePlan, plan_grasps, plan_places
from cell.interfaces import Contact, Touch
from cell.motion import EVERYTHING, HOLDING, Array, Motion, Unreachable
from cell.part import Part
from cell.records import State
from cell.rounding import first_least
from maskval import Pose

GRIP = -0.02  # m, commanded half opening: beyond closed, so that the jaws press with all the force that they may use
CLOSING_TIME = 0.40  # s
RELEASE_TIME = 0.25  # s
CLOSED_ON_NOTHING = 0.001  # m half opening below which nothing is between the pads

Enter = Callable[[State, str], None]


@dataclass(frozen=True, slots=True)
class Reach:
    """How an attempt went, as far as the robot can tell; the referee says what it came to.

    Attributes:
        grasp: name of the grasp, None if the arm reaches none: then nothing has moved.
        last_state: where it ended.
        contact: what stopped it, if anything.
    """

    grasp: str | None
    last_state: State
    contact: Contact | None


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """One step of an attempt.

    Attributes:
        state: the state that it is in.
        reason: why it is entered.
        move: what it does; returns the contact that stopped it.
        retreat: the tool pose X_BT to go back to when it fails; None for the joints before the step.
        jaws: half opening that is commanded before, m; None leaves the jaws as they are.
        holds: whether the jaws must hold something at its end.
    """

    state: State
    reason: str
    move: Callable[[], Contact | None]
    retreat: Pose | None = None
    jaws: float | None = None
    holds: bool = False


class _Ended(Exception):  # noqa: N818  # unwinds the sequence from wherever it was
    def __init__(self, contact: Contact | None) -> None:
        super().__init__(contact)
        self.contact = contact


class Attempt:
    """Grasps one part and puts it into one slot of the container. One object, one attempt."""

    def __init__(self, motion: Motion, part: Part, enter: Enter) -> None:
        self._motion, self._part, self._enter = motion, part, enter
        self._station = motion.station
        self._state = State.APPROACH
        self._tracking = False  # whether the tool moves with the belt, if the belt moves
        self._seen_at = 0.0

    def run(self, X_BO_est: Pose, container_slot: int, seen_at: float) -> Reach:
        """Tries it; ends with the arm out of the way.

        Args:
            X_BO_est: where the part was seen.
            container_slot: where the part is to go.
            seen_at: when it was there, s; where the belt moves, it has carried the part on since.
        """
        self._seen_at = seen_at
        chosen = self._reachable_plan(X_BO_est)
        if chosen is None:
            return Reach(None, State.APPROACH, None)
        plan, start = chosen
        try:
            for step in self._pick(plan, start):
                self._take(step)
            for step in self._place(plan, container_slot):
                self._take(step)
        except _Ended as end:
            return Reach(plan.grasp.name, self._state, end.contact)
        return Reach(plan.grasp.name, self._state, None)

    def _reachable_plan(self, X_BO_est: Pose) -> tuple[GraspPlan, float] | None:
        """The most upright grasp that the arm reaches, and when to be above it, s.

        The way round that turns the joints least; on a moving belt, the one that is there first; of equals the first.
        """
        plans = plan_grasps(self._part, X_BO_est)
        for grasp in dict.fromkeys(plan.grasp.name for plan in plans):
            ways = [
                (cost, plan) for plan in plans if plan.grasp.name == grasp and (cost := self._cost(plan)) is not None
            ]
            if ways:
                cost, plan = first_least(ways, key=lambda way: way[0])
                return plan, cost if self._motion.belt_moves else self._station.time
        return None

    def _cost(self, plan: GraspPlan) -> float | None:
        """What makes a way round the worse one: the joints' turn, or the time of meeting; None if out of reach."""
        if not self._motion.belt_moves:
            return self._turn(plan.X_BT_before, plan.X_BT_grip, plan.X_BT_lifted)
        return self._motion.meeting_time(lambda start: self._joints_to_begin(plan, start))

    def _joints_to_begin(self, plan: GraspPlan, start: float) -> Array:
        """Joint angles where tracking the belt starts, at a time (s); raises Unreachable beyond the arm's reach."""
        carried, seen_at, layout = self._motion.carried, self._seen_at, self._motion.layout
        y_W = (layout.X_WB @ carried(plan.X_BT_before, seen_at, start)).translation[1]
        if y_W > layout.belt.loading_length / 2:
            raise Unreachable("not yet on the stretch that the arm reaches")
        for X_BT in (plan.X_BT_grip, plan.X_BT_lifted):
            self._motion.joints_for(carried(X_BT, seen_at, start + TRACKING_TIME))
        return self._motion.joints_for(carried(plan.X_BT_before, seen_at, start + RAMP_TIME / 2))

    def _reachable_place(self, plan: GraspPlan, container_slot: int, half_opening: float) -> PlacePlan | None:
        """The way to lay the part down that turns the joints least."""
        places = plan_places(self._part, self._motion.layout, plan, container_slot, half_opening)
        ways = [
            (turn, place) for place in places if (turn := self._turn(place.X_BT_above, place.X_BT_release)) is not None
        ]
        return first_least(ways, key=lambda way: way[0])[1] if ways else None

    def _turn(self, first: Pose, *others: Pose) -> float | None:
        """How far the joints turn to the first tool pose, rad; None if one of the poses is out of reach."""
        try:
            joints = self._motion.joints_for(first)
            for X_BT in others:
                self._motion.joints_for(X_BT)
        except Unreachable:
            return None
        return float(np.abs(joints - self._station.q).max())

    def _pick(self, plan: GraspPlan, start: float) -> tuple[_Step, ...]:
        """From where the arm is to the part lifted in the jaws; the tool is above the part at a time, `start`, s."""
        motion, before = self._motion, plan.X_BT_before
        approach, close = partial(self._approach, before, start), partial(motion.wait_on_belt, CLOSING_TIME, HOLDING)
        descend, lift = partial(self._track_to, plan.X_BT_grip, EVERYTHING), partial(self._lift, plan.X_BT_lifted)
        return (
            _Step(State.APPROACH, f"grasp {plan.grasp.name}", approach, jaws=plan.grasp.half_opening),
            _Step(State.DESCEND, "above the part", descend, before),
            _Step(State.CLOSE, "at the part", close, before, jaws=GRIP, holds=True),
            _Step(State.LIFT, "part between the jaws", lift, before, holds=True),
        )

    def _approach(self, X_BT_before: Pose, start: float) -> Contact | None:
        """Above the part at a time (s), moving as it does from then on."""
        where = self._motion.carried(X_BT_before, self._seen_at, start + RAMP_TIME / 2)
        contact = self._motion.to_tool(where) or self._motion.join_belt(start)
        self._tracking = contact is None
        return contact

    def _track_to(self, X_BT: Pose, watch: frozenset[Touch]) -> Contact | None:
        return self._motion.line_to(self._motion.carried(X_BT, self._seen_at), watch, tracking=True)

    def _lift(self, X_BT_lifted: Pose) -> Contact | None:
        contact = self._track_to(X_BT_lifted, HOLDING) or self._motion.leave_belt(HOLDING)
        self._tracking = contact is not None
        return contact

    def _place(self, plan: GraspPlan, container_slot: int) -> tuple[_Step, ...]:
        """From the lifted part to the part in its slot and the tool above it."""
        half_opening = self._station.jaw_half_opening + RELEASE_GAP
        place = self._reachable_place(plan, container_slot, half_opening)
        if place is None:
            self._end(f"slot {container_slot} is out of reach in this orientation", None, None)
        motion, above = self._motion, place.X_BT_above
        insert = partial(motion.line_to, place.X_BT_release, HOLDING | {Touch.PRESSED})
        release = partial(self._station.wait, RELEASE_TIME, HOLDING)
        return (
            _Step(State.TRANSFER, "part lifted", partial(motion.to_tool, above, HOLDING), holds=True),
            _Step(State.INSERT, f"above slot {container_slot}", insert, above),
            _Step(State.RELEASE, "in the slot", release, above, jaws=half_opening),
            _Step(State.RETREAT, "released", partial(motion.line_to, above, HOLDING), above),
        )

    def _take(self, step: _Step) -> None:
        """Takes a step; where it fails, retreats and ends the attempt."""
        if step.jaws is not None:
            self._station.command_jaws(step.jaws)
        self._to(step.state, step.reason)
        q_before = self._station.q
        try:
            contact = step.move()
        except Unreachable as unreachable:
            self._end(str(unreachable), None, step.retreat)
        if contact is not None:
            self._stop(contact, step.retreat, q_before)
        if step.holds and self._station.jaw_half_opening < CLOSED_ON_NOTHING:
            self._end("nothing between the jaws", None, step.retreat if self._tracking else None)

    def _stop(self, contact: Contact, retreat: Pose | None, q_before: Array) -> NoReturn:
        """Ends the attempt after a contact."""
        reason = f"{contact.force:.0f} N against {contact.touch}"
        if retreat is None:
            self._enter(State.RETREAT, reason)
            self._motion.to_joints(q_before, watch=frozenset())
            self._end("back where the move began", contact, None)
        self._end(reason, contact, retreat)

    def _end(self, reason: str, contact: Contact | None, retreat: Pose | None) -> NoReturn:
        """Opens the jaws, goes straight back to `retreat` and ends the attempt; nothing is watched on the way out."""
        self._enter(State.RETREAT, reason)
        if self._tracking and contact is None:
            self._motion.leave_belt(watch=frozenset())
        if self._state is not State.DESCEND:
            self._station.command_jaws(self._motion.layout.gripper.max_half_opening)
            self._station.wait(RELEASE_TIME, frozenset())
        if retreat is not None:
            if self._tracking:
                retreat = self._motion.carried(retreat, self._seen_at)
            try:
                self._motion.line_to(retreat, watch=frozenset())
            except Unreachable:
                self._motion.to_tool(retreat, watch=frozenset())
        raise _Ended(contact)

    def _to(self, state: State, reason: str) -> None:
        self._state = state
        self._enter(state, reason)
