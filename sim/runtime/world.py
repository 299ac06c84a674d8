"""The running physics: reset, step, read and command. Truth is read here and nowhere else."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from cell.arm.ur10 import inverse_on_branch
from cell.interfaces import Touch
from cell.layout import Layout
from cell.rounding import rounded
from cell.viewpoints import search_run
from maskval import Pose
from sim.errors import DivergenceError
from sim.model.bodies import part_body
from sim.model.clutter import distractor_body, distractors_of
from sim.model.conditions import UNDISTURBED, Conditions
from sim.model.parts import PartModel
from sim.model.robot import FINGERS, JOINTS
from sim.model.scene import SURFACE_VELOCITY_Y, build_scene, container_presses, robot_touches
from sim.runtime.stepping import Engine, run_periods

SETTLE_TIME = 1.0  # s of physics before an experiment begins
Q_NEAR_BELT = np.radians([0.0, -100.0, 100.0, -90.0, -90.0, 0.0])  # which turn of base and wrist 3 to begin with

Array = NDArray[np.float64]


class World:
    """One cell with its parts. Build it once, `reset` it for every experiment.

    Args:
        layout: the cell.
        model: the kind of part.
        parts: how many of them.
        conditions: what disturbs the cell.
        use_meshes: whether pictures show the arm with its maker's meshes; nothing else depends on it.
    """

    def __init__(
        self,
        layout: Layout,
        model: PartModel,
        parts: int,
        conditions: Conditions = UNDISTURBED,
        use_meshes: bool = False,
    ) -> None:
        self.layout, self.part_model, self.parts, self.conditions = layout, model, parts, conditions
        self.use_meshes = use_meshes
        self.camera_true, self.belt_true = conditions.camera_true(layout.camera), conditions.belt_true(layout.belt)
        self.mj_model = build_scene(layout, [model] * parts, model.part.slot_size, conditions)
        self.data = mujoco.MjData(self.mj_model)
        compiled = self.mj_model
        first = compiled.joint(JOINTS[0])  # the others follow it
        self._arm = slice(first.qposadr[0], first.qposadr[0] + len(JOINTS))
        self._jaw = compiled.joint(FINGERS[0]).qposadr[0]
        self._jaw_command = compiled.actuator_ctrladr[compiled.actuator("jaws").id]
        self._bodies = np.array([compiled.body(part_body(index)).id for index in range(parts)])
        things = [distractor_body(index) for index in range(len(distractors_of(conditions.clutter)))]
        lying = [*map(part_body, range(parts)), *things]
        self._free_joints = [compiled.joint(name).qposadr[0] for name in lying]
        self._obstacles = [robot_touches(name) for name in things]
        self._engine = self._mapped(first.dofadr[0])
        self._held = np.zeros((1, len(JOINTS), 3))  # what the arm was told last, and no acceleration
        self._flange = compiled.body("flange").id
        self._wrist = compiled.camera("wrist").id
        self._belt = compiled.geom("belt").id
        self.q_home = self._home()
        self.on_step: Callable[[], None] | None = None  # called after every step, by a window that shows the world

    def _mapped(self, arm: int) -> Engine:
        """The model and its data for the compiled loop, given the first of the arm's degrees of freedom."""
        model, data = self.mj_model, self.data
        # Each servo takes position, speed and torque, and the joints' servos follow one another.
        servo = model.actuator_ctrladr[model.actuator(JOINTS[0]).id]
        servos = data.ctrl[servo : servo + 3 * len(JOINTS)].reshape(len(JOINTS), 3)
        state = (data.qpos, data.qvel, data.qacc_warmstart, data.tree_asleep, _tree_of_position(model))
        return Engine(model._address, data._address, servos, int(arm), *state, self.contact_forces())

    def _home(self) -> Array:
        """Joint angles of the search run's first view."""
        first = search_run(self.layout).views[0]
        q = inverse_on_branch(first @ self.layout.X_FC.inverse(), Q_NEAR_BELT)
        if q is None:
            raise ValueError("the layout's first search view is out of the arm's reach")
        return rounded(q)

    def reset(self, X_WO: Sequence[Pose]) -> None:
        """Puts arm and parts in place and lets them settle; the clock then stands at 0.

        Args:
            X_WO: poses of the parts, then of the distractors if there are any.

        Raises:
            DivergenceError: the parts do not come to rest in finite numbers.
        """
        mujoco.mj_resetData(self.mj_model, self.data)
        self.mj_model.geom_surfacevel[self._belt, SURFACE_VELOCITY_Y] = 0.0  # the model's, not the data's
        self.data.qpos[self._arm] = self.q_home
        for address, pose in zip(self._free_joints, X_WO, strict=True):
            self.data.qpos[address : address + 3] = rounded(pose.translation)
            self.data.qpos[address + 3 : address + 7] = rounded(pose.quaternion_wxyz)
        self.hold_arm(self.q_home)
        self.command_jaws(self.layout.gripper.max_half_opening)
        run_periods(self._engine, self.still(round(SETTLE_TIME / self.time_step)), *self._unwatched())
        self.check()
        self.data.time = 0.0
        if self.belt_true.speed:
            self.move_belt(-self.belt_true.speed)

    @property
    def time(self) -> float:
        """Seconds since the reset."""
        return float(self.data.time)

    @property
    def time_step(self) -> float:
        """Period of the robot's controller, s."""
        return float(self.mj_model.opt.timestep)

    @property
    def q(self) -> Array:
        """Measured joint angles, (6,) rad, to `DIGITS` decimals."""
        return rounded(self.data.qpos[self._arm])

    @property
    def jaw_half_opening(self) -> float:
        """Measured distance of each jaw from the middle, m, to `DIGITS` decimals."""
        return float(rounded(self.data.qpos[self._jaw]))

    @property
    def q_told(self) -> Array:
        """Joint angles that the servos were told last, (6,) rad."""
        return self._held[0, :, 0].copy()

    @property
    def jaws_told(self) -> float:
        """Half opening that the jaws were told last, m."""
        return float(self.data.ctrl[self._jaw_command])

    def hold_arm(self, q: Array) -> None:
        """Has the servos hold joint angles, (6,) rad, from the next step on."""
        self._held[0, :, 0], self._held[0, :, 1:] = q, 0.0

    def command_jaws(self, half_opening: float) -> None:
        """Sets the jaws' half opening, m."""
        self.data.ctrl[self._jaw_command] = half_opening

    def move_belt(self, speed: float) -> None:
        """Sets the speed of the belt's surface along W's y, m/s, and wakes the parts that lie on it."""
        self.mj_model.geom_surfacevel[self._belt, SURFACE_VELOCITY_Y] = speed
        nudge = 1e-2  # m/s: sleeping parts are not woken by the surface under them
        for body in self._bodies:
            self.data.qvel[self.mj_model.body_dofadr[body] + SURFACE_VELOCITY_Y] += nudge

    def step(self) -> None:
        """Lets a period of the robot's controller pass, one step of the physics; the arm is told nothing new."""
        self.follow(self.still(1), *self._unwatched())

    def still(self, periods: int) -> Array:
        """Setpoints of an arm that goes on as it was told last, (periods, 6, 3)."""
        return np.repeat(self._held, periods, axis=0)

    def _unwatched(self) -> tuple[Array, Array]:
        """Peaks and limits of contact forces that nobody asks for."""
        sensors = len(self._engine.forces)
        return np.zeros(sensors), np.full(sensors, np.inf)

    def follow(self, setpoints: Array, peaks: Array, limits: Array) -> bool:
        """Steps through setpoints of the arm; see `run_periods`.

        Returns:
            Whether a force was above its limit; the state is then that after its step.
        """
        each = len(setpoints) if self.on_step is None else 1
        for start in range(0, len(setpoints), max(1, each)):
            some = setpoints[start : start + each]
            steps = run_periods(self._engine, some, peaks, limits)
            self._held[0, :, :2] = some[steps - 1, :, :2]  # of the last step: −1 where all were made
            if self.on_step is not None:
                self.on_step()
            if steps:
                return True
        return False

    def check(self) -> None:
        """Asks whether the physics is still finite.

        Raises:
            DivergenceError: it is not.
        """
        warnings = self.data.warning
        for kind in (
            mujoco.mjtWarning.mjWARN_BADQPOS,
            mujoco.mjtWarning.mjWARN_BADQVEL,
            mujoco.mjtWarning.mjWARN_BADQACC,
        ):
            if warnings[kind].number:
                raise DivergenceError(f"physics diverged ({kind.name}) before {self.time:.3f} s")
        if not (np.isfinite(self.data.qpos).all() and np.isfinite(self.data.qvel).all()):
            raise DivergenceError(f"physics has numbers that are not finite at {self.time:.3f} s")

    def X_WO(self, index: int) -> Pose:
        """True pose of a part."""
        body = self._bodies[index]
        return Pose(self.data.xmat[body].reshape(3, 3), self.data.xpos[body])

    def p_W_center_of_mass(self, index: int) -> Array:
        """True centre of mass of a part, (3,) m."""
        center: Array = self.data.xipos[self._bodies[index]]
        return center

    def velocity(self, index: int) -> Array:
        """True velocity of a part: linear in W, m/s, then angular in O, rad/s; (6,)."""
        first = self.mj_model.body_dofadr[self._bodies[index]]
        found: Array = self.data.qvel[first : first + 6]
        return found

    def X_WF(self) -> Pose:
        """True pose of the flange."""
        return Pose(self.data.xmat[self._flange].reshape(3, 3), self.data.xpos[self._flange])

    def X_WC(self) -> Pose:
        """True pose of the wrist camera, in OpenCV's convention."""
        rotation = self.data.cam_xmat[self._wrist].reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
        return Pose(rotation, self.data.cam_xpos[self._wrist])

    def X_CO(self, index: int) -> Pose:
        """True pose of a part in the true camera."""
        return self.X_WC().inverse() @ self.X_WO(index)

    def touch_sensors(self) -> dict[Touch, NDArray[np.intp]]:
        """Rows of `contact_forces` for every kind of touch; distractors come after the parts and count as such."""
        names = {
            Touch.BELT: [robot_touches("belt")],
            Touch.CONTAINER: [robot_touches("container")],
            Touch.ROBOT: [robot_touches("base"), robot_touches("itself")],
            Touch.PART: [*(robot_touches(part_body(index)) for index in range(self.parts)), *self._obstacles],
            Touch.PRESSED: [container_presses(index) for index in range(self.parts)],
        }
        return {
            touch: np.array([self.mj_model.sensor(name).adr[0] // 3 for name in group])
            for touch, group in names.items()
        }

    def contact_forces(self) -> Array:
        """Strongest contact force vector of every sensor, (S, 3) N; a view that the next step overwrites."""
        forces: Array = self.data.sensordata.reshape(-1, 3)
        return forces


def _tree_of_position(model: mujoco.MjModel) -> NDArray[np.intp]:
    """The kinematic tree that each entry of `qpos` belongs to, (nq,)."""
    sizes = np.diff([*model.jnt_qposadr, model.nq])
    trees: NDArray[np.intp] = np.repeat(model.dof_treeid[model.jnt_dofadr], sizes)
    return trees
