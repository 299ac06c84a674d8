"""An error model for a part that no table speaks of: the fitted ones, scaled by the part's diameter."""

import numpy as np

from maskval import Mesh
from sim.model.parts import load_part, part_names
from sim.networks.noise_model import SECTIONS, PartNoise, bounds, load_noise, noise_text
from sim.parts.turns import Turn

LENGTHS = ("pose.lateral_mm", "pose.gross_lateral_mm", "pose.gross_depth_mm")  # they grow with the part
_HEAD = """\
# Error model of the estimators for {name}: an assumption, not a fit. How networks see this part is not known.
# Each value is the geometric mean (correlations: the mean) of those fitted for {fitted}.
# Lengths are scaled by the diameter, {diameter:.0f} mm, over that of each of these parts.
# To fit it to dataset figures of the part: `graspcell calibrate --part FILE.toml --targets FILE.toml`.
"""


def scaled_noise(name: str, mesh: Mesh, turns: tuple[Turn, ...]) -> str:
    """The text of the error model's file.

    Args:
        name: the part's.
        mesh: the part's.
        turns: its symmetries: half a turn that is one of them is no error.
    """
    fitted = {one: load_noise(one) for one in part_names()}
    diameters = {one: load_part(one).part.mesh.diameter for one in fitted}
    lines = _HEAD.format(name=name, fitted=", ".join(fitted), diameter=1000 * mesh.diameter).splitlines()
    values: dict[str, float] = {}
    for section, record in SECTIONS.items():
        for key, entry in record.__dataclass_fields__.items():
            if entry.metadata:
                values[f"{section}.{key}"] = _mean(f"{section}.{key}", fitted, diameters, mesh.diameter)
    axis = _flip_axis(turns)
    section = ""
    for line in noise_text(part_names()[0]).splitlines():
        if line.startswith("["):
            section = line[1 : line.index("]")]
        key = line.partition(" = ")[0]
        comment = line.rpartition("# ")[2].rpartition("; ")[0]
        if (parameter := f"{section}.{key}") in values:
            lines.append(f"{f'{key} = {values[parameter]:.4g}':40}# {comment}; assumed")
        elif key == "flip_axis":
            lines.append(
                f"{f'flip_axis = {axis}':40}# 1; unit vector in O about which half turns are confused; assumed"
            )
        elif line.startswith("["):
            lines += ["", line]
    return "\n".join(lines) + "\n"


def _mean(name: str, fitted: dict[str, PartNoise], diameters: dict[str, float], diameter: float) -> float:
    numbers = []
    for one, noise in fitted.items():
        value = noise.number(name)
        numbers.append(value * diameter / diameters[one] if name in LENGTHS else value)
    low, _ = bounds(name)
    if low < 0 or min(numbers) <= 0:
        return float(np.mean(numbers))
    return float(np.exp(np.mean(np.log(numbers))))


def _flip_axis(turns: tuple[Turn, ...]) -> list[float]:
    """An axis of O about which half a turn is an error: z, if that is no symmetry."""
    symmetric = [turn.axis.axis_O for turn in turns if turn.fold % 2 == 0]
    for axis in np.eye(3)[[2, 0, 1]]:
        if not any(abs(axis @ other) > 0.99 for other in symmetric):
            return [float(x) for x in axis]
    return [0.0, 0.0, 1.0]
