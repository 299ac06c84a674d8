"""Several comparisons in one table: p values that hold for all of them together."""

from collections.abc import Sequence

import numpy as np


def holm(p_values: Sequence[float]) -> list[float]:
    """The adjusted p values, in the same order: the chance of any false finding stays below the level (Holm, 1979).

    The k-th smallest of m is multiplied by m - k + 1, and is at least as large as those before it and at most 1.
    It holds however the comparisons depend on one another.

    Args:
        p_values: Of each comparison, in [0, 1].
    """
    p = np.asarray(p_values, dtype=np.float64)
    if p.ndim != 1 or not ((p >= 0) & (p <= 1)).all():
        raise ValueError(f"expected p values in 0..1, got {list(p_values)}")
    order = np.argsort(p, kind="stable")
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)), 1.0)
    return [float(value) for value in adjusted]
