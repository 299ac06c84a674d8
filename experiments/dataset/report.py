"""The paper's dataset tables as text, ours beside the paper's."""

from collections.abc import Sequence

from experiments.dataset.metrics import Figures
from experiments.dataset.score import Scored
from experiments.results.paper import dataset_figures
from maskval import Measured

_MASK_NAMES = {"ap_50_95": "AP50:95", "ap_50": "AP50", "ar_100": "AR100"}


def format_tables(sets: Sequence[Scored]) -> str:
    """All tables; percentages but for Spearman and u, which are in [-1, 1] and [0, 1]."""
    lines = ["95 % intervals in brackets, the paper's value after the bar; - where it is undefined"]
    lines += [
        "",
        "detector, %",
        f"{'object':10} {'images':>7} " + " ".join(f"{name:>29}" for name in _MASK_NAMES.values()),
    ]
    for one in sets:
        paper = dataset_figures(one.object)
        cells = (_cell(one.mask[name], paper.get(("mask", name)), 100.0) for name in _MASK_NAMES)
        lines.append(f"{one.object:10} {one.images:7} " + " ".join(cells))
    width = max(13, *(len(method) for one in sets for method in one.methods))
    lines += [
        "",
        "uncertainty",
        f"{'object':10} {'method':{width}} {'Spearman':>29} {'AUC AR, %':>29} {'u_t,g at 15 mm':>29}",
    ]
    for one in sets:
        paper = dataset_figures(one.object)
        for method, row in one.methods.items():
            cells = (
                _cell(
                    row[name],
                    paper.get((method, name)),
                    100.0 if name == "auc_ar" else 1.0,
                    1 if name == "auc_ar" else 3,
                )
                for name in row
            )
            lines.append(f"{one.object:10} {method:{width}} " + " ".join(cells))
    lines += ["", "poses"]
    for one in sets:
        median = one.median_mdd_m
        ap, ar = (_number(rate, 100.0, 1) for rate in one.unfiltered)
        lines.append(
            f"{one.object:10} {one.poses} poses, {one.parts} parts; median MDD {_own(median, 1000.0, 2)} mm; "
            f"all kept, AP at 15 mm is {ap} %, AR {ar} %"
        )
    return "\n".join(lines)


def format_alternatives(found: dict[str, dict[str, dict[str, Figures]]]) -> str:
    """What every other counting rule would give, by object."""
    lines = ["", "by another rule", f"{'object':10} {'rule':27} {'method':13} Spearman AUC AR, %  u_t,g"]
    for name, rules in found.items():
        for rule, methods in rules.items():
            for method, one in methods.items():
                lines.append(
                    f"{name:10} {rule:27} {method:13} {_number(one.spearman, 1.0, 3):>8} "
                    f"{_number(one.auc_ar, 100.0, 1):>9} {_number(one.u_tg, 1.0, 3):>6}"
                )
    return "\n".join(lines)


def _cell(measured: Measured, paper: float | None, unit: float, digits: int = 1) -> str:
    """The value, its interval and the paper's value, in a column's width."""
    return f"{_own(measured, unit, digits):>21} | {_number(paper, unit, digits):>5}"


def _own(measured: Measured, unit: float, digits: int) -> str:
    """The value and its interval, if it has one."""
    value = _number(measured.value, unit, digits)
    if measured.interval is None:
        return value
    low, high = measured.interval
    return f"{value} [{_number(low, unit, digits)}, {_number(high, unit, digits)}]"


def _number(value: float | None, unit: float, digits: int) -> str:
    return "-" if value is None else f"{unit * value:.{digits}f}"
