"""Two methods on the same parts: the exact test of McNemar, Tango's interval, the odds of the discordant parts."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
import scipy
from numpy.typing import ArrayLike
from scipy.special import ndtri

from maskval import proportion_interval

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PairedParts:
    """In how many parts two methods succeeded; each part met both.

    Attributes:
        both: both succeeded.
        first_only: the first method alone.
        second_only: the second method alone.
        neither: neither succeeded.
    """

    both: int
    first_only: int
    second_only: int
    neither: int

    def __post_init__(self) -> None:
        if min(self.both, self.first_only, self.second_only, self.neither) < 0 or self.parts == 0:
            raise ValueError(f"expected counts >= 0 and at least one part, got {self}")

    @property
    def parts(self) -> int:
        """Number of parts that met both methods."""
        return self.both + self.first_only + self.second_only + self.neither

    @property
    def discordant(self) -> int:
        """Number of parts in which just one method succeeded."""
        return self.first_only + self.second_only

    @property
    def difference(self) -> float:
        """The first method's share of successes less the second's, in [-1, 1]."""
        return (self.first_only - self.second_only) / self.parts


def count_parts(first: ArrayLike, second: ArrayLike) -> PairedParts:
    """The four counts.

    Args:
        first: Whether the first method succeeded in each part, (N,) of bool, N >= 1.
        second: Whether the second did, on the same parts in the same order.
    """
    a, b = np.asarray(first), np.asarray(second)
    if a.dtype != np.bool_ or b.dtype != np.bool_ or a.ndim != 1 or a.shape != b.shape:
        raise ValueError(f"expected two (N,) of bool, got {a.shape} of {a.dtype} and {b.shape} of {b.dtype}")
    return PairedParts(*(int(np.count_nonzero(cell)) for cell in (a & b, a & ~b, ~a & b, ~(a | b))))


def mcnemar_p(parts: PairedParts) -> float:
    """Two-sided p of equal rates, by the exact test of McNemar (1947); 1 without discordant parts.

    Right if parts are independent of one another. Those of one experiment or world need not be: then `sign_flip_p`
    holds, and this one may be too small.
    """
    if parts.discordant == 0:
        return 1.0
    return float(scipy.stats.binomtest(parts.first_only, parts.discordant, 0.5).pvalue)


def tango_interval(parts: PairedParts, level: float = 0.95) -> Interval:
    """The two-sided score interval of `PairedParts.difference`, in [-1, 1], by Tango (Stat. Med. 17, 1998, 891-908).

    The differences δ for which |T(δ)| <= z, where z is the normal quantile, and for n parts, b in which the first
    method alone succeeded and c in which the second alone did,

        T(δ) = (b - c - n δ) / sqrt(n (2 q + δ (1 - δ))),

    with q for the second method's share of discordant parts that is likeliest if δ is true. Never without width, also
    without discordant parts. As for `mcnemar_p`, parts are taken to be independent.

    Args:
        parts: The counts.
        level: Confidence level, in (0, 1).
    """
    _check_level(level)
    z = float(ndtri((1 + level) / 2))
    return (
        _root(lambda delta: _score(parts, delta) - z, -1.0, parts.difference),
        _root(lambda delta: _score(parts, delta) + z, 1.0, parts.difference),
    )


def discordant_odds(parts: PairedParts, level: float = 0.95) -> tuple[float, Interval] | None:
    """How many parts the first method alone places for each that the second alone does, and the interval of that.

    The conditional odds ratio of paired proportions, in [0, inf]. The exact interval follows from Clopper and Pearson's
    of the first method's share of the discordant parts. None without any.

    Args:
        parts: The counts.
        level: Confidence level, in (0, 1).
    """
    interval = proportion_interval(parts.first_only, parts.discordant, level)
    if interval is None:
        return None
    low, high = interval
    return _odds(parts.first_only / parts.discordant), (_odds(low), _odds(high))


def _score(parts: PairedParts, delta: float) -> float:
    """Tango's T(δ), the standardised distance of the observed difference from δ, in (-1, 1)."""
    n, b, c = parts.parts, parts.first_only, parts.second_only
    linear = (2 * n - b + c) * delta - b - c
    constant = c * delta * (1 - delta)  # q solves 2 n q² + linear q - constant = 0
    root = sqrt(max(linear**2 + 8 * n * constant, 0.0))
    q = 2 * constant / (linear + root) if linear > 0 else (root - linear) / (4 * n)  # neither form cancels digits
    variance = n * (2 * max(q, 0.0) + delta * (1 - delta))
    distance = b - c - n * delta
    if variance > 0:
        return distance / sqrt(variance)
    return 0.0 if distance == 0 else inf if distance > 0 else -inf


def _root(function: Callable[[float], float], end: float, middle: float) -> float:
    """The root between the end of the range and the observed difference, or the end if there is none."""
    inside = end * (1 - 1e-12)
    if abs(middle) >= abs(inside) and middle * end > 0:
        return end
    if function(inside) * function(middle) > 0:
        return end
    return float(scipy.optimize.brentq(function, inside, middle, xtol=1e-12))


def _odds(share: float) -> float:
    return share / (1 - share) if share < 1 else inf


def _check_level(level: float) -> None:
    if not 0 < level < 1:
        raise ValueError(f"expected a level in (0, 1), got {level}")
