"""Statistics of a dataset's features, as LeRobot keeps them for every episode and for all."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Stats = dict[str, NDArray[Any]]  # min, max, mean, std, count and the quantiles q01 to q99

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}


def stats_of(values: NDArray[Any]) -> Stats:
    """The statistics of N values or vectors, (N,) or (N, D): each of shape (D,), D = 1 for values; count of (1,)."""
    samples = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
    return {
        "min": samples.min(axis=0),
        "max": samples.max(axis=0),
        "mean": samples.mean(axis=0),
        "std": samples.std(axis=0),
        "count": np.array([len(samples)]),
        **{name: np.quantile(samples, share, axis=0) for name, share in _QUANTILES.items()},
    }


def stats_of_pictures(pictures: Sequence[NDArray[np.uint8]]) -> Stats:
    """The statistics of pictures, (H, W, 3) each, per channel in [0, 1]: of shape (3, 1, 1); they count pictures."""
    found = stats_of(np.concatenate([picture.reshape(-1, 3) for picture in pictures]) / 255.0)
    shaped = {name: value.reshape(3, 1, 1) for name, value in found.items() if name != "count"}
    return {**shaped, "count": np.array([len(pictures)])}


def joined(parts: Sequence[Stats]) -> Stats:
    """The statistics of several sets together; quantiles, which those of the sets do not determine, are averaged."""
    counts = np.array([part["count"][0] for part in parts], dtype=np.float64)

    def averaged(name: str) -> NDArray[np.float64]:
        return np.asarray(np.average([part[name] for part in parts], axis=0, weights=counts))

    mean = averaged("mean")
    squares = [part["std"] ** 2 + (part["mean"] - mean) ** 2 for part in parts]
    return {
        "min": np.min([part["min"] for part in parts], axis=0),
        "max": np.max([part["max"] for part in parts], axis=0),
        "mean": mean,
        "std": np.sqrt(np.average(squares, axis=0, weights=counts)),
        "count": np.array([int(counts.sum())]),
        **{name: averaged(name) for name in _QUANTILES},
    }
