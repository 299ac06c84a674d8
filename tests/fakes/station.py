"""A station without physics."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.arm.trajectory import JointTrajectory
from cell.arm.ur10 import forward
from cell.interfaces import Contact, Frame, Image, Touch
from cell.layout import Layout
from cell.records import State
from maskval import Pose
from tests.fakes.script import CONTACT_FORCE, HALF_WIDTH, HOME


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
