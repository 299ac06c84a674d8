"""The table as text, beside the paper's."""

from collections.abc import Sequence

from experiments.results.paper import ROBOT_TABLE
from experiments.results.table import Cell, Interval

_HEADER = (
    "object",
    "method",
    "AP %",
    "[95 %]",
    "paper",
    "AR %",
    "[95 %]",
    "paper",
    "TP",
    "FP",
    "FN",
    "void",
    "time-outs",
    "s/part",
    "runs",
)
_LEFT = 2  # columns of words; the others are numbers and stand right


def format_table(cells: Sequence[Cell], *, as_paper: bool = True) -> str:
    """The cells as an aligned table: averages over experiments with their intervals.

    Args:
        cells: The rows.
        as_paper: Whether the experiments were the paper's, so that its figures belong beside them.
    """
    rows = [_HEADER, *(_row(cell, as_paper) for cell in cells)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADER))]
    lines = []
    for row in rows:
        padded = [
            text.ljust(width) if column < _LEFT else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(padded).rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join(lines)


def _row(cell: Cell, as_paper: bool) -> tuple[str, ...]:
    paper = ROBOT_TABLE.get((cell.object, cell.method)) if as_paper else None
    runs = str(cell.experiments) + (f" ({cell.failed} failed)" if cell.failed else "")
    return (
        cell.object,
        cell.method,
        _percent(cell.ap),
        _interval(cell.ap_ci),
        _percent(paper[0] if paper else None),
        _percent(cell.ar),
        _interval(cell.ar_ci),
        _percent(paper[1] if paper else None),
        str(cell.tp),
        str(cell.fp),
        str(cell.fn),
        str(cell.void),
        str(cell.timeouts),
        "–" if cell.cycle_time_s is None else f"{cell.cycle_time_s:.1f}",
        runs,
    )


def _percent(rate: float | None) -> str:
    return "–" if rate is None else f"{100 * rate:.1f}"


def _interval(interval: Interval | None) -> str:
    return "–" if interval is None else f"{100 * interval[0]:.0f}–{100 * interval[1]:.0f}"
