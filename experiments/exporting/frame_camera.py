"""A wrist camera that also says where it truly was at each frame, and what it showed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """What belongs to a frame beside what the robot is told.

    Attributes:
        X_WC: true pose of the camera in the world.
        rgb: the picture, (H, W, 3); None if it was not asked for.
        depth: z-depth, (H, W) m; None if it was not asked for.
    """

    X_WC: Pose
    rgb: NDArray[np.uint8] | None
    depth: NDArray[np.float32] | None


class FrameCamera(WristCamera):
    """Implements what a station takes frames with.

    Args:
        world: the cell.
        rgb: whether to take pictures.
        depth: whether to take depth images.
    """

    def __init__(self, world: World, *, rgb: bool, depth: bool) -> None:
        super().__init__(world)
        self._of_world, self._rgb, self._depth = world, rgb, depth
        self._newest: Taken | None = None

    @property
    def newest(self) -> Taken:
        """What belongs to the newest frame.

        Raises:
            LookupError: there has been none.
        """
        if self._newest is None:
            raise LookupError("no frame has been taken yet")
        return self._newest

    def instance_ids(self, X_CO_true: Sequence[Pose]) -> NDArray[np.int8]:
        """See `WristCamera`; it is called once for each frame, at its moment."""
        self._newest = Taken(
            self._of_world.X_WC(), self.rgb() if self._rgb else None, self.depth() if self._depth else None
        )
        return super().instance_ids(X_CO_true)
