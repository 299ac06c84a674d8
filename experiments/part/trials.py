"""Grasps tried in physics: one part in one stable pose, gripped by one grasp, its pose exactly known."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice

import numpy as np

from cell.arm.limits import PRESETS
from cell.attempt import Attempt
from cell.interfaces import Outcome
from cell.motion import Motion
from cell.part import MAX_TILT
from experiments.setup.pool import run_all
from sim.model.conditions import UNDISTURBED
from sim.model.parts import load_part
from sim.model.placement import CLEARANCE, DROP_HEIGHT
from sim.networks.ground_truth import LatestTruth
from sim.part_making.reach import lying_at
from sim.runtime.episode import SimCell, build_cell
from sim.runtime.referee import SimReferee
from sim.runtime.station import SimStation

FELL = "fell over"  # before the attempt: the pose is not as stable as its hull says
_STILL = np.cos(np.radians(20.0))


@dataclass(frozen=True, slots=True)
class GraspTrial:
    """One attempt.

    Attributes:
        part: the part's file.
        grasp: number of the grasp.
        pose: number of the stable pose.
        slot: where the part is to go.
        seed: of place and turn on the belt.
        number: of the trial with this grasp and pose.
    """

    part: str
    grasp: int
    pose: int
    slot: int
    seed: int
    number: int


@dataclass(frozen=True, slots=True)
class Tried:
    """What the trials of one grasp in one stable pose came to: how often each outcome."""

    grasp: int
    pose: int
    outcomes: dict[str, int]

    @property
    def trials(self) -> int:
        """How many attempts were made: those before which the part fell over are none."""
        return sum(count for outcome, count in self.outcomes.items() if outcome != FELL)

    @property
    def held(self) -> int:
        """How many of them put the part into its slot."""
        return self.outcomes.get(Outcome.PLACED.value, 0)


def try_grasps(
    part: str, uses: Sequence[tuple[int, int]], *, slots: int, trials: int, seed: int, jobs: int
) -> Iterator[Tried]:
    """Tries grasps; yields what each came to as soon as it is known.

    Args:
        part: the part's file.
        uses: pairs of grasp and stable pose, by number.
        slots: how many slots the arm reaches.
        trials: attempts per pair.
        seed: root of all random numbers.
        jobs: processes.
    """
    tasks = [
        GraspTrial(part, grasp, pose, number % slots, seed, number) for grasp, pose in uses for number in range(trials)
    ]
    outcomes = run_all(run_trial, tasks, jobs)
    for grasp, pose in uses:
        yield Tried(grasp, pose, dict(sorted(Counter(islice(outcomes, trials)).items())))


@lru_cache(maxsize=2)
def _cell(part: str) -> SimCell:
    return build_cell(part, 1, UNDISTURBED, False)


def run_trial(trial: GraspTrial) -> str:
    """The attempt's outcome, or `FELL`."""
    cell, latest_truth = _cell(trial.part), LatestTruth()
    world, model = cell.world, load_part(trial.part)
    pose, belt = model.resting_poses[trial.pose], world.layout.belt
    rng = np.random.default_rng(np.random.SeedSequence(trial.seed, spawn_key=(trial.grasp, trial.pose, trial.number)))
    yaw = rng.uniform(-np.pi, np.pi)
    outline = lying_at(pose, yaw, 0.0, 0.0, world.layout).apply(model.part.mesh.vertices)[:, :2]
    room = np.maximum(0.0, np.array([belt.width, belt.loading_length]) / 2 - CLEARANCE - np.ptp(outline, axis=0) / 2)
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2 - [belt.center_x, 0.0]
    x, y = rng.uniform(-room, room) - middle
    X_WO = lying_at(pose, yaw, x, y, world.layout)
    world.reset([replace(X_WO, translation=X_WO.translation + [0.0, 0.0, DROP_HEIGHT])])
    lying = world.X_WO(0)
    if lying.rotation[2] @ pose.rotation[2] < _STILL:
        return FELL
    station = SimStation(world, cell.camera, latest_truth)
    referee = SimReferee(world, station)
    referee.attempt_begins(trial.slot)
    alone = replace(model.part, grasps=(replace(model.part.grasps[trial.grasp], max_tilt=MAX_TILT),))
    motion = Motion(station, world.layout, PRESETS["ur-default"])
    reach = Attempt(motion, alone, lambda *_: None).run(world.layout.X_WB.inverse() @ lying, trial.slot, station.time)
    return (Outcome.UNREACHABLE if reach.grasp is None else referee.verdict(reach.contact)).value
