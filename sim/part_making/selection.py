"""A few grasps that cover every stable pose, chosen from many."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cell.layout import Layout
from cell.part import Grasp, Part
from maskval import Mesh
from sim.part_making.grasp_search import PREFERRED_TILT, Candidate
from sim.part_making.reach import ENOUGH, belt_share
from sim.parts.part_checks import tilt_of
from sim.parts.stable_poses import RestingPose

MOST_GRASPS = 12
_TRIED = 12  # candidates per stable pose whose reach is looked at
_COVERS = 3.0  # score of a grasp that covers all of the parts that no other one covers yet


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """A grasp that was chosen.

    Attributes:
        candidate: where it comes from.
        grasp: as the part's file gets it.
        poses: numbers of the stable poses in which the robot would take it: no other grasp is more upright there.
    """

    candidate: Candidate
    grasp: Grasp
    poses: tuple[int, ...]


def choose(
    candidates: Sequence[Candidate], poses: Sequence[RestingPose], mesh: Mesh, layout: Layout
) -> tuple[Chosen, ...]:
    """At most `MOST_GRASPS` grasps, for the likeliest stable poses first.

    Args:
        candidates: the best first.
        poses: the stable poses.
        mesh: the part's.
        layout: the cell, which says what the arm reaches.
    """
    picked: list[Candidate] = []
    covered: set[int] = set()
    for index in range(len(poses)):
        if index in covered or len(picked) == MOST_GRASPS:
            continue
        best = _best_for(index, candidates, poses, covered, mesh=mesh, layout=layout)
        if best is not None:
            picked.append(best)
            covered |= {one for one in best.usable if one not in covered and _upright(best, poses[one])} | {index}
    grasps = [_named(number, one) for number, one in enumerate(picked)]
    owners = [_owner(grasps, pose) for pose in poses]
    return tuple(
        Chosen(candidate, grasp, tuple(index for index, owner in enumerate(owners) if owner == number))
        for number, (candidate, grasp) in enumerate(zip(picked, grasps, strict=True))
    )


def _best_for(
    index: int,
    candidates: Sequence[Candidate],
    poses: Sequence[RestingPose],
    covered: set[int],
    *,
    mesh: Mesh,
    layout: Layout,
) -> Candidate | None:
    """The grasp for one stable pose, of those that the arm reaches (nearly) everywhere on the belt."""

    def value(one: Candidate) -> float:
        new = sum(poses[other].probability for other in one.usable if other not in covered)
        left = sum(pose.probability for other, pose in enumerate(poses) if other not in covered)
        tilt = tilt_of(_named(0, one), poses[index])
        return float(one.score + _COVERS * new / left - tilt / PREFERRED_TILT)

    usable = [one for one in candidates if index in one.usable and _upright(one, poses[index])]
    reached: list[tuple[float, Candidate]] = []
    for one in sorted(usable, key=lambda candidate: -round(value(candidate), 6))[:_TRIED]:
        share = belt_share(Part("part", mesh, (_named(0, one),), (0.2, 0.2)), poses[index], layout)
        if share >= ENOUGH:
            return one
        reached.append((share, one))
    best = max(reached, key=lambda entry: round(entry[0], 6), default=(0.0, None))
    return best[1] if best[0] > 0 else None


def _upright(candidate: Candidate, pose: RestingPose) -> bool:
    return tilt_of(_named(0, candidate), pose) <= min(PREFERRED_TILT, candidate.max_tilt - float(np.radians(2.0)))


def _named(number: int, candidate: Candidate) -> Grasp:
    grip = candidate.grip
    return Grasp(f"grasp-{number + 1}", grip.X_OT, grip.half_opening, candidate.max_tilt)


def _owner(grasps: Sequence[Grasp], pose: RestingPose) -> int | None:
    """The grasp that the robot takes first: the most upright one, of equals the first."""
    tilts = [(round(tilt_of(grasp, pose), 6), number) for number, grasp in enumerate(grasps)]
    fitting = [(tilt, number) for tilt, number in tilts if tilt <= grasps[number].max_tilt]
    return min(fitting)[1] if fitting else None
