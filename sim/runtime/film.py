"""Where everything was at every step of a run, to take pictures of it later."""

from bisect import bisect_right
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from sim.runtime.world import World


class Film:
    """The positions of a world's joints after every step. Single precision: it is for pictures only."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._positions: list[NDArray[np.float32]] = []

    @property
    def duration(self) -> float:
        """Time of the last step, s."""
        return self._times[-1] if self._times else 0.0

    def at(self, time: float) -> NDArray[np.float32]:
        """The positions at a time (s), those of the last step up to it; before the first step, the first's.

        Raises:
            LookupError: nothing was recorded.
        """
        if not self._times:
            raise LookupError("expected at least one step on the film, got none")
        return self._positions[max(0, bisect_right(self._times, time + 1e-6) - 1)]

    @contextmanager
    def recording(self, world: World) -> Iterator[None]:
        """Records the steps that are made in its block; the steps themselves are the same, bit for bit.

        Who was told of steps before is told of them still.
        """

        def keep() -> None:
            self._times.append(world.time)
            self._positions.append(world.data.qpos.astype(np.float32))
            if before is not None:
                before()

        before, world.on_step = world.on_step, keep
        try:
            yield
        finally:
            world.on_step = before
