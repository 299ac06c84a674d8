"""The forest plot: parts placed and attempts failed per experiment, less those of the reference, with intervals."""

from collections.abc import Mapping, Sequence

from experiments.reporting.charts.svg import Plot, figure, linear, steps
from experiments.results.paired import Paired

_ROW, _NAMES, _WIDTH, _LEFT = 26, 96, 190, 12


def forest(pairs: Sequence[Paired], names: Mapping[tuple[str, str], str]) -> str:
    """A figure for each part: a row for each method and policy; empty without a row to show."""
    return "".join(
        _of_object(name, [row for row in pairs if row.object == name], names)
        for name in dict.fromkeys(row.object for row in pairs)
    )


def _of_object(name: str, rows: Sequence[Paired], names: Mapping[tuple[str, str], str]) -> str:
    reference = names[rows[0].reference, rows[0].reference_policy]
    placed = _panel(rows, names, "placed", "parts placed (right is better)")
    failed = _panel(rows, names, "failed", "failed attempts (left is better)")
    runs = f"{rows[0].experiments} experiment{'s' if rows[0].experiments > 1 else ''}"
    return figure(
        f"{name}: per experiment, less {reference}",
        placed + failed,
        f"Dots: mean differences within {runs}; bars: 95 % intervals; the line at 0 is "
        f"{reference}. Blue is better than {reference}, red worse, grey cannot be told.",
        "forest",
    )


def _panel(rows: Sequence[Paired], names: Mapping[tuple[str, str], str], figure_name: str, axis: str) -> str:
    values = [getattr(row, figure_name) for row in rows]
    ends = [end for row in rows for end in (getattr(row, f"{figure_name}_ci") or ())]
    reach = 1.1 * max(0.5, *(abs(value) for value in [*values, *ends]))
    bottom = 10 + _ROW * len(rows)
    box = _NAMES, 4, _NAMES + _WIDTH, bottom
    plot = Plot(box[2] + _LEFT, bottom + 38, linear(-reach, reach, box[0], box[2]), linear(0, bottom, 0, bottom), box)
    plot.x_axis(steps(-reach, reach, 7), axis, lambda tick: f"{tick:+g}" if tick else "0")
    plot.marks.append(f'<path class="zero" d="M{plot.x(0):.1f} {box[1]}V{bottom}"/>')
    for place, row in enumerate(rows):
        y = 4 + _ROW * (place + 0.5)
        value, interval = getattr(row, figure_name), getattr(row, f"{figure_name}_ci")
        plot.text(_NAMES - 10, y + 4, names[row.method, row.policy], anchor="end", kind="name")
        kind = _kind(interval, 1 if figure_name == "placed" else -1)
        if interval is not None:
            plot.marks.append(
                f'<path class="bar {kind}" d="M{plot.x(interval[0]):.1f} {y}H{plot.x(interval[1]):.1f}"/>'
            )
        plot.marks.append(
            f'<circle class="{kind}" cx="{plot.x(value):.1f}" cy="{y}" r="5"><title>{value:+.2f}</title></circle>'
        )
    return plot.svg(axis)


def _kind(interval: tuple[float, float] | None, sign: int) -> str:
    if interval is None or interval[0] <= 0 <= interval[1]:
        return "level"
    return "better" if sign * interval[0] > 0 else "worse"
