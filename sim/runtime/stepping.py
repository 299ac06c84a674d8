"""The loop over the controller's periods, compiled: setpoint, step, rounding, forces. In Python it costs a fifth more.

The engine's functions are called at their addresses in its library, with the addresses of model and data.
"""

import ctypes
import re
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from llvmlite import binding
from numba import types
from numpy.typing import NDArray

from cell.rounding import DIGITS
from maskval.compiled import jit

Floats = NDArray[np.float64]

_LIBRARY = re.compile(r"(lib)?mujoco(\.so\.[\d.]+|\.[\d.]+\.dylib|\.dll)")
# Decimals of m/s and m/s² (rad/s, rad/s²): the solver's last bits are larger than those of places.
VELOCITY_DIGITS, ACCELERATION_DIGITS = 7, 3
_PLACE, _VELOCITY, _ACCELERATION = 10.0**DIGITS, 10.0**VELOCITY_DIGITS, 10.0**ACCELERATION_DIGITS


def _library() -> ctypes.CDLL:
    folder = Path(mujoco.__file__).parent
    found = [path for path in folder.iterdir() if _LIBRARY.fullmatch(path.name)]
    if len(found) != 1:
        raise ImportError(f"expected one library of MuJoCo's in {folder}, got {[path.name for path in found]}")
    return ctypes.CDLL(str(found[0]))


for _name in ("mj_step", "mj_mulM"):
    binding.add_symbol(_name, ctypes.cast(getattr(_library(), _name), ctypes.c_void_p).value)
_step: Any = types.ExternalFunction("mj_step", types.void(types.uintp, types.uintp))
_multiply_by_inertia: Any = types.ExternalFunction(
    "mj_mulM", types.void(types.uintp, types.uintp, types.uintp, types.uintp)
)


class Engine(NamedTuple):
    """A model and its data, as the loop takes them; the arrays are views of the data.

    Args:
        model: Address of the model.
        data: Address of the data.
        servos: Position, speed and torque that each joint's servo is to reach, (6, 3).
        arm: First of the arm's degrees of freedom.
        qpos: Positions, (nq,).
        qvel: Velocities, (nv,).
        warmstart: Accelerations that the solver begins with, (nv,).
        tree_asleep: Below 0 for a kinematic tree that is awake, (ntree,).
        tree_of_position: The tree that each position belongs to, (nq,).
        forces: Contact force of each sensor, (S, 3) N.
    """

    model: int
    data: int
    servos: Floats
    arm: int
    qpos: Floats
    qvel: Floats
    warmstart: Floats
    tree_asleep: NDArray[np.int32]
    tree_of_position: NDArray[np.intp]
    forces: Floats


@jit
def run_periods(engine: Engine, setpoints: Floats, peaks: Floats, limits: Floats) -> int:
    """Steps through setpoints of the arm, one each, and stops after the step in which a force is above its limit.

    Args:
        engine: The model and its data.
        setpoints: Angle (rad), speed (rad/s) and acceleration (rad/s²) of each joint, (N, 6, 3); the acceleration is
            fed forward as a torque, by the arm's inertia.
        peaks: Largest force so far of each sensor, (S,) N; is raised.
        limits: Of the forces, (S,) N.

    Returns:
        The number of steps if a force stopped them, otherwise 0.
    """
    qdd, torques = np.zeros(len(engine.qvel)), np.zeros(len(engine.qvel))
    for n in range(len(setpoints)):
        for joint in range(len(engine.servos)):
            qdd[engine.arm + joint] = setpoints[n, joint, 2]
        _multiply_by_inertia(engine.model, engine.data, torques.ctypes.data, qdd.ctypes.data)
        for joint in range(len(engine.servos)):
            engine.servos[joint, 0] = setpoints[n, joint, 0]
            engine.servos[joint, 1] = setpoints[n, joint, 1]
            engine.servos[joint, 2] = torques[engine.arm + joint]
        _step(engine.model, engine.data)
        _round(engine)
        if _is_above(engine.forces, peaks, limits):
            return n + 1
    return 0


@jit
def _round(engine: Engine) -> None:
    """Rounds the last bits away: contacts would make them larger. A sleeping thing stays: a change would wake it."""
    for i in range(len(engine.qpos)):
        if engine.tree_asleep[engine.tree_of_position[i]] < 0:
            engine.qpos[i] = np.rint(engine.qpos[i] * _PLACE) / _PLACE
    for i in range(len(engine.qvel)):
        engine.qvel[i] = np.rint(engine.qvel[i] * _VELOCITY) / _VELOCITY
        engine.warmstart[i] = np.rint(engine.warmstart[i] * _ACCELERATION) / _ACCELERATION


@jit
def _is_above(forces: Floats, peaks: Floats, limits: Floats) -> bool:
    """Raises the peaks to the forces; whether one of these is above its limit."""
    above = False
    for i in range(len(peaks)):
        force = np.sqrt(forces[i, 0] ** 2 + forces[i, 1] ** 2 + forces[i, 2] ** 2)
        peaks[i] = max(peaks[i], force)
        above |= force > limits[i]
    return above
