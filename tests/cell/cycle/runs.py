"""What the cycle of these tests is run with, and where it went."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cell.cycle import CycleConfig
from cell.interfaces import Action, Decision, Observation
from cell.records import State
from cell.viewpoints import search_run
from policies import ThresholdPolicy
from tests.fakes import SETTLE_TIME, Experiment, brick, on_belt, small_layout, turned

LAYOUT, PART = small_layout(), brick()
HERE = on_belt(PART, LAYOUT, turned())
ON_ITS_SIDE = on_belt(PART, LAYOUT, turned(roll_deg=90), y_W=-0.3)
FAR = on_belt(PART, LAYOUT, turned(), x_W=2.0)
LOOK = [State.LOOK, State.DECIDE]
CAREFUL = ThresholdPolicy(u_grasp=0.2, u_refine=0.6)


def config(parts: int = 1, slot_time: float = 20.0, **other: float) -> CycleConfig:
    return CycleConfig(parts=parts, slot_time=slot_time, settle_time=SETTLE_TIME, **other)


@dataclass
class Deciding:
    """A policy that decides whatever it is told to, from a certain frame on; before, it searches."""

    answer: Callable[[], Any]
    first: int = 1

    def decide(self, observation: Observation) -> Any:
        return Decision(Action.SEARCH) if observation.frame.index < self.first else self.answer()


def entered(experiment: Experiment) -> list[State]:
    return [transition.target for transition in experiment.transitions]


def views_of(experiment: Experiment) -> list[int | None]:
    """Which view of the search run each frame was taken from, None for none of them."""
    views = search_run(LAYOUT).views
    found = []
    for seen in experiment.seen:
        X_BC = seen.observation.frame.X_BC
        near = [index for index, view in enumerate(views) if np.abs(view.matrix - X_BC.matrix).max() < 1e-6]
        found.append(near[0] if near else None)
    return found
