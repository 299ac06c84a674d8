"""The table as text, beside the paper's."""

from collections.abc import Sequence

from experiments.results.paired import have_several_policies
from experiments.results.paper import ROBOT_TABLE
from experiments.results.table import Cell, Interval

_HEADER = ("object", "method", "AP %", "[95 %]", "first", "AR %", "[95 %]", "TP", "FP", "on", "FN", "s", "runs")
_LEFT = 2  # columns of words; the others are numbers and stand right
_CLOSE = (3, 6, 9)  # columns that belong to the one before them
LEGEND = "first: AP of the first attempt for each part; on: how many parts FP were on; s: per placed part"


def format_table(cells: Sequence[Cell], *, as_paper: bool = True) -> str:
    """The cells as an aligned table: averages over experiments with their intervals.

    Args:
        cells: The rows.
        as_paper: Whether the experiments were the paper's, so that its figures belong beside them.
    """
    header = tuple(f"{name} (paper)" if as_paper and name in ("AP %", "AR %") else name for name in _HEADER)
    named = have_several_policies({(cell.method, cell.policy) for cell in cells})
    rows = [header, *(_row(cell, as_paper, named) for cell in cells)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(header))]
    lines = []
    for row in rows:
        line = ""
        for column, (text, width) in enumerate(zip(row, widths, strict=True)):
            gap = 0 if column == 0 else 1 if column in _CLOSE else 2
            line += " " * gap + (text.ljust(width) if column < _LEFT else text.rjust(width))
        lines.append(line.rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join(lines)


def _row(cell: Cell, as_paper: bool, named: bool) -> tuple[str, ...]:
    paper = ROBOT_TABLE.get((cell.object, cell.method), (None, None)) if as_paper else None
    runs = str(cell.experiments) + (f" ({cell.failed} failed)" if cell.failed else "")
    return (
        cell.object,
        f"{cell.method} + {cell.policy}" if named else cell.method,
        _percent(cell.ap) + (_beside(paper[0]) if paper else ""),
        _interval(cell.ap_ci),
        _percent(cell.ap_first),
        _percent(cell.ar) + (_beside(paper[1]) if paper else ""),
        _interval(cell.ar_ci),
        str(cell.tp),
        str(cell.fp),
        "–" if cell.parts_failed is None else str(cell.parts_failed),
        str(cell.fn),
        "–" if cell.cycle_time_s is None else f"{cell.cycle_time_s:.1f}",
        runs,
    )


def _percent(rate: float | None) -> str:
    return "–" if rate is None else f"{100 * rate:.1f}"


def _beside(rate: float | None) -> str:
    """The paper's figure in the width that keeps the numbers before it in line."""
    return " " * 7 if rate is None else f" {f'({100 * rate:.3g})':6}"


def _interval(interval: Interval | None) -> str:
    return "–" if interval is None else f"{100 * interval[0]:.0f}–{100 * interval[1]:.0f}"
