"""How well simulated results agree with real ones: over the cells of a table, in one number each."""

import numpy as np
from numpy.typing import ArrayLike


def pearson(simulated: ArrayLike, real: ArrayLike) -> float | None:
    """Pearson's correlation, in [-1, 1]; None where one of them does not vary.

    Args:
        simulated: Results of N cells, (N,).
        real: The same cells' real results, (N,).
    """
    a, b = (np.asarray(values, dtype=np.float64) for values in (simulated, real))
    if len(a) < 2 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    return float(np.corrcoef(a, b)[0, 1])


def mmrv(simulated: ArrayLike, real: ArrayLike) -> float:
    """Mean maximum rank violation, in the unit of the results, 0 or more; low is good (Li et al. 2024, SIMPLER).

    A pair of cells that the simulation ranks otherwise than reality costs their real difference; each cell counts its
    costliest pair.

    Args:
        simulated: Results of N cells, (N,), N at least 1.
        real: The same cells' real results, (N,).
    """
    a, b = (np.asarray(values, dtype=np.float64) for values in (simulated, real))
    real_gap = b[:, None] - b[None, :]
    violated = ((a[:, None] < a[None, :]) != (real_gap < 0)) & ~np.eye(len(a), dtype=bool)
    return float((violated * np.abs(real_gap)).max(axis=1).mean())
