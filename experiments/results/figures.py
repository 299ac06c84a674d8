"""Figures of results; needs the extra `graspcell[figures]`."""

from collections.abc import Sequence
from pathlib import Path

from experiments.errors import UsageError
from experiments.results.files import replacing
from experiments.results.tolerance_curve import CurvePoint


def draw_tolerance(levels: Sequence[CurvePoint], path: Path) -> None:
    """The share of parts placed over the pose error, with 95 % intervals.

    Raises:
        UsageError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415  # an extra
    except ImportError:
        raise UsageError("figures need matplotlib; expected the extra: pip install 'graspcell[figures]'") from None
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.add_subplot()
    for part in dict.fromkeys(level.object for level in levels):
        curve = [level for level in levels if level.object == part]
        errors = [level.mdd_mm for level in curve]
        axes.plot(errors, [100 * level.rate for level in curve], marker="o", label=part)
        lows, highs = zip(*(level.rate_ci or (0.0, 1.0) for level in curve), strict=True)
        axes.fill_between(errors, [100 * low for low in lows], [100 * high for high in highs], alpha=0.2)
    axes.axvline(15, color="0.5", linestyle=":", label="the paper's $e_t$")
    axes.set(xlabel="pose error MDD, mm", ylabel="parts placed, %", ylim=(-2, 102))
    axes.grid(alpha=0.3)
    axes.legend()
    with replacing(path) as file:
        figure.savefig(file, format="png", dpi=110)
