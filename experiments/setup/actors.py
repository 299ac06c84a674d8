"""The options that name estimators and a policy, of the package or from elsewhere."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from cell.guards import TIME_LIMIT
from experiments.errors import UsageError
from experiments.setup.names import OWN, POLICY_NAMES

if TYPE_CHECKING:
    from experiments.setup.error_models import ErrorModel
    from experiments.setup.thresholds import Thresholds


@dataclass(frozen=True)
class Actors:
    """The estimators and the policy."""

    estimator: str = "noisy"
    """noisy: masks and poses with realistic errors; oracle: exact ones, the ceiling; replay: those of --recorded; or
    your own as package.module:Class."""
    recorded: Path | None = None
    """Folder whose estimates --estimator replay repeats: written by compare or run, or BOP files."""
    gap: str = "none"
    """Domain gap of the noisy estimates. none: errors as on rendered images; fitted: errors as on real ones, as
    the paper's robot without UQ suggests, another draw for every experiment; or a gap.json of graspcell gap."""
    policy: Annotated[
        str | None,
        tyro.conf.arg(
            help=f"{', '.join(POLICY_NAMES)}, {OWN}; without it each method has its own: always for none, threshold "
            "for the others."
        ),
    ] = None
    time_limit: float = TIME_LIMIT
    """Seconds of the wall clock that an estimator, a method or the policy has per call."""

    def check(self, part: str, method: str, thresholds: "Thresholds") -> None:
        """Raises UsageError unless all of them exist; part and method do."""
        from cell.layout import Layout
        from experiments.setup.estimators import check_estimator
        from experiments.setup.methods import known_method
        from experiments.setup.policies import make_policy
        from sim.model.parts import load_part

        if not 0 < self.time_limit < math.inf:
            raise UsageError(f"expected --time-limit above 0 s, got {self.time_limit:g}")
        check_estimator(self.estimator, self.recorded)
        if self.gap != "none" and self.estimator != "noisy":
            raise UsageError(f"expected --estimator noisy with --gap {self.gap}, got {self.estimator}")
        self.noise(part, 0)
        known = load_part(part).part
        make_policy(self.policy, known_method(method, known, thresholds), known, Layout(), thresholds.refine)

    def noise(self, part: str, experiment: int) -> "ErrorModel":
        """The changes of an experiment to the error model of its part, which exists.

        Raises:
            UsageError: there is no such gap for the part.
        """
        from experiments.setup.error_models import error_model_of

        return () if self.gap == "none" else error_model_of(part, self.gap, experiment)
