"""The cell as a Gymnasium environment for those who learn motions: the tool's velocity and the jaws at 20 Hz."""

from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from cell.interfaces import Contact, Observation, Outcome
from cell.ur10 import JOINT_LIMIT
from sim.errors import DivergenceError
from sim.gym.base import CellEnv, Info, Step, event
from sim.gym.observation import WORKSPACE, Encoded, box
from sim.gym.velocity_controller import Hand
from sim.runtime.episode import Stage

MAX_FORCE = 500.0  # N, where the observed force ends
MAX_HALF_OPENING = 0.1  # m, above any gripper's


@dataclass(slots=True, eq=False)
class _Episode:
    """What one experiment has come to."""

    stage: Stage
    hand: Hand
    shown: Observation  # what the networks made of the newest picture that shows a part
    encoded: Encoded
    coming: Observation  # what they will have made of the newest one
    due: float  # s, when they will
    outcomes: list[Outcome | None] = field(default_factory=list)  # of the slots that are over
    voids: int = 0
    container_slot: int = 0
    slot_began: float = 0.0
    over: bool = False


class GraspCellMotionEnv(CellEnv[NDArray[np.float32]]):
    """`GraspCellMotion-v0`. An action holds the tool's linear and angular velocity and the jaws, see `Hand.move`.

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
        self._episode: _Episode | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Encoded, Info]:
        """Begins an experiment and looks from the first view; as in `GraspCellEnv`."""
        stage = self._set_stage(seed, options)
        hand = Hand(stage.station, self._built().world.layout)
        stage.referee.attempt_begins(0)
        seen = stage.perception.observe(stage.perception.take_frame(stage.station), False, self.options.slot_time)
        encoded = self._encoder.encode(seen, stage.perception, self._methods)
        self._episode = episode = _Episode(stage, hand, seen, encoded, seen, stage.station.time)
        return self._encoded(episode), self._info(episode, [])

    def step(self, action: NDArray[np.float32]) -> Step:
        """Moves for 50 ms.

        Raises:
            gymnasium.error.ResetNeeded: the episode is over or has not begun.
            gymnasium.error.InvalidAction: the action is none of the space.
        """
        episode = self._episode
        if episode is None or episode.over:
            raise gymnasium.error.ResetNeeded("the episode is over or has not begun: call reset first")
        if not self.action_space.contains(np.asarray(action, np.float32)):
            raise gymnasium.error.InvalidAction(f"expected one of {self.action_space}, got {action}")
        before, slot, ends = episode.stage.station.time, len(episode.outcomes), list[Outcome | None]()
        told: Info = {"blocked": False}
        try:
            told["blocked"], contact = episode.hand.move(np.asarray(action, np.float64))
            ends = self._judge(episode, contact)
            self._look(episode)
        except DivergenceError as failure:
            told["failure"] = str(failure)
        terminated = episode.over
        episode.over |= "failure" in told
        if terminated:
            told["count"] = self._count(episode)
        now = episode.stage.station.time
        reward = self.options.rewards.of(ends, now - before)
        told |= self._info(episode, [event(end, slot, now) for end in ends])
        return self._encoded(episode), reward, terminated, "failure" in told, told

    def _judge(self, episode: _Episode, contact: Contact | None) -> list[Outcome | None]:
        """What ended in this step: an attempt, by a contact or after letting go, or a slot's time (None)."""
        now, outcome = episode.stage.station.time, None
        ends: list[Outcome | None] = []
        if contact is not None or episode.hand.has_let_go:
            outcome = episode.stage.referee.verdict(contact)
            ends.append(outcome)
            episode.container_slot += outcome in (Outcome.PLACED, Outcome.MISPLACED)
            episode.stage.referee.attempt_begins(episode.container_slot)
            episode.hand.forget()
        if outcome in (None, Outcome.VOID) and now >= episode.slot_began + self.options.slot_time - 1e-9:
            ends.append(None)
        if any(end is not Outcome.VOID for end in ends):
            episode.outcomes.append(ends[-1])
            episode.slot_began = now
        episode.voids += Outcome.VOID in ends
        episode.over = contact is not None or len(episode.outcomes) == self.options.n_parts
        return ends

    def _look(self, episode: _Episode) -> None:
        """When the networks are done with a picture, it is shown and the next one taken; the arm moves on."""
        station, perception = episode.stage.station, episode.stage.perception
        if station.time < episode.due:
            return
        if episode.coming is not episode.shown and episode.coming.detections:
            episode.encoded = self._encoder.encode(episode.coming, perception, self._methods)
            episode.shown = episode.coming
        frame = station.expose(perception.images)
        episode.coming = perception.observe(frame, False, self._time_left(episode))
        episode.due = frame.time + station.latency + perception.inference_time

    def _time_left(self, episode: _Episode) -> float:
        left = episode.slot_began + self.options.slot_time - episode.stage.station.time
        return float(np.clip(left, 0.0, self.options.slot_time))

    def _encoded(self, episode: _Episode) -> Encoded:
        station, world = episode.stage.station, self._built().world
        layout, slots = world.layout, world.layout.container.columns * world.layout.container.rows
        X_BT, part = episode.hand.X_BT, world.part_model.part
        p_WK = layout.container.slot_center(min(episode.container_slot, slots - 1), part.slot_size)
        forces = np.linalg.norm(world.contact_forces(), axis=1)
        own = {
            "joints": station.q,
            "tcp_position": X_BT.translation,
            "tcp_orientation": X_BT.quaternion_wxyz,
            "jaws": [station.jaw_half_opening],
            "force": [forces.max()],
            "slot_position": layout.X_WB.inverse().apply(p_WK),
            "age": [station.time - episode.shown.frame.time],
            "time_left": [self._time_left(episode)],
            "parts_left": [self.options.n_parts - len(episode.outcomes)],
        }
        found = {name: values.copy() for name, values in episode.encoded.items()}
        for name, values in own.items():
            space = self._own_spaces[name]
            found[name] = np.clip(np.asarray(values, np.float32), space.low, space.high)
        return found

    def _count(self, episode: _Episode) -> Info:
        ends = [outcome for outcome in episode.outcomes if outcome is not None]
        return {
            "tp": sum(outcome.is_true_positive for outcome in ends),
            "fp": sum(outcome.is_false_positive for outcome in ends),
            "fn": episode.stage.referee.parts_on_belt(),
            "void": episode.voids,
            "timeouts": episode.outcomes.count(None),
            "duration": episode.stage.station.time,
        }

    def _info(self, episode: _Episode, events: list[Info]) -> Info:
        info: Info = {"events": events, "time": episode.stage.station.time, "experiment": self._experiment}
        return info | ({"truth": self._truth()} if self.options.truth else {})
