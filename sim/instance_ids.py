"""Images that say at each pixel which part it shows, and where a pixel is: needs neither physics nor OpenGL."""

import numpy as np
from numpy.typing import NDArray

PIXEL_CENTER = 0.5  # OpenGL samples pixel i at i + 0.5
NO_INSTANCE = -1  # of a pixel that shows no part


def shown_part(instance_ids: NDArray[np.int8], mask: NDArray[np.bool_]) -> int:
    """The part that most of a mask's pixels show, or `NO_INSTANCE`.

    Args:
        instance_ids: The part that each pixel shows, (H, W); `NO_INSTANCE` where it shows none.
        mask: (H, W).
    """
    shown = instance_ids[mask]
    shown = shown[shown != NO_INSTANCE]
    return int(np.bincount(shown).argmax()) if shown.size else NO_INSTANCE
