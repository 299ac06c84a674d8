"""The simulated robot as the controller's station: motions with guarded contacts, jaws, clock and pictures."""

import numpy as np
from numpy.typing import NDArray

from cell.arm.trajectory import JointTrajectory
from cell.arm.ur10 import forward
from cell.interfaces import Contact, Frame, Image, Touch
from cell.rounding import rounded
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera

COLLISION_FORCE = 30.0  # N; free motions read exactly 0, a grasp on a wrong pose reads 80 and more
PRESSING_FORCE = 60.0  # N between the held part and the container, above what a part set down gently makes
TOUCH_FORCE = 0.5  # N from which a part counts as touched


class SimStation:
    """Implements `cell.interfaces.Station` on a `World`."""

    def __init__(self, world: World, camera: WristCamera, latest_truth: LatestTruth) -> None:
        self._world, self._camera, self._latest_truth = world, camera, latest_truth
        self._rows = world.touch_sensors()
        self._peaks = np.zeros(len(world.contact_forces()))
        self._frames = 0

    @property
    def time(self) -> float:
        """See `Station`."""
        return self._world.time

    @property
    def time_step(self) -> float:
        """See `Station`."""
        return self._world.time_step

    @property
    def q(self) -> NDArray[np.float64]:
        """See `Station`."""
        return self._world.q

    @property
    def jaw_half_opening(self) -> float:
        """See `Station`."""
        return self._world.jaw_half_opening

    @property
    def latency(self) -> float:
        """How much later than it was taken a picture arrives, s."""
        return self._world.conditions.latency_s

    def take_frame(self, images: frozenset[Image]) -> Frame:
        """See `Station`. With latency the picture arrives so much later than it was taken, and the arm waits for it."""
        frame = self.expose(images)
        self.wait(self.latency, frozenset())
        return frame

    def expose(self, images: frozenset[Image]) -> Frame:
        """The picture of this moment, for those who do not stand still until it arrives `latency` seconds later.

        Its pose is by forward kinematics of the measured joints, not the simulator's.
        """
        layout = self._world.layout
        X_CO_true = tuple(self._world.X_CO(part) for part in range(self._world.parts))
        frame = Frame(
            index=self._frames,
            time=self.time,
            camera=layout.camera,
            X_BC=forward(self.q) @ layout.X_FC,
            rgb=self._camera.rgb() if Image.RGB in images else None,
            depth=self._camera.depth() if Image.DEPTH in images else None,
        )
        self._latest_truth.keep(
            FrameTruth(
                frame=frame.index,
                instance_ids=self._camera.instance_ids(X_CO_true),
                X_CO_true=X_CO_true,
                camera=self._world.camera_true,
                mesh=self._world.part_model.part.mesh,
            )
        )
        self._frames += 1
        return frame

    def follow(self, trajectory: JointTrajectory, watch: frozenset[Touch]) -> Contact | None:
        """See `Station`. A stop holds the joints where they are."""
        q, qd = rounded(trajectory.positions), rounded(trajectory.velocities)
        qdd = JointTrajectory(self.time_step, q, qd).accelerations
        contact = self._run(np.stack((q, qd, qdd), axis=2), watch)
        if contact is not None:
            self._world.hold_arm(self.q)
        return contact

    def command_jaws(self, half_opening: float) -> None:
        """See `Station`."""
        self._world.command_jaws(half_opening)

    def wait(self, duration: float, watch: frozenset[Touch]) -> Contact | None:
        """See `Station`."""
        return self._run(self._world.still(round(duration / self.time_step)), watch)

    def forget_touches(self) -> None:
        """From now on, `touched_parts` counts afresh."""
        self._peaks[:] = 0.0

    def touched_parts(self) -> list[int]:
        """Parts that the robot has touched since `forget_touches`."""
        rows = self._rows[Touch.PART][: self._world.parts]  # distractors follow
        return [int(part) for part in np.flatnonzero(self._peaks[rows] > TOUCH_FORCE)]

    def _run(self, setpoints: NDArray[np.float64], watch: frozenset[Touch]) -> Contact | None:
        """Steps through the arm's setpoints; ends early on a watched contact."""
        stopped = self._world.follow(setpoints, self._peaks, self._limits(watch))
        self._world.check()
        return self._strongest(watch) if stopped else None

    def _limits(self, watch: frozenset[Touch]) -> NDArray[np.float64]:
        limits = np.full(len(self._peaks), np.inf)
        for touch in watch:
            limits[self._rows[touch]] = PRESSING_FORCE if touch is Touch.PRESSED else COLLISION_FORCE
        return limits

    def _strongest(self, watch: frozenset[Touch]) -> Contact:
        forces = np.linalg.norm(self._world.contact_forces(), axis=1)
        force, touch = max((float(forces[self._rows[touch]].max()), touch) for touch in sorted(watch))
        return Contact(touch, force, self.time)
