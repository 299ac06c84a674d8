"""Figures of `graspcell dataset`, as the paper's; needs the extra `graspcell[figures]`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.dataset.metrics import ERRORS_M
from experiments.dataset.score import Scored
from experiments.errors import UsageError
from experiments.results.files import replacing

_SHOWN_M = 0.1  # larger errors are drawn as this one: a few metres would hide all others


def check_matplotlib() -> None:
    """Asks for matplotlib before any work is done.

    Raises:
        UsageError: it is not installed.
    """
    try:
        import matplotlib.figure  # noqa: F401, PLC0415  # an extra
    except ImportError:
        raise UsageError("figures need matplotlib; expected the extra: pip install 'graspcell[figures]'") from None


def draw_curves(sets: Sequence[Scored], path: Path) -> None:
    """AR, ARU and AR* over the error threshold, one panel per part."""
    figure = _figure(1.8 + 4.6 * len(sets))  # the legend beside the panels
    panels = figure.subplots(1, len(sets), sharey=True, squeeze=False)[0]
    for axes, one in zip(panels, sets, strict=True):
        axes.plot(1e3 * ERRORS_M, 100 * next(iter(one.curves.values())).ar_star, color="k", label="AR*")
        drawn = [method for method in one.curves if method != "oracle-mdd"]  # its AR is AR*
        for method, color in zip(drawn, colors(len(drawn)), strict=True):
            curve = one.curves[method]
            axes.plot(1e3 * ERRORS_M, 100 * curve.ar, color=color, label=f"{method} AR")
            axes.plot(1e3 * ERRORS_M, 100 * curve.aru, color=color, linestyle=":", label=f"{method} ARU")
        axes.set(title=one.object, xlabel="error threshold $e_t$, mm", ylim=(-2, 102))
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("recall at AP ≥ 99 %, %")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right center", fontsize="small")
    with replacing(path) as file:
        figure.savefig(file, format="png", dpi=110)


def draw_errors(sets: Sequence[Scored], path: Path) -> None:
    """Violins of the pose error, with median and quartiles; parts without poses are left out."""
    drawn = [one for one in sets if len(one.mdd_m)]
    figure = _figure(2.5 + 1.2 * len(drawn))
    axes = figure.add_subplot()
    for place, one in enumerate(drawn):
        errors_mm = 1e3 * np.minimum(one.mdd_m, _SHOWN_M)
        axes.violinplot([errors_mm], [place], widths=0.8, showextrema=False)
        low, middle, high = np.quantile(errors_mm, (0.25, 0.5, 0.75))
        axes.vlines(place, low, high, color="k", linewidth=5)
        axes.plot(place, middle, "o", color="white", markersize=4)
    axes.set(ylabel=f"pose error MDD, mm (at most {1e3 * _SHOWN_M:g})", ylim=(0, None))
    axes.set_xticks(range(len(drawn)), [one.object for one in drawn])
    axes.grid(axis="y", alpha=0.3)
    with replacing(path) as file:
        figure.savefig(file, format="png", dpi=110)


def colors(count: int) -> list[str]:
    """As many different colours."""
    from matplotlib import colormaps  # noqa: PLC0415  # an extra
    from matplotlib.colors import to_hex  # noqa: PLC0415

    return [to_hex(color) for color in colormaps["tab20"](range(count))]


def _figure(width: float) -> Any:
    from matplotlib.figure import Figure  # noqa: PLC0415  # an extra

    return Figure(figsize=(width, 3.8), layout="constrained")
