"""Error models of experiments on real images: an accepted parameter set and a draw of the domain gap."""

import json
from collections.abc import Sequence
from dataclasses import fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from maskval.inputs.spelling import shown
from sim.errors import NoiseFileError
from sim.model.parts import load_part
from sim.networks.domain_gap import BASE_REACH, Gap, Reach
from sim.networks.noise_model import PartNoise, load_noise

_ENSEMBLES = files("sim") / "assets" / "noise"
_GAPS = files("experiments") / "presets" / "gaps"

ErrorModel = tuple[tuple[str, float], ...]  # parameters that differ from the part's noise file, by "section.key"


def error_model(rendered: PartNoise, member: dict[str, float], gap: Gap, reach: Reach = BASE_REACH) -> ErrorModel:
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


def error_model_of(part: str, gap: str, index: int, reach: Reach = BASE_REACH) -> ErrorModel:
    """The index-th error model of a part: accepted sets and draws of the gap are repeated in turn.

    Args:
        part: The part's name or file.
        gap: See `load_gaps`.
        index: Of the error model, from 0.
        reach: How much of the gap S2 and the detector feel.

    Raises:
        UsageError: there is no such gap for this part.
    """
    rendered, members, gaps = _draws(part, gap)
    return error_model(rendered, cycled(members, index), cycled(gaps, index), reach)


@cache
def _draws(part: str, gap: str) -> tuple[PartNoise, list[dict[str, float]], list[Gap]]:
    model = load_part(part)
    rendered = load_noise(model.noise)
    members, gaps = load_ensemble(model.noise, rendered), load_gaps(model.part.name, gap)
    for index, draw in enumerate(gaps):
        try:
            for member in members:
                rendered.changed(dict(error_model(rendered, member, draw)))
        except NoiseFileError as error:
            raise UsageError(f"the gap {gap}: draws[{index}] leads to errors that cannot be: {error}") from error
    return rendered, members, gaps


def cycled(items: Sequence[Any], index: int) -> Any:
    """The index-th of items that are repeated in turn."""
    return items[index % len(items)]


def load_gaps(part: str, source: str) -> list[Gap]:
    """Draws of a part's gap.

    Args:
        part: The part's name.
        source: "none", "fitted" for those that come with the package, or a gap.json of `graspcell gap`.

    Raises:
        UsageError: there are none for this part, or the file is malformed.
    """
    if source == "none":
        return [Gap()]
    path = Path(str(_GAPS / f"{part}.json")) if source == "fitted" else Path(source)
    try:
        found = json.loads(read_input_text(path))
        if found["object"] != part:
            raise UsageError(f"the gap {source} is of {found['object']}, but the part is {part}")
        gaps = [_gap(f"draws[{index}]", row) for index, row in enumerate(found["draws"])]
    except InvalidFileError as error:
        raise UsageError(
            f"no gap for {part} in {source}: expected none, fitted, or a gap.json of `graspcell gap --part {part}`: "
            f"{error}"
        ) from error
    except KeyError as missing:
        raise UsageError(f"the gap {source} is malformed: the key {missing} is missing") from missing
    except (ValueError, TypeError, RecursionError) as error:
        raise UsageError(f"the gap {source} is malformed: {error}") from error
    if not gaps:
        raise UsageError(f"the gap {source} holds no draws")
    return gaps


def _gap(key: str, row: Any) -> Gap:
    names = [entry.name for entry in fields(Gap)]
    if not isinstance(row, dict) or set(row) != set(names):
        raise ValueError(f"expected {key} with {' and '.join(names)}, got {shown(row)}")
    for name, value in row.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"expected {key}.{name} to be a number, got {shown(value)}")
    return Gap(**row)
