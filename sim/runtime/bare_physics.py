"""An experiment's commands again, with nothing but the engine: the floor of what an experiment takes."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.errors import DivergenceError
from sim.runtime.world import World

SAME_PLACE = 1e-3  # m: without the rounding of `World`, the parts end within this of where they were


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """What was commanded, and where it has led.

    Attributes:
        controls: the engine's controls at every step, (N, nu).
        p_WO: the parts at the end, (P, 3) m.
    """

    controls: NDArray[np.float64]
    p_WO: NDArray[np.float64]


def record(world: World, run: Callable[[], object]) -> Recording:
    """What `run` commands in a world from its reset on."""
    rows: list[NDArray[np.float64]] = []
    world.on_step = lambda: rows.append(world.data.ctrl.copy())
    try:
        run()
    finally:
        world.on_step = None
    return Recording(np.array(rows), _places(world))


def replay(world: World, X_WO: Sequence[Pose], recording: Recording) -> float:
    """Process time, s, of the commands alone, after a reset to the same poses.

    Raises:
        DivergenceError: a part ends elsewhere.
    """
    model, data, control = world.mj_model, world.data, world.data.ctrl
    world.reset(X_WO)
    begin = time.process_time()
    for row in recording.controls:
        control[:] = row
        mujoco.mj_step(model, data)
    worked = time.process_time() - begin
    off = float(np.abs(_places(world) - recording.p_WO).max())
    if off > SAME_PLACE:
        raise DivergenceError(
            f"expected the parts where they were to {1000 * SAME_PLACE:g} mm, got {1000 * off:.1f} mm"
        )
    return worked


def _places(world: World) -> NDArray[np.float64]:
    return np.array([world.X_WO(part).translation for part in range(world.parts)])
