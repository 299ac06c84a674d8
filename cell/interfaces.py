"""What the controller asks of the world: the ports. Simulation, another simulation or a real cell stand behind them.

Nothing here holds the truth: a `Frame` is a picture and the camera pose that the robot believes in.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Correspondences, Pose

if TYPE_CHECKING:
    from cell.arm.trajectory import JointTrajectory


class Image(StrEnum):
    """What a camera can deliver; estimators name what they read, and nothing else is rendered."""

    RGB = "rgb"
    DEPTH = "depth"


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One picture.

    Attributes:
        index: counts the frames of one experiment from 0.
        time: when it was taken, s since the start of the experiment.
        camera: the pinhole model.
        X_BC: the camera's pose as the robot believes it.
        rgb: (H, W, 3) uint8, if it was asked for.
        depth: (H, W) z-depth in metres, 0 where nothing is, if it was asked for.
    """

    index: int
    time: float
    camera: Camera
    X_BC: Pose
    rgb: NDArray[np.uint8] | None = None
    depth: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        for image in (self.rgb, self.depth):
            if image is not None:
                image.setflags(write=False)  # estimators share it


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One instance found in a frame: its mask, (H, W) bool, and the detector's score in [0, 1]."""

    mask: NDArray[np.bool_]
    score: float

    def __post_init__(self) -> None:
        mask = np.array(self.mask)
        mask.setflags(write=False)
        object.__setattr__(self, "mask", mask)


class MaskEstimator(Protocol):
    """An instance segmentation network."""

    @property
    def inference_time(self) -> float:
        """What one frame costs, s of the cell's clock."""

    @property
    def images(self) -> frozenset[Image]:
        """The images that it reads."""

    def detect(self, frame: Frame) -> Sequence[Detection]:
        """The instances in the frame, in any order."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseEstimate:
    """A pose, and what it was computed from, for methods that judge by that.

    Attributes:
        X_CO_est: the estimated pose.
        correspondences: points of the part and where they were seen; None of a network that has none.
    """

    X_CO_est: Pose
    correspondences: Correspondences | None = None


class PoseEstimator(Protocol):
    """A 6D pose network of the two-stage kind: pose i comes from detection i."""

    @property
    def inference_time(self) -> float:
        """What one frame costs, s of the cell's clock."""

    @property
    def images(self) -> frozenset[Image]:
        """The images that it reads."""

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> Sequence[Pose | PoseEstimate]:
        """X_CO_est, one per detection, with its correspondences if the network has such."""


class Action(StrEnum):
    """What to do next."""

    GRASP = "grasp"
    REFINE = "refine"
    SEARCH = "search"


@dataclass(frozen=True, slots=True)
class Decision:
    """An action, and what it is about.

    Attributes:
        action: what to do.
        detection: the detection that it is about; None to search on because there was none.
        threshold: the bound that the detection's u met or, to search on, that it missed; None if there was none.
        X_BO_est: to grasp, the pose to act upon; None for the detection's own.
        X_BC: to refine, the view to take of the part where the frame shows it, from where a moving belt carries it on;
            None for the one straight above the part.
        u: the uncertainty that was decided upon, in [0, 1]; None for the detection's own.
    """

    action: Action
    detection: int | None = None
    threshold: float | None = None
    X_BO_est: Pose | None = None
    X_BC: Pose | None = None
    u: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """A frame with everything that was concluded from it.

    Attributes:
        frame: the picture.
        detections: what was found, best score first.
        poses: `poses[e][i]` is estimator e's X_CO_est of detection i; estimator 0's is the one to act upon.
        uncertainties: u of each detection, (N,) in [0, 1].
        refining: whether this frame was taken to have another look.
        time_left: s until the part's time is up; an attempt that begins before is finished.
        inference_time: what the networks took for it, s of the cell's clock.
        correspondences: of estimator 0's poses; None if it has none.
    """

    frame: Frame
    detections: tuple[Detection, ...]
    poses: tuple[tuple[Pose, ...], ...]
    uncertainties: NDArray[np.float64]
    refining: bool
    time_left: float
    inference_time: float
    correspondences: tuple[Correspondences, ...] | None = None

    def u(self, decision: Decision, detection: int) -> float:
        """The uncertainty that a decision about a detection was made upon."""
        return float(self.uncertainties[detection] if decision.u is None else decision.u)

    def X_BO_est(self, detection: int) -> Pose:
        """The estimated pose of a detection in the robot's base."""
        return self.frame.X_BC @ self.poses[0][detection]


class Policy(Protocol):
    """A decision rule; made anew for every experiment, so that it may remember what it has seen."""

    def decide(self, observation: Observation) -> Decision:
        """What to do, given the newest observation. To refine is possible as long as the part has time left."""


class Touch(StrEnum):
    """Whom the robot can touch when it should not."""

    BELT = "belt"
    CONTAINER = "container"
    PART = "part"
    ROBOT = "robot"  # itself, or its foot
    PRESSED = "pressed"  # the part in the jaws against the container


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact that stopped a motion: with what, how strong (N) and when (s)."""

    touch: Touch
    force: float
    time: float


class Outcome(StrEnum):
    """What an attempt came to."""

    PLACED = "placed"
    COLLISION_PART = "collision with part"
    COLLISION_BELT = "collision with belt"
    COLLISION_CONTAINER = "collision with container"
    COLLISION_ROBOT = "collision with itself"
    DROPPED = "dropped"
    MISPLACED = "misplaced"
    VOID = "void"
    UNREACHABLE = "unreachable"

    @property
    def is_true_positive(self) -> bool:
        """The part lies in its slot."""
        return self is Outcome.PLACED

    @property
    def is_false_positive(self) -> bool:
        """An attempt that ended in a collision or an unsuccessful placing; void and unreachable only cost time."""
        return self not in (Outcome.PLACED, Outcome.VOID, Outcome.UNREACHABLE)


class Station(Protocol):
    """The robot with its gripper, camera and clock."""

    @property
    def time(self) -> float:
        """Seconds since the start of the experiment."""

    @property
    def time_step(self) -> float:
        """The period of the robot's controller, s."""

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint angles, (6,) rad."""

    @property
    def jaw_half_opening(self) -> float:
        """Distance of each jaw from the middle, m."""

    def take_frame(self, images: frozenset[Image]) -> Frame:
        """A picture from where the camera is now."""

    def follow(self, trajectory: "JointTrajectory", watch: frozenset[Touch]) -> Contact | None:
        """Moves; stops at once and says why when one of the watched contacts is too strong.

        A trajectory that begins at rest begins where the arm is; where one begins in motion, its first sample is where
        the arm shall be one time step from now.
        """

    def command_jaws(self, half_opening: float) -> None:
        """Sends the jaws to a half opening, m; a negative one grips. Returns at once, they move as time goes on."""

    def wait(self, duration: float, watch: frozenset[Touch]) -> Contact | None:
        """Lets the clock run, s, while the arm stands still; returns early on a watched contact."""


class Referee(Protocol):
    """Says what an attempt came to: a person beside a real cell, the truth in a simulated one."""

    def attempt_begins(self, container_slot: int) -> None:
        """From here on, contacts count for this attempt."""

    def verdict(self, stopped_by: Contact | None) -> Outcome:
        """What the attempt that just ended came to."""

    def parts_on_belt(self) -> int:
        """How many parts still lie on the belt, or were carried over its end."""


Listener = Callable[[object], None]  # is told every record as it is made, see cell.records
