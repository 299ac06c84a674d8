"""The one rule that keeps results equal on every processor: what decides, or enters the physics, is rounded first.

Processors differ in the last bit of sines, sums and products. A choice between equals would follow that bit, and
contacts make it larger. So numbers are rounded where they come in; what is left differs by 1e-15 at most, and falls
onto two sides of a step of 1e-9 about once in a million times.
"""

from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

T = TypeVar("T")

DIGITS = 9  # decimals: nanometres, nanoradians; far below what is measured or felt, far above the last bit


def rounded(values: ArrayLike, digits: int = DIGITS) -> NDArray[np.float64]:
    """The values, rounded to decimals; never −0, which has other bits than 0.

    Args:
        values: any shape.
        digits: decimals.
    """
    return np.asarray(np.round(np.asarray(values, dtype=np.float64), digits) + 0.0, dtype=np.float64)


def first_least(items: Iterable[T], key: Callable[[T], float]) -> T:
    """The item of the least key; of those that are equal to `DIGITS` decimals the first.

    Args:
        items: at least one.
        key: what is least.
    """
    return min(items, key=lambda item: round(key(item), DIGITS))
