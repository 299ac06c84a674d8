"""A part's symmetries as its file lists them: turns about axes after which it looks the same."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maskval import Mesh, Pose, SymmetryAxis
from maskval.symmetry import right_angle_symmetries, symmetry_poses

MOST_DISCRETE = 120  # turns; a dodecahedron has 60
_SAME = 1e-6  # of a rotation's entries


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """An axis and how many equal turns about it make a full one.

    Attributes:
        axis: the axis in O.
        fold: 2 for half a turn, 3 for a third and so on; 0 where every angle is a symmetry.
    """

    axis: SymmetryAxis
    fold: int


def continuous_axes(turns: Sequence[Turn]) -> tuple[SymmetryAxis, ...]:
    """The axes about which every turn is a symmetry."""
    return tuple(turn.axis for turn in turns if turn.fold == 0)


def discrete_symmetries(turns: Sequence[Turn]) -> tuple[Pose, ...]:
    """All poses that the turns of a fold and their products lead to, without the identity.

    Raises:
        ValueError: they are more than `MOST_DISCRETE`, as of turns that do not belong together.
    """
    steps = [turn.axis.turn(2 * math.pi / turn.fold) for turn in turns if turn.fold]
    found = [Pose.identity()]
    for pose in found:  # grows meanwhile
        for step in steps:
            made = step @ pose
            if not any(_same(made.rotation, other.rotation) for other in found):
                found.append(made)
        if len(found) > MOST_DISCRETE:
            raise ValueError(f"expected turns that make at most {MOST_DISCRETE} symmetries, got more")
    return tuple(found[1:])


def model_symmetries(turns: Sequence[Turn], mesh: Mesh) -> tuple[tuple[Pose, ...], tuple[SymmetryAxis, ...]]:
    """Discrete symmetries and axes of continuous ones, as BOP lists them.

    Args:
        turns: those of the part's file; where it lists none, turns by multiples of 90° are looked for.
        mesh: the part's.
    """
    if not turns:
        return right_angle_symmetries(mesh), ()
    return discrete_symmetries(turns), continuous_axes(turns)


def alike(turns: Sequence[Turn]) -> tuple[Pose, ...]:
    """The poses in O that a part with these turns looks the same in, the identity first; none without turns."""
    return symmetry_poses(discrete_symmetries(turns), continuous_axes(turns)) if turns else ()


def _same(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool(np.abs(one - other).max() < _SAME)
