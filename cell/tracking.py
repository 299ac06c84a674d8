"""The speed of a moving belt, as believed at first and as pairs of looks at the same part then tell."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

BELT_SD: Final = 0.05  # share of the belt's speed by which it may be off at first; a guess
POSE_SD: Final = 0.005  # m by which a pose that is grasped is off along each axis; more than 10 mm often fails
GATE: Final = 3.0  # standard deviations beyond which two looks show two parts, or one of them a wrong pose


class BeltSpeed:
    """A recursive least-squares estimate of one number: each pair of looks counts by how well it tells the speed.

    Attributes:
        speed: m/s.
    """

    def __init__(self, believed: float) -> None:
        self.speed = believed
        self._variance = (BELT_SD * believed) ** 2

    def learn(self, moved: NDArray[np.float64], direction: NDArray[np.float64], duration: float) -> bool:
        """Corrects the speed; returns whether it did, since looks that do not belong together are left out.

        Args:
            moved: from where a part was seen to where it was seen later, (3,) m.
            direction: the belt's, of length 1, (3,).
            duration: s between the two pictures, above 0.
        """
        variance = 2.0 * POSE_SD**2 / duration**2  # of a speed that two poses tell
        off = moved / duration - self.speed * direction
        along = float(off @ direction)
        aside = float(np.linalg.norm(off - along * direction))
        if abs(along) > GATE * np.sqrt(self._variance + variance) or aside > GATE * np.sqrt(variance):
            return False
        gain = self._variance / (self._variance + variance)
        self.speed += gain * along
        self._variance *= 1.0 - gain
        return True
