"""What the paper measured (Quentin & Goehring 2024): its robot table and its dataset figures."""

import tomllib
from importlib.resources import files
from pathlib import Path

_DATASET_FIGURES = files("experiments") / "presets" / "calibration"  # beside how near a fit must come to them

# Table IV: 5 experiments of 8 parts per cell.

ROBOT_TABLE: dict[tuple[str, str], tuple[float, float]] = {  # (object, method): (AP, AR)
    ("antenna", "none"): (0.900, 0.825),
    ("antenna", "ensemble-add"): (0.960, 0.500),
    ("antenna", "maskval"): (0.975, 1.000),
    ("handle", "none"): (0.614, 0.500),
    ("handle", "ensemble-add"): (1.000, 0.700),
    ("handle", "maskval"): (1.000, 0.725),
}


def parts_with_figures() -> list[str]:
    """Names of the parts in the paper's dataset tables."""
    return sorted(Path(entry.name).stem for entry in _DATASET_FIGURES.iterdir() if entry.name.endswith(".toml"))


def calibration_text(part: str) -> str:
    """The TOML text with the figures of one of these parts, as targets of a fit, and the fit's priors."""
    return (_DATASET_FIGURES / f"{part}.toml").read_text(encoding="utf-8")


def dataset_figures(part: str) -> dict[tuple[str, str], float]:
    """The paper's dataset figures of a part, by group and figure; none of a part that it does not have."""
    if part not in parts_with_figures():
        return {}
    table = tomllib.loads(calibration_text(part))["target"]
    return {(group, figure): row["value"] for group, rows in table.items() for figure, row in rows.items()}
