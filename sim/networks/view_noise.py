"""Random numbers that belong to a view: the same picture gives the same error, another view a partly new one.

A latent is a Gaussian process over views. Every single one is N(0, 1) over seeds; two views of the same part have
latents that correlate by exp(−d²/2), d² = (‖difference of directions‖/ℓ)² + (difference of log distances/ℓ_r)²:
with ℓ = 22° that is .90 at 10° and .40 at 30°. The process is a sum of random Fourier features, so that nothing has to
be remembered: a latent does not depend on how often, in what order or by whom it is asked for.
"""

import math

import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.networks.noise_model import ViewNoise
from sim.networks.random_streams import Streams

FEATURES = 96  # pairs of cosine and sine; one stream's correlation is then within about 1/√96 of the kernel's

Array = NDArray[np.float64]


class RandomField:
    """Independent Gaussian processes over R^D, of mean 0, variance 1 and correlation exp(−‖x − y‖²/2).

    Args:
        rng: what they are drawn from.
        dimensions: D.
        count: how many processes.
        features: pairs of cosine and sine that each is made of.
    """

    def __init__(self, rng: np.random.Generator, dimensions: int, count: int, features: int = FEATURES) -> None:
        self._frequencies = rng.normal(size=(features, dimensions))
        # Cosine and sine with weights of their own: the variance is exactly 1, whatever the frequencies.
        self._weights = rng.normal(size=(count, 2 * features)) / math.sqrt(features)

    def __call__(self, x: Array) -> Array:
        """The processes' values at x, (count,).

        Args:
            x: Where, (D,), in units of the correlation length.
        """
        phases = self._frequencies @ x
        values: Array = self._weights @ np.concatenate((np.cos(phases), np.sin(phases)))
        return values


class ViewLatents:
    """Standard-normal numbers of views, by purpose; what it holds in memory is only what a stream would draw again.

    Args:
        streams: the root of the random numbers.
        noise: the correlation lengths.
    """

    def __init__(self, streams: Streams, noise: ViewNoise) -> None:
        self._streams = streams
        self._direction_length = math.radians(noise.direction_length_deg)
        self._distance_length = noise.distance_length
        self._camera_length = noise.camera_length_mm / 1000.0
        self._fields: dict[tuple[int, str, int], RandomField] = {}

    def of_part(self, purpose: str, count: int, part: int, X_CO: Pose, center_O: Array) -> Array:
        """Latents of the view that a camera has of a part, (count,).

        The view is the direction from the part's middle to the camera, in the part's frame, and the logarithm of
        the distance: not the roll of the camera, nor the place in the image.

        Args:
            purpose: Another purpose has independent latents.
            count: How many; another count has other latents.
            part: The part's number.
            X_CO: The part's true pose.
            center_O: The part's middle, (3,) m.
        """
        p_OC = -(X_CO.rotation.T @ X_CO.translation)
        ray_O = p_OC - center_O
        distance = math.sqrt(float(ray_O @ ray_O))
        x = np.empty(4)
        x[:3] = ray_O / (distance * self._direction_length)
        x[3] = math.log(distance) / self._distance_length
        return self._field(part, purpose, count, 4)(x)

    def of_camera(self, purpose: str, count: int, X_BC: Pose) -> Array:
        """Latents of a whole picture, (count,): of the camera's place and of the direction in which it looks.

        Args:
            purpose: Another purpose has independent latents.
            count: How many; another count has other latents.
            X_BC: The camera's pose.
        """
        x = np.concatenate((X_BC.translation / self._camera_length, X_BC.rotation[:, 2] / self._direction_length))
        return self._field(0, f"camera: {purpose}", count, 6)(x)

    def _field(self, part: int, purpose: str, count: int, dimensions: int) -> RandomField:
        key = (part, purpose, count)
        if key not in self._fields:
            rng = self._streams.generator(part, purpose, count)
            self._fields[key] = RandomField(rng, dimensions, count)
        return self._fields[key]
