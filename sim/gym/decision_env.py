"""The cell as a Gymnasium environment whose steps are decisions: search on, look again, or grasp."""

from dataclasses import asdict
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from cell.arm.limits import PRESETS
from cell.cycle import Cycle, CycleConfig, Deciding
from cell.interfaces import Action, Decision, Observation
from cell.perception import Perception
from cell.records import AttemptRecord, Tally, TimeSlot
from sim.errors import DivergenceError
from sim.gym.base import CellEnv, Info, Step, event
from sim.gym.observation import Encoded, box

SEARCH = 0  # the action that continues the search


class GraspCellEnv(CellEnv[np.int64]):
    """`GraspCell-v0`. Actions: 0 searches on, 1 + k looks again at detection k, 1 + N + k grasps it; k from 0 to N − 1.

    N is `max_detections`. docs/gym.md describes observations, rewards and `info`. Args as in `CellEnv`.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 1}  # noqa: RUF012  # as Gymnasium has it

    def __init__(self, render_mode: str | None = None, render_size: tuple[int, int] = (480, 640), **options: Any):
        super().__init__(render_mode, render_size, **options)
        n, chosen = self.options.max_detections, self.options
        self.action_space = spaces.Discrete(1 + 2 * n)
        self.observation_space = spaces.Dict(
            self._encoder.spaces
            | {
                "time_left": box(1, 0.0, chosen.slot_time),
                "parts_left": box(1, 0.0, chosen.n_parts),
                "refining": spaces.MultiBinary(1),
            }
        )
        self._decisions: Deciding[Tally] | None = None
        self._perception: Perception | None = None
        self._seen: Observation | None = None
        self._records: list[AttemptRecord | TimeSlot] = []
        self._slots_over = 0
        self._time = 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Encoded, Info]:
        """Begins an experiment and looks from the first view.

        Args:
            seed: root of all random numbers; None goes on to the next experiment of the seed before.
            options: {"experiment": i} chooses the number of the experiment.

        Raises:
            SimError: the cell cannot be set up, for example without OpenGL.
        """
        episode = self._begin_episode(seed, options)
        self._perception, self._records, self._slots_over = episode.perception, [], 0
        cycle = Cycle(
            station=episode.station,
            referee=episode.referee,
            perception=episode.perception,
            layout=self._built().world.layout,
            config=CycleConfig(
                parts=self.options.n_parts, slot_time=self.options.slot_time, speed=PRESETS[self.options.speed]
            ),
            listener=self._listen,
        )
        self._decisions = cycle.decisions()
        self._seen = next(self._decisions)
        self._time = self._built().world.time
        return self._encoded(), self._info([])

    def step(self, action: np.int64) -> Step:
        """Carries out the action, up to the next observation; an action that the mask rules out searches on.

        Raises:
            gymnasium.error.ResetNeeded: the episode is over or has not begun.
            gymnasium.error.InvalidAction: the action is not in the space.
            EstimatorError: an uncertainty method of the user's own fails.
        """
        if self._decisions is None or self._seen is None:
            raise gymnasium.error.ResetNeeded("the episode is over or has not begun: call reset first")
        if not self.action_space.contains(action):
            raise gymnasium.error.InvalidAction(f"expected one of {self.action_space}, got {action}")
        valid = bool(self.action_masks()[action])
        before, self._records = self._time, []
        outcome: Info = {}
        try:
            self._seen = self._decisions.send(self._decision(int(action)) if valid else Decision(Action.SEARCH))
        except StopIteration as end:
            self._seen, outcome = None, {"count": asdict(end.value)}
        except DivergenceError as failure:
            self._seen, outcome = None, {"failure": str(failure)}
        self._time = self._built().world.time
        events = [event(record.outcome, _slot(record), record.end) for record in self._records if _is_told(record)]
        ends = [record.outcome for record in self._records if isinstance(record, TimeSlot)]
        reward = self.options.rewards.of(ends, self._time - before) + (0.0 if valid else self.options.rewards.invalid)
        info = self._info(events) | {"invalid_action": not valid} | outcome
        return self._encoded(), reward, "count" in outcome, "failure" in outcome, info

    def close(self) -> None:
        """See `CellEnv`; what the episode holds of the world is let go of, too."""
        if self._decisions is not None:
            self._decisions.close()
        self._decisions = self._perception = self._seen = None
        self._records = []
        super().close()

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions are valid now, (1 + 2 N,): the search always, others on detections that exist."""
        n = self.options.max_detections
        masks = np.zeros((3, n), dtype=bool)
        if self._seen is not None:
            found = len(self._seen.detections)
            masks[1, :found] = self._seen.time_left > 0.0
            masks[2, :found] = True
        return np.concatenate(([True], masks[1], masks[2]))

    def _decision(self, action: int) -> Decision:
        if action == SEARCH:
            return Decision(Action.SEARCH)
        kind, detection = divmod(action - 1, self.options.max_detections)
        return Decision((Action.REFINE, Action.GRASP)[kind], detection)

    def _listen(self, record: object) -> None:
        if isinstance(record, AttemptRecord | TimeSlot):
            self._records.append(record)
            self._slots_over += isinstance(record, TimeSlot)

    def _encoded(self) -> Encoded:
        found, left = self._encoder.empty(), 0.0
        if self._seen is not None and self._perception is not None:
            found = self._encoder.encode(self._seen, self._perception, self._methods)
            left = float(np.clip(self._seen.time_left, 0.0, self.options.slot_time))
        return found | {
            "time_left": np.array([left], np.float32),
            "parts_left": np.array([self.options.n_parts - self._slots_over], np.float32),
            "refining": np.array([self._seen is not None and self._seen.refining], np.int8),
        }

    def _info(self, events: list[Info]) -> Info:
        info: Info = {
            "events": events,
            "time": self._time,
            "experiment": self._experiment,
            "action_mask": self.action_masks().astype(np.int8),
        }
        if self.options.truth:
            info["truth"] = self._truth(self._seen)
        return info


def _is_told(record: AttemptRecord | TimeSlot) -> bool:
    """Whether a record is an event of its own: an attempt that ends a slot is reported by the slot."""
    if isinstance(record, TimeSlot):
        return True
    return not (record.outcome.is_true_positive or record.outcome.is_false_positive)


def _slot(record: AttemptRecord | TimeSlot) -> int:
    return record.index if isinstance(record, TimeSlot) else record.slot
