"""The table as text, beside the paper's, within the width of a terminal."""

from collections.abc import Sequence

from experiments.results.paired import have_several_policies
from experiments.results.paper import ROBOT_TABLE
from experiments.results.table import Cell, Interval

_COLUMNS = (
    *("object", "method", "AP %", "[95 %]", "first", "AR %", "[95 %] "),
    *("TP", "FP", "on", "FN", "s", "runs", "≈"),
)
_LEFT = ("object", "method")  # words; the other columns are numbers and stand right
_CLOSE = ("[95 %]", "[95 %] ", "FP", "on", "FN")  # columns that belong to the one before them
_LEGEND = {
    "first": "AP of the first attempt for each part",
    "on": "how many parts FP were on",
    "s": "per placed part",
    "≈": "methods that share a letter cannot be told apart in parts placed (5 %, Holm)",
}
_LEFT_OUT = ("s", "runs", "on", "first", "≈")  # in this order, where the table is too wide


def format_table(cells: Sequence[Cell], *, as_paper: bool = True, width: int | None = None) -> str:
    """The cells as an aligned table with its legend: averages over experiments with their intervals.

    Args:
        cells: The rows.
        as_paper: Whether the experiments were the paper's, so that its figures belong beside them.
        width: How many columns a line may have: the least important figures are left out where it has more. Any number
            by default.
    """
    named = have_several_policies({(cell.method, cell.policy) for cell in cells})
    rows = [_row(cell, as_paper, named) for cell in cells]
    columns = [name for name in _COLUMNS if name != "≈" or any(cell.same for cell in cells)]
    for name in (None, *_LEFT_OUT):
        columns = [column for column in columns if column != name]
        lines = _aligned(columns, rows, as_paper)
        if width is None or max(map(len, lines)) <= width:
            break
    lines += [f"{name}: {meaning}" for name, meaning in _LEGEND.items() if name in columns]
    runs = {row["runs"] for row in rows}
    if rows and "runs" not in columns:
        lines.append(f"experiments of each cell: {', '.join(sorted(runs))}")
    return "\n".join(lines)


def _aligned(columns: Sequence[str], rows: Sequence[dict[str, str]], as_paper: bool) -> list[str]:
    header = {name: f"{name} (paper)" if as_paper and name in ("AP %", "AR %") else name.strip() for name in columns}
    table = [header, *rows]
    widths = {name: max(len(row[name]) for row in table) for name in columns}
    lines = []
    for row in table:
        line = ""
        for name in columns:
            between = 0 if name == columns[0] else 1 if name in _CLOSE else 2
            text = row[name]
            line += " " * between + (text.ljust(widths[name]) if name in _LEFT else text.rjust(widths[name]))
        lines.append(line.rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    return lines


def _row(cell: Cell, as_paper: bool, named: bool) -> dict[str, str]:
    """The texts of a cell by column."""
    paper = ROBOT_TABLE.get((cell.object, cell.method), (None, None)) if as_paper else None
    texts = (
        cell.object,
        f"{cell.method} + {cell.policy}" if named else cell.method,
        percent(cell.ap) + (_beside(paper[0]) if paper else ""),
        percents(cell.ap_ci),
        percent(cell.ap_first),
        percent(cell.ar) + (_beside(paper[1]) if paper else ""),
        percents(cell.ar_ci),
        str(cell.tp),
        str(cell.fp),
        "–" if cell.parts_failed is None else str(cell.parts_failed),
        str(cell.fn),
        "–" if cell.cycle_time_s is None else f"{cell.cycle_time_s:.1f}",
        str(cell.experiments) + (f" ({cell.failed} failed)" if cell.failed else ""),
        cell.same or "–",
    )
    return dict(zip(_COLUMNS, texts, strict=True))


def percent(rate: float | None) -> str:
    """A rate in per cent, with one decimal; a dash where it is undefined."""
    return "–" if rate is None else f"{100 * rate:.1f}"


def percents(interval: Interval | None) -> str:
    """The ends of an interval in whole per cent; a dash where it is undefined."""
    return "–" if interval is None else f"{100 * interval[0]:.0f}–{100 * interval[1]:.0f}"


def _beside(rate: float | None) -> str:
    """The paper's figure in the width that keeps the numbers before it in line."""
    return " " * 7 if rate is None else f" {f'({100 * rate:.3g})':6}"
