"""Images that say at each pixel which part it shows, and where a pixel is: needs neither physics nor OpenGL."""

import numpy as np
from numpy.typing import NDArray

PIXEL_CENTER = 0.5  # OpenGL samples pixel i at i + 0.5
NOTHING = -1  # of a pixel that shows no part


def shown_part(part_numbers: NDArray[np.int8], mask: NDArray[np.bool_]) -> int:
    """The part that most of a mask's pixels show, or `NOTHING`.

    Args:
        part_numbers: The part that each pixel shows, (H, W); `NOTHING` where it shows none.
        mask: (H, W).
    """
    shown = part_numbers[mask]
    shown = shown[shown != NOTHING]
    return int(np.bincount(shown).argmax()) if shown.size else NOTHING
