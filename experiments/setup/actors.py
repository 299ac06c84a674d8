"""The options that name estimators, of the package or from elsewhere."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cell.guards import TIME_LIMIT
from experiments.errors import UsageError

if TYPE_CHECKING:
    from experiments.setup.error_models import ErrorModel

MOST_TIME = 86_400.0  # s; the operating system's alarm takes no more than some years


@dataclass(frozen=True)
class Actors:
    """The estimators."""

    estimator: str = "noisy"
    """noisy: masks and poses with realistic errors; oracle: exact ones, the ceiling; networks: trained ones that see
    pictures; replay: those of --recorded; or your own as package.module:Class."""
    recorded: Path | None = None
    """Folder whose estimates --estimator replay repeats: written by compare or run, or BOP files."""
    networks: Path | None = None
    """Folder of trained networks for --estimator networks, as graspcell train writes it; those that come along for the
    part by default."""
    gap: str = "none"
    """Domain gap of the noisy estimates. none: errors as on rendered images; fitted: errors as on real ones, as
    the paper's robot without UQ suggests, another draw for every experiment; or a gap.json of graspcell gap."""
    time_limit: float = TIME_LIMIT
    """Seconds of the wall clock that an estimator, a method or the policy has per call."""

    def check(self, part: str) -> None:
        """Raises UsageError unless the estimators exist and can be had for a part, which exists."""
        from experiments.setup.estimators import check_estimator, check_networks

        if not 0 < self.time_limit <= MOST_TIME:
            raise UsageError(f"expected --time-limit above 0 s and at most {MOST_TIME:g} s, got {self.time_limit:g}")
        check_estimator(self.estimator, self.recorded, self.networks)
        if self.estimator == "networks":
            check_networks(self.networks, part)
        if self.gap != "none" and self.estimator != "noisy":
            raise UsageError(f"expected --estimator noisy with --gap {self.gap}, got {self.estimator}")
        self.noise(part, 0)

    @property
    def are_networks(self) -> bool:
        """Whether the estimators are trained networks, which look at pictures and tell their correspondences."""
        from experiments.setup.estimators import LEARNED

        return self.estimator == LEARNED

    def check_method(self, name: str) -> None:
        """Raises UsageError if a method of the library needs correspondences that the estimators do not tell."""
        from experiments.setup.estimators import KNOWN
        from maskval import NETWORK_METHODS, needs_of

        judges_points = name in NETWORK_METHODS and needs_of(NETWORK_METHODS[name]()).correspondences
        if judges_points and self.estimator in KNOWN and not self.are_networks:
            raise UsageError(
                f"expected --estimator networks with {name}, which judges correspondences, got {self.estimator}"
            )

    def noise(self, part: str, experiment: int) -> "ErrorModel":
        """The changes of an experiment to the error model of its part, which exists.

        Raises:
            UsageError: there is no such gap for the part.
        """
        from experiments.setup.error_models import error_model_of

        return () if self.gap == "none" else error_model_of(part, self.gap, experiment)
