"""A cell without physics for the tests: everything that the controller meets follows a script.

What the real things guarantee or demand, the fakes check or do too: a trajectory begins where the arm is, a contact
lasts until the arm has moved away without watching, jaws move only as time goes on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cell.cycle import Cycle, CycleConfig
from cell.interfaces import Contact, Detection, Frame, Image, Listener, Observation, Outcome, Policy, Touch
from cell.layout import Belt, Layout
from cell.part import Grasp, Part
from cell.perception import Perception
from cell.records import AttemptRecord, DecisionRecord, State, Tally, TimeSlot, Transition
from cell.setup import PolicySetup
from cell.trajectory import JointTrajectory
from cell.ur10 import forward
from maskval import Camera, Estimates, Mesh, Needs, Pose

T = TypeVar("T")
PoseScript = Sequence[Pose | Sequence[Pose]]

HOME = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
CONTACT_FORCE = 45.0  # N of every scripted contact
HALF_WIDTH = 0.02  # m, between the jaws when they hold the brick
# Powers of two, so that sums of times are exact: a look from the next view takes 1 + 0.25 + 0.5 + 0.25 = 2 s.
MOVE_TIME, SETTLE_TIME, MASK_TIME, POSE_TIME = 1.0, 0.25, 0.5, 0.25
LOOK_TIME = MOVE_TIME + SETTLE_TIME + MASK_TIME + POSE_TIME
ATTEMPT = (  # the states of one that succeeds
    State.APPROACH,
    State.DESCEND,
    State.CLOSE,
    State.LIFT,
    State.TRANSFER,
    State.INSERT,
    State.RELEASE,
    State.RETREAT,
)


def scripted(script: Sequence[T], call: int) -> T:
    """The call-th entry of a script; its last one holds on."""
    return script[min(call, len(script) - 1)]


@dataclass(frozen=True)
class Motion:
    """What a station was told to do: follow a trajectory or wait; `q` is where the arm stood afterwards."""

    state: State
    watch: frozenset[Touch]
    q: NDArray[np.float64]
    contact: Contact | None


class FakeStation:
    """Implements `cell.interfaces.Station`: the arm is at once where a trajectory ends, and only the clock runs.

    Args:
        layout: for the camera, its pose on the flange and the jaws.
        move_time: what every trajectory takes, s; None for its own duration.
        touches: the state in which something is touched, and what; each happens once, if it is watched.
        part_half_width: where the jaws stop when they grip, m.
        loses_part_in: the state at whose end the part is no longer between the jaws.
    """

    time_step = 0.02

    def __init__(
        self,
        layout: Layout,
        *,
        move_time: float | None = None,
        touches: dict[State, Touch] | None = None,
        part_half_width: float = HALF_WIDTH,
        loses_part_in: State | None = None,
    ) -> None:
        self._layout, self._move_time = layout, move_time
        self.touches = dict(touches or {})
        self.part_half_width, self.loses_part_in = part_half_width, loses_part_in
        self.state = State.SEARCH  # told by who listens to the controller
        self.time = 0.0
        self.jaw_half_opening = layout.gripper.max_half_opening
        self.motions: list[Motion] = []
        self.jaw_commands: list[tuple[State, float]] = []
        self.images: list[frozenset[Image]] = []
        self._q = HOME.copy()
        self._touching: Touch | None = None

    @property
    def q(self) -> NDArray[np.float64]:
        return self._q.copy()

    @property
    def X_BT(self) -> Pose:
        return forward(self._q) @ self._layout.gripper.X_FT

    def take_frame(self, images: frozenset[Image]) -> Frame:
        self.images.append(images)
        return Frame(len(self.images) - 1, self.time, self._layout.camera, forward(self._q) @ self._layout.X_FC)

    def follow(self, trajectory: JointTrajectory, watch: frozenset[Touch]) -> Contact | None:
        steps = len(trajectory.positions) - 1
        moving = trajectory.velocities[0].any()  # on a belt: the first sample is reached one time step from now
        here = self._q + self.time_step * trajectory.velocities[0]
        tolerance = 5e-4 if moving else 1e-6
        np.testing.assert_allclose(trajectory.positions[0], here, atol=tolerance, err_msg="the arm is elsewhere")
        duration = trajectory.duration_s if self._move_time is None or steps == 0 else self._move_time
        if moving:
            duration = trajectory.duration_s + self.time_step
        touch = self._touched(watch)
        self._q = trajectory.positions[-1 if touch is None else steps // 2].copy()
        if steps > 0 and not watch:
            self._touching = None
        return self._pass(duration, watch, touch)

    def wait(self, duration: float, watch: frozenset[Touch]) -> Contact | None:
        return self._pass(duration, watch, self._touched(watch))

    def command_jaws(self, half_opening: float) -> None:
        self.jaw_commands.append((self.state, half_opening))

    def _touched(self, watch: frozenset[Touch]) -> Touch | None:
        if self._touching in watch:
            return self._touching
        if self.touches.get(self.state) in watch:
            self._touching = self.touches.pop(self.state)
            return self._touching
        return None

    def _pass(self, duration: float, watch: frozenset[Touch], touch: Touch | None) -> Contact | None:
        self.time += duration if touch is None else duration / 2
        if self.state is self.loses_part_in:
            self.part_half_width = 0.0
        if self.jaw_commands:
            command = self.jaw_commands[-1][1]
            self.jaw_half_opening = self.part_half_width if command < 0.0 else command
        contact = None if touch is None else Contact(touch, CONTACT_FORCE, self.time)
        self.motions.append(Motion(self.state, watch, self.q, contact))
        return contact


@dataclass(frozen=True)
class Try:
    """How an attempt shall go: what the referee says of it, or where it is stopped, and where the jaws stop."""

    outcome: Outcome = Outcome.PLACED
    touches: tuple[State, Touch] | None = None
    part_half_width: float = HALF_WIDTH


VOID = Try(Outcome.VOID, part_half_width=0.0)
COLLISIONS = {
    Touch.BELT: Outcome.COLLISION_BELT,
    Touch.CONTAINER: Outcome.COLLISION_CONTAINER,
    Touch.PART: Outcome.COLLISION_PART,
    Touch.PRESSED: Outcome.COLLISION_CONTAINER,
    Touch.ROBOT: Outcome.COLLISION_ROBOT,
}


class FakeReferee:
    """Implements `cell.interfaces.Referee`: sets the scene for the n-th attempt and says what its script says."""

    def __init__(self, station: FakeStation, tries: Sequence[Try] = (Try(),), left_on_belt: int = 0) -> None:
        self._station, self._tries, self._left_on_belt = station, tries, left_on_belt
        self.container_slots: list[int] = []
        self.verdicts: list[Contact | None] = []

    def attempt_begins(self, container_slot: int) -> None:
        now = scripted(self._tries, len(self.container_slots))
        self.container_slots.append(container_slot)
        self._station.part_half_width = now.part_half_width
        if now.touches is not None:
            self._station.touches[now.touches[0]] = now.touches[1]

    def verdict(self, stopped_by: Contact | None) -> Outcome:
        self.verdicts.append(stopped_by)
        if stopped_by is not None:
            return COLLISIONS[stopped_by.touch]
        return scripted(self._tries, len(self.container_slots) - 1).outcome

    def parts_on_belt(self) -> int:
        return self._left_on_belt


class FakeMasks:
    """Implements `cell.interfaces.MaskEstimator`: the scores of each frame's detections; mask i is pixel (i, i)."""

    def __init__(
        self,
        scores: Sequence[Sequence[float]] = ((0.9,),),
        inference_time: float = MASK_TIME,
        images: frozenset[Image] = frozenset(),
    ) -> None:
        self._scores, self.inference_time, self.images = scores, inference_time, images
        self._calls = 0

    def detect(self, frame: Frame) -> Sequence[Detection]:
        scores = scripted(self._scores, self._calls)
        self._calls += 1
        detections = []
        for index, score in enumerate(scores):
            mask = np.zeros((frame.camera.height, frame.camera.width), dtype=bool)
            mask[index, index] = True
            detections.append(Detection(mask, score))
        return detections


class FakePoses:
    """Implements `cell.interfaces.PoseEstimator`: in the n-th frame each detection is a part at the n-th X_BO.

    Where the n-th is a sequence of poses, there is one for each detection.
    """

    def __init__(
        self, X_BO: PoseScript, inference_time: float = POSE_TIME, images: frozenset[Image] = frozenset()
    ) -> None:
        self._X_BO, self.inference_time, self.images = X_BO, inference_time, images
        self.given: list[Sequence[Detection]] = []

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> Sequence[Pose]:
        X_BO = scripted(self._X_BO, len(self.given))
        self.given.append(detections)
        X_BO_each = [X_BO] * len(detections) if isinstance(X_BO, Pose) else X_BO
        return [frame.X_BC.inverse() @ X_BO_est for X_BO_est in X_BO_each]


class FakeMethod:
    """Implements `maskval.UncertaintyMethod`: in the n-th frame the detections have the n-th u, one for all or each."""

    def __init__(self, u: Sequence[float | Sequence[float]] = (0.0,), estimators: int = 1) -> None:
        self._u, self.needs = u, Needs(estimators)
        self.given: list[Estimates] = []

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        u = np.full(len(estimates), scripted(self._u, len(self.given)), dtype=np.float64)
        self.given.append(estimates)
        return u


def small_layout(belt_speed: float = 0.0) -> Layout:
    """The cell with 20 times fewer pixels per side, and the same field of view."""
    camera = Camera(fx=30.0, fy=30.0, cx=16.0, cy=12.0, width=32, height=24)
    return Layout(belt=Belt(speed=belt_speed), camera=camera)


def box_mesh(low: Sequence[float], high: Sequence[float]) -> Mesh:
    """A closed box between two corners in frame O, m."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Mesh(corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]))


def grasp(name: str, p_OT: Sequence[float], approach: Sequence[float], closing: Sequence[float]) -> Grasp:
    """A grasp at a point, from a direction, closing along another, all in frame O."""
    z, y = np.array(approach, dtype=np.float64), np.array(closing, dtype=np.float64)
    return Grasp(name, Pose(np.column_stack([np.cross(y, z), y, z]), np.array(p_OT)), half_opening=0.045)


def brick() -> Part:
    """A box of 120 × 50 × 40 mm, O in none of its middles, with one grasp for each of the four sides it can lie on."""
    middle = (0.01, 0.005, 0.02)
    return Part(
        name="brick",
        mesh=box_mesh((-0.05, -0.02, 0.0), (0.07, 0.03, 0.04)),
        grasps=(
            grasp("from above", middle, (0, 0, -1), (0, 1, 0)),
            grasp("from below", middle, (0, 0, 1), (0, 1, 0)),
            grasp("from left", middle, (0, -1, 0), (0, 0, 1)),
            grasp("from right", middle, (0, 1, 0), (0, 0, 1)),
        ),
        slot_size=(0.20, 0.13),
    )


def turned(roll_deg: float = 0.0, pitch_deg: float = 0.0, yaw_deg: float = 0.0) -> Pose:
    """Rotated about the fixed x, then y, then z axis."""
    angles = np.radians([roll_deg, pitch_deg, yaw_deg])
    roll, pitch, yaw = (Pose.from_rotvec(axis * angle) for axis, angle in zip(np.eye(3), angles, strict=True))
    return yaw @ pitch @ roll


def on_belt(part: Part, layout: Layout, rotation: Pose, x_W: float = 0.68, y_W: float = 0.0) -> Pose:
    """X_BO of a part of this rotation in the world, its middle over a point, its lowest vertex on the belt."""
    vertices_W = rotation.apply(part.mesh.vertices)
    low, high = vertices_W.min(axis=0), vertices_W.max(axis=0)
    middle = (low + high) / 2
    p_WO = np.array([x_W - middle[0], y_W - middle[1], layout.belt.top_z - low[2]])
    return layout.X_WB.inverse() @ Pose(rotation.rotation, p_WO)


class Records:
    """A listener that keeps every record and lets the station know in which state the controller is."""

    def __init__(self, station: FakeStation) -> None:
        self._station = station
        self.all: list[object] = []

    def __call__(self, record: object) -> None:
        if isinstance(record, Transition):
            self._station.state = record.target
        self.all.append(record)

    def of(self, kind: type[T]) -> list[T]:
        return [record for record in self.all if isinstance(record, kind)]


@dataclass(frozen=True)
class Experiment:
    """A cycle that has run, with everything that took part in it."""

    count: Tally
    records: Records
    station: FakeStation
    referee: FakeReferee

    @property
    def transitions(self) -> list[Transition]:
        return self.records.of(Transition)

    @property
    def seen(self) -> list[DecisionRecord]:
        return self.records.of(DecisionRecord)

    @property
    def attempts(self) -> list[AttemptRecord]:
        return self.records.of(AttemptRecord)

    @property
    def slots(self) -> list[TimeSlot]:
        return self.records.of(TimeSlot)


def run_cycle(
    policy: Policy,
    *,
    config: CycleConfig | None = None,
    masks: Callable[[FakeStation], FakeMasks] | Sequence[Sequence[float]] = ((0.9,),),
    X_BO: PoseScript | None = None,
    X_BO_second: PoseScript | None = None,
    u: Sequence[float | Sequence[float]] = (0.0,),
    tries: Sequence[Try] = (Try(),),
    touches: dict[State, Touch] | None = None,
    left_on_belt: int = 0,
    listener: Listener | None = None,
    belt_speed: float = 0.0,
) -> Experiment:
    """Runs a cycle on the fakes; unless scripted otherwise every frame shows one certain part that can be placed.

    Given `X_BO_second`, there is a second pose estimator, and the method needs both.
    """
    layout, part = small_layout(belt_speed), brick()
    station = FakeStation(layout, move_time=MOVE_TIME, touches=touches)
    referee, records = FakeReferee(station, tries, left_on_belt), Records(station)
    detector = masks(station) if callable(masks) else FakeMasks(masks)
    estimators = [FakePoses(X_BO or [on_belt(part, layout, turned())])]
    if X_BO_second is not None:
        estimators.append(FakePoses(X_BO_second))
    cycle = Cycle(
        station=station,
        referee=referee,
        perception=Perception(part, detector, tuple(estimators), FakeMethod(u, len(estimators)), pixel_center=0.5),
        policy=policy,
        layout=layout,
        config=config or CycleConfig(parts=1, settle_time=SETTLE_TIME),
        listener=listener or records,
    )
    return Experiment(cycle.run(), records, station, referee)


def observation(
    u: Sequence[float],
    scores: Sequence[float] | None = None,
    *,
    X_BC: Pose | None = None,
    X_BO: Sequence[Pose] | None = None,
    refining: bool = False,
    time_left: float = 10.0,
) -> Observation:
    """What a policy is shown: detections of these uncertainties, seen from a camera pose, of parts at these poses."""
    frame = Frame(0, 0.0, Layout().camera, X_BC or Pose.identity())
    detections = tuple(Detection(np.zeros((480, 640), dtype=bool), score) for score in scores or [0.9] * len(u))
    X_CB = frame.X_BC.inverse()
    poses = tuple(X_CB @ X_BO_each for X_BO_each in X_BO or [Pose.identity()] * len(u))
    return Observation(frame, detections, (poses,), np.array(u, dtype=np.float64), refining, time_left, MASK_TIME)


def policy_setup(u_grasp: float = 0.2, u_refine: float = 0.6) -> PolicySetup:
    """What a policy is made with: the brick in the whole cell."""
    return PolicySetup(brick(), Layout(), u_grasp, u_refine)
