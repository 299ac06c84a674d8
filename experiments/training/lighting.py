"""Changes of a picture's light and sharpness, so that a network does not learn them by heart."""

import cv2
import numpy as np
from numpy.typing import NDArray

_GAIN, _TINT, _GAMMA = (0.7, 1.4), (0.9, 1.1), (0.8, 1.25)
_MOST_BLUR_PX, _MOST_NOISE = 0.7, 0.008


def relit(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.float64]:
    """The image in [0, 1], (H, W, 3), with another gain, tint, gamma, blur and noise."""
    gain = rng.uniform(*_GAIN) * rng.uniform(*_TINT, size=3)
    gamma, blur, noise = rng.uniform(*_GAMMA), rng.uniform(0.0, _MOST_BLUR_PX), rng.uniform(0.0, _MOST_NOISE)
    levels = np.arange(256)[:, None] / 255.0
    table = np.clip(gain * levels**gamma, 0.0, 1.0).astype(np.float32)
    lit = np.stack([table[image[..., channel], channel] for channel in range(3)], axis=-1)
    if blur > 0.3:
        lit = cv2.GaussianBlur(lit, (3, 3), blur)
    noisy = lit + noise * rng.standard_normal(image.shape[:2], dtype=np.float32)[..., None]
    clipped: NDArray[np.float64] = np.clip(noisy, 0.0, 1.0).astype(np.float64)
    return clipped
