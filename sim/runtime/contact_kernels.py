"""What is done after a step in which things touch, compiled: it takes a fraction of the step that way."""

import numpy as np
from numpy.typing import NDArray

from cell.rounding import DIGITS
from maskval.rendering.compiled import jit

Floats = NDArray[np.float64]

# Decimals of m/s and m/s² (rad/s, rad/s²): the solver's last bits are larger than those of places.
VELOCITY_DIGITS, ACCELERATION_DIGITS = 7, 3
_PLACE, _VELOCITY, _ACCELERATION = 10.0**DIGITS, 10.0**VELOCITY_DIGITS, 10.0**ACCELERATION_DIGITS


@jit
def round_state(
    qpos: Floats, qvel: Floats, warmstart: Floats, tree_asleep: NDArray[np.int32], tree_of_position: NDArray[np.intp]
) -> None:
    """Rounds a state in place. A sleeping thing keeps its place as it is, since a change would wake it.

    Args:
        qpos: Positions, (nq,).
        qvel: Velocities, (nv,).
        warmstart: The accelerations that the solver begins with, (nv,).
        tree_asleep: Below 0 for a kinematic tree that is awake, (ntree,).
        tree_of_position: The tree that each position belongs to, (nq,).
    """
    for i in range(len(qpos)):
        if tree_asleep[tree_of_position[i]] < 0:
            qpos[i] = np.rint(qpos[i] * _PLACE) / _PLACE
    for i in range(len(qvel)):
        qvel[i] = np.rint(qvel[i] * _VELOCITY) / _VELOCITY
        warmstart[i] = np.rint(warmstart[i] * _ACCELERATION) / _ACCELERATION


@jit
def note_forces(forces: Floats, peaks: Floats, limits: Floats) -> bool:
    """Raises the peaks to the forces, and says whether a force is above its limit.

    Args:
        forces: Force vectors, (S, 3) N.
        peaks: Largest force so far of each sensor, (S,) N.
        limits: Of each sensor, (S,) N.
    """
    above = False
    for i in range(len(peaks)):
        force = np.sqrt(forces[i, 0] ** 2 + forces[i, 1] ** 2 + forces[i, 2] ** 2)
        peaks[i] = max(peaks[i], force)
        above |= force > limits[i]
    return above
