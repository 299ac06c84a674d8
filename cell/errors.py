"""What can go wrong in the cell's description of itself; expected failures are outcomes or None, not exceptions."""


class CellError(Exception):
    """Base of every error that this package raises."""


class KinematicsInputError(CellError, ValueError):
    """Joint angles or poses of the wrong shape, or not finite."""


class InvalidTrajectoryError(CellError, ValueError):
    """A trajectory, its speed preset or a request for one that contradicts itself or the arm's limits."""


class EstimatorError(CellError, RuntimeError):
    """A detector, a pose estimator or an uncertainty method raised, took too long, or returned an invalid estimate."""


class UncertaintyError(EstimatorError):
    """An uncertainty method raised, took too long, or returned something else than an u in [0, 1] per detection."""


class PolicyError(CellError, RuntimeError):
    """A policy raised, took too long, or decided what cannot be."""


class LayoutError(CellError, ValueError):
    """A layout in which the cycle cannot work: a view out of reach, or more parts than slots."""
