"""The cell as a Gymnasium environment to learn motions: the tool's velocity and the jaws at 20 Hz."""

from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from cell.arm.ur10 import JOINT_LIMIT
from cell.interfaces import Contact, Observation, Outcome
from sim.errors import DivergenceError
from sim.gym.base import CellEnv, Info, Step, event
from sim.gym.observation import WORKSPACE, Encoded, box
from sim.gym.velocity_controller import VelocityController
from sim.runtime.episode import Episode

MAX_FORCE = 500.0  # N, where the observed force ends
MAX_HALF_OPENING = 0.1  # m, above any gripper's


@dataclass(slots=True, eq=False)
class _Progress:
    """The state of one experiment."""

    episode: Episode
    controller: VelocityController
    shown: Observation  # the networks' estimates of the newest picture that shows a part
    encoded: Encoded
    coming: Observation  # those of the newest picture, which they still work on
    due: float  # s, when these are ready
    outcomes: list[Outcome | None] = field(default_factory=list)  # of the slots that are over
    voids: int = 0
    container_slot: int = 0
    slot_began: float = 0.0
    over: bool = False


class GraspCellMotionEnv(CellEnv[NDArray[np.float32]]):
    """`GraspCellMotion-v0`. An action: the tool's linear and angular velocity, and the jaws; see `VelocityController`.

    docs/gym.md describes observations, rewards and `info`. Args as in `CellEnv`; one part by default.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 20}  # noqa: RUF012  # as Gymnasium has it

    def __init__(self, render_mode: str | None = None, render_size: tuple[int, int] = (480, 640), **options: Any):
        super().__init__(render_mode, render_size, **({"n_parts": 1} | options))
        chosen = self.options
        self.action_space = spaces.Box(-1.0, 1.0, (7,), np.float32)
        self._own_spaces = {
            "joints": box(6, -JOINT_LIMIT, JOINT_LIMIT),
            "tcp_position": box(3, -WORKSPACE, WORKSPACE),
            "tcp_orientation": box(4, -1.0, 1.0),
            "jaws": box(1, 0.0, MAX_HALF_OPENING),
            "force": box(1, 0.0, MAX_FORCE),
            "slot_position": box(3, -WORKSPACE, WORKSPACE),
            "age": box(1, 0.0, chosen.slot_time * chosen.n_parts + chosen.conditions.latency_s + 1.0),
            "time_left": box(1, 0.0, chosen.slot_time),
            "parts_left": box(1, 0.0, chosen.n_parts),
        }
        self.observation_space = spaces.Dict(self._encoder.spaces | self._own_spaces)
        self._progress: _Progress | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Encoded, Info]:
        """Begins an experiment and looks from the first view; as in `GraspCellEnv`."""
        episode = self._begin_episode(seed, options)
        controller = VelocityController(episode.station, self._built().world.layout)
        episode.referee.attempt_begins(0)
        seen = episode.perception.observe(episode.perception.take_frame(episode.station), False, self.options.slot_time)
        encoded = self._encoder.encode(seen, episode.perception, self._methods)
        self._progress = progress = _Progress(episode, controller, seen, encoded, seen, episode.station.time)
        return self._encoded(progress), self._info(progress, [])

    def step(self, action: NDArray[np.float32]) -> Step:
        """Moves for 50 ms.

        Raises:
            gymnasium.error.ResetNeeded: the episode is over or has not begun.
            gymnasium.error.InvalidAction: the action is not in the space.
        """
        progress = self._progress
        if progress is None or progress.over:
            raise gymnasium.error.ResetNeeded("the episode is over or has not begun: call reset first")
        if not self.action_space.contains(np.asarray(action, np.float32)):
            raise gymnasium.error.InvalidAction(f"expected one of {self.action_space}, got {action}")
        before, slot, ends = progress.episode.station.time, len(progress.outcomes), list[Outcome | None]()
        told: Info = {"blocked": False}
        try:
            told["blocked"], contact = progress.controller.move(np.asarray(action, np.float64))
            ends = self._judge(progress, contact)
            self._look(progress)
        except DivergenceError as failure:
            told["failure"] = str(failure)
        terminated = progress.over
        progress.over |= "failure" in told
        if terminated:
            told["count"] = self._count(progress)
        now = progress.episode.station.time
        reward = self.options.rewards.of(ends, now - before)
        told |= self._info(progress, [event(end, slot, now) for end in ends])
        return self._encoded(progress), reward, terminated, "failure" in told, told

    def close(self) -> None:
        """See `CellEnv`; what the episode holds of the world is let go of, too."""
        self._progress = None
        super().close()

    def _judge(self, progress: _Progress, contact: Contact | None) -> list[Outcome | None]:
        """What ended in this step: an attempt, by a contact or after letting go, or a slot's time (None)."""
        now, outcome = progress.episode.station.time, None
        ends: list[Outcome | None] = []
        if contact is not None or progress.controller.has_let_go:
            outcome = progress.episode.referee.verdict(contact)
            ends.append(outcome)
            progress.container_slot += outcome in (Outcome.PLACED, Outcome.MISPLACED)
            progress.episode.referee.attempt_begins(progress.container_slot)
            progress.controller.forget()
        if outcome in (None, Outcome.VOID) and now >= progress.slot_began + self.options.slot_time - 1e-9:
            ends.append(None)
        if any(end is not Outcome.VOID for end in ends):
            progress.outcomes.append(ends[-1])
            progress.slot_began = now
        progress.voids += Outcome.VOID in ends
        progress.over = contact is not None or len(progress.outcomes) == self.options.n_parts
        return ends

    def _look(self, progress: _Progress) -> None:
        """When the networks have finished a picture, it is shown and the next one is taken; the arm moves on."""
        station, perception = progress.episode.station, progress.episode.perception
        if station.time < progress.due:
            return
        if progress.coming is not progress.shown and progress.coming.detections:
            progress.encoded = self._encoder.encode(progress.coming, perception, self._methods)
            progress.shown = progress.coming
        frame = station.expose(perception.images)
        progress.coming = perception.observe(frame, False, self._time_left(progress))
        progress.due = frame.time + station.latency + perception.inference_time

    def _time_left(self, progress: _Progress) -> float:
        left = progress.slot_began + self.options.slot_time - progress.episode.station.time
        return float(np.clip(left, 0.0, self.options.slot_time))

    def _encoded(self, progress: _Progress) -> Encoded:
        station, world = progress.episode.station, self._built().world
        layout, slots = world.layout, world.layout.container.columns * world.layout.container.rows
        X_BT, part = progress.controller.X_BT, world.part_model.part
        p_WK = layout.container.slot_center(min(progress.container_slot, slots - 1), part.slot_size)
        forces = np.linalg.norm(world.contact_forces(), axis=1)
        own = {
            "joints": station.q,
            "tcp_position": X_BT.translation,
            "tcp_orientation": X_BT.quaternion_wxyz,
            "jaws": [station.jaw_half_opening],
            "force": [forces.max()],
            "slot_position": layout.X_WB.inverse().apply(p_WK),
            "age": [station.time - progress.shown.frame.time],
            "time_left": [self._time_left(progress)],
            "parts_left": [self.options.n_parts - len(progress.outcomes)],
        }
        found = {name: values.copy() for name, values in progress.encoded.items()}
        for name, values in own.items():
            space = self._own_spaces[name]
            found[name] = np.clip(np.asarray(values, np.float32), space.low, space.high)
        return found

    def _count(self, progress: _Progress) -> Info:
        ends = [outcome for outcome in progress.outcomes if outcome is not None]
        return {
            "tp": sum(outcome.is_true_positive for outcome in ends),
            "fp": sum(outcome.is_false_positive for outcome in ends),
            "fn": progress.episode.referee.parts_on_belt(),
            "void": progress.voids,
            "timeouts": progress.outcomes.count(None),
            "duration": progress.episode.station.time,
        }

    def _info(self, progress: _Progress, events: list[Info]) -> Info:
        info: Info = {"events": events, "time": progress.episode.station.time, "experiment": self._experiment}
        return info | ({"truth": self._truth()} if self.options.truth else {})
