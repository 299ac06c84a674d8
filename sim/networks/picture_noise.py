"""Random numbers that belong to a picture: one share of their variance is new in each, the rest belongs to the view.

With the share s (`view.renewed_share`), a latent is √(1 − s) times the view's, plus √s times a normal number of the
picture. It is N(0, 1), and two pictures of the same view correlate by 1 − s. At s = 0 the view's error is repeated for
ever; at s = 1 "the same view" means the same picture. The picture's number depends on seed, experiment, part, purpose
and frame, not on who asks: detector, S1 and S2 still share what they share.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.networks.noise_model import ViewNoise
from sim.networks.random_streams import Streams
from sim.networks.view_noise import ViewLatents

Array = NDArray[np.float64]


class PictureLatents:
    """Standard-normal numbers of pictures, by purpose.

    Args:
        streams: the root of the random numbers.
        noise: the correlation lengths and the share that is new.
    """

    def __init__(self, streams: Streams, noise: ViewNoise) -> None:
        self._streams, self._share = streams, noise.renewed_share
        self._views = ViewLatents(streams, noise)

    def of_part(self, purpose: str, count: int, part: int, X_CO: Pose, center_O: Array, *, frame: int) -> Array:
        """Latents of a part in one picture, (count,).

        Args:
            purpose: See `ViewLatents.of_part`, as for the next four.
            count: How many.
            part: The part's number.
            X_CO: The part's true pose.
            center_O: The part's middle, (3,) m.
            frame: Index of the picture, ≥ 0.
        """
        of_view = self._views.of_part(purpose, count, part, X_CO, center_O)
        return self._renewed(of_view, part, f"renewed {purpose}", frame)

    def of_camera(self, purpose: str, count: int, X_BC: Pose, *, frame: int) -> Array:
        """Latents of a whole picture, (count,).

        Args:
            purpose: See `ViewLatents.of_camera`, as for the next two.
            count: How many.
            X_BC: The camera's pose.
            frame: Index of the picture, ≥ 0.
        """
        of_view = self._views.of_camera(purpose, count, X_BC)
        return self._renewed(of_view, 0, f"renewed camera: {purpose}", frame)

    def _renewed(self, of_view: Array, part: int, purpose: str, frame: int) -> Array:
        if self._share == 0.0:  # the sum below would be the same bits; this saves the draw
            return of_view
        fresh = self._streams.generator(part, purpose, len(of_view), frame).standard_normal(len(of_view))
        latents: Array = math.sqrt(1.0 - self._share) * of_view + math.sqrt(self._share) * fresh
        return latents
