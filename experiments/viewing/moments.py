"""The times that a replay shows."""

import math


def moments(span: tuple[float, float], interval: float) -> list[float]:
    """Times from the begin of a span on, one interval apart, and its end; s."""
    begin, end = span
    count = math.ceil((end - begin) / interval - 1e-6)
    return [*(begin + number * interval for number in range(count)), end]
