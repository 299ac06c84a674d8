"""What all experiments of a prediction have in common."""

from dataclasses import dataclass

from experiments.setup.error_models import ErrorModel
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.thresholds import Thresholds
from sim.networks.domain_gap import BASE_REACH, Reach


@dataclass(frozen=True, slots=True)
class Setting:
    """What all experiments of a prediction share, beside part, method and error model.

    Attributes:
        thresholds: of all methods.
        seed: root seed.
        parts: on the belt.
        speed: name of the speed preset.
        refine_distance: m; see `CycleConfig`.
        noise: parameters of the error models that are changed in every error model.
        reach: how much of the domain gap S2 and the detector feel.
    """

    thresholds: Thresholds
    seed: int = 0
    parts: int = 8
    speed: str = "ur-default"
    refine_distance: float = 0.40
    noise: ErrorModel = ()
    reach: Reach = BASE_REACH

    def spec(self, part: str, method: str, error_model: ErrorModel, experiment: int) -> ExperimentSpec:
        """One experiment with one error model."""
        return ExperimentSpec(
            part=part,
            method=method,
            estimator="noisy",
            thresholds=self.thresholds,
            speed=self.speed,
            parts=self.parts,
            seed=self.seed,
            experiment=experiment,
            noise=tuple({**dict(error_model), **dict(self.noise)}.items()),
            refine_distance=self.refine_distance,
        )
