"""Keeps the cell's clock with the clock on the wall."""

import time

MAX_DELAY = 0.1  # s that are caught up with; after longer pauses time just goes on


class Pace:
    """Waits where the cell is ahead of real time."""

    def __init__(self) -> None:
        self._began: tuple[float, float] | None = None  # when both clocks were together

    def keep(self, now: float) -> None:
        """Waits until the wall has come to a time of the cell, s; one before the last begins anew."""
        wall = time.monotonic()
        if self._began is None or now < self._began[0]:
            self._began = now, wall
        ahead = now - self._began[0] - (wall - self._began[1])
        if ahead < -MAX_DELAY:
            self._began = now, wall
        elif ahead > 0:
            time.sleep(ahead)
