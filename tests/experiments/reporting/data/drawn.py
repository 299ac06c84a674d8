"""What a browser fills of an outline."""

import re

import cv2
import numpy as np
from numpy.typing import NDArray


def filled(path: str) -> NDArray[np.bool_]:
    """The pixels inside of an outline by the rule "evenodd", (480, 640)."""
    image = np.zeros((480, 640), dtype=np.uint8)
    rings = [
        np.cumsum(np.array([int(number) for number in re.findall(r"-?\d+", ring)]).reshape(-1, 2), axis=0)
        for ring in path.split("M")[1:]
    ]
    cv2.fillPoly(image, [ring.astype(np.int32) for ring in rings], 1)
    return image.astype(bool)
