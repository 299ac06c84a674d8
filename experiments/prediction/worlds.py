"""The worlds of a prediction: each an accepted parameter set with a domain gap; several experiments are run in each."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from experiments.errors import UsageError
from experiments.prediction.gap import BASE_REACH, Gap, Reach, load_gaps
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.thresholds import Thresholds
from sim.errors import NoiseFileError
from sim.model.parts import load_part
from sim.networks.noise_model import PartNoise, load_noise

_ENSEMBLES = files("sim") / "assets" / "noise"

Noise = tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Setting:
    """What all experiments of a prediction share, beside part, method and world.

    Attributes:
        thresholds: of all methods.
        seed: root seed.
        parts: on the belt.
        speed: name of the speed preset.
        refine_distance: m; see `CycleConfig`.
        noise: parameters of the error models that are changed whatever the world.
        reach: how much of the domain gap S2 and the detector feel, in every world.
    """

    thresholds: Thresholds
    seed: int = 0
    parts: int = 8
    speed: str = "ur-default"
    refine_distance: float = 0.40
    noise: Noise = ()
    reach: Reach = BASE_REACH

    def spec(self, part: str, method: str, world: Noise, experiment: int) -> ExperimentSpec:
        """One experiment in one world."""
        return ExperimentSpec(
            part=part,
            method=method,
            estimator="noisy",
            thresholds=self.thresholds,
            speed=self.speed,
            parts=self.parts,
            seed=self.seed,
            experiment=experiment,
            noise=tuple({**dict(world), **dict(self.noise)}.items()),
            refine_distance=self.refine_distance,
        )


def world(rendered: PartNoise, member: dict[str, float], gap: Gap, reach: Reach = BASE_REACH) -> Noise:
    """The parameters that differ from the error model's file: an accepted set's, and the gap on top of them."""
    return tuple((member | gap.noise(rendered.changed(member), reach)).items())


def load_ensemble(noise: str, rendered: PartNoise) -> list[dict[str, float]]:
    """The model itself, which changes nothing, and the other accepted parameter sets that come with it.

    Args:
        noise: The model's name or file.
        rendered: The model.

    Raises:
        UsageError: the file beside the model is malformed.
    """
    path = _ENSEMBLES / f"{noise}.ensemble.json"
    if noise.endswith(".toml") or not path.is_file():
        return [{}]
    try:
        members: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
        for member in members:
            rendered.changed(member)
    except (ValueError, TypeError, AttributeError, NoiseFileError) as error:
        raise UsageError(f"the ensemble of {noise} is malformed: {error}") from error
    return [{}, *members]


def world_of(part: str, gap: str, index: int, reach: Reach = BASE_REACH) -> Noise:
    """The index-th world of a part: accepted sets and draws of the gap begin anew when they are over.

    Args:
        part: The part's name or file.
        gap: See `load_gaps`.
        index: Of the world, from 0.
        reach: How much of the gap S2 and the detector feel.

    Raises:
        UsageError: there is no such gap for this part.
    """
    rendered, members, gaps = _worlds(part, gap)
    return world(rendered, taken(members, index), taken(gaps, index), reach)


@cache
def _worlds(part: str, gap: str) -> tuple[PartNoise, list[dict[str, float]], list[Gap]]:
    model = load_part(part)
    rendered = load_noise(model.noise)
    return rendered, load_ensemble(model.noise, rendered), load_gaps(model.part.name, gap)


def taken(items: Sequence[Any], index: int) -> Any:
    """The index-th of items that begin anew when they are over."""
    return items[index % len(items)]
