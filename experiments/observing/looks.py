"""What the wrist camera showed at a look: the picture, and the same with detections and estimated poses."""

import numpy as np
from numpy.typing import NDArray

from cell.records import DecisionRecord
from experiments.observing.drawing import Image
from experiments.observing.overlay import overlaid
from sim.runtime.pictures import FINE_SAMPLES, Pictures
from sim.runtime.world import World

_SAMPLES = FINE_SAMPLES // 6


class Looks:
    """Takes pictures of looks, and keeps the newest; holds an OpenGL context: `close` it.

    Args:
        world: where the experiment runs.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """

    def __init__(self, world: World) -> None:
        self._part, camera = world.part_model.part, world.layout.camera
        self._pictures = Pictures(world, camera.height, camera.width, _SAMPLES)
        self._newest: tuple[DecisionRecord, Image] | None = None

    def picture(self, positions: NDArray[np.floating] | None = None) -> Image:
        """What the wrist camera shows, (H, W, 3).

        Args:
            positions: of the joints, at the moment of the look; as they are now by default.
        """
        return self._pictures.rgb("wrist", positions)

    def overlaid(self, decided: DecisionRecord, positions: NDArray[np.floating] | None = None) -> Image:
        """The same with every detection, the model at its estimated pose, and its u; see `picture`."""
        if self._newest is None or self._newest[0] is not decided:
            self._newest = decided, overlaid(self.picture(positions), decided, self._part)
        return self._newest[1]

    def close(self) -> None:
        """Gives the OpenGL context back."""
        self._pictures.close()
