"""Charts of a run: u against error, risk against coverage, recall over the error threshold, errors, time."""

from collections.abc import Mapping, Sequence
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gaussian_kde

from experiments.reporting.charts.seen import Seen, evaluation_of, seen_of
from experiments.reporting.charts.svg import Plot, figure, linear, logarithmic, steps
from experiments.reporting.data.happened import PHASES, Rows
from maskval import recall_curve
from maskval.evaluation.summary import ERROR_THRESHOLD_M

MOST_POINTS = 10_000
_E_T = 1000 * ERROR_THRESHOLD_M
_LOW, _HIGH = 0.3, 500.0  # mm: the ends of an axis of errors
_TICKS = (1, 3, 10, 30, 100, 300)
Who = tuple[str, str]


def charts(
    name: str,
    groups: Mapping[Who, Sequence[Rows]],
    names: Mapping[Who, str],
    thresholds: Mapping[tuple[str, str], float],
) -> str:
    """The charts of one part.

    Args:
        name: of the part.
        groups: experiments of each method and policy.
        names: what these are called.
        thresholds: u_t,g by object and method.
    """
    seen = {who: seen_of(experiments) for who, experiments in groups.items()}
    colors = {who: f"m{place % 8}" for place, who in enumerate(groups)}
    judged = {who: one for who, one in seen.items() if len(one.u) and np.ptp(one.u) > 0}
    told = [
        _scatter(
            name, judged, names, {who: thresholds[name, who[0]] for who in judged if (name, who[0]) in thresholds}
        ),
        _risk(name, seen, names, colors),
        _recall(name, judged, names, colors),
        _violins(name, {who: one for who, one in seen.items() if len(one.u)}, names),
        _times(name, groups, names),
    ]
    return "".join(told)


def _scatter(name: str, seen: Mapping[Who, Seen], names: Mapping[Who, str], bounds: Mapping[Who, float]) -> str:
    total = sum(map(len, (one.u for one in seen.values())))
    stride = -(-total // MOST_POINTS)
    told = f"one in {stride} of {total}" if stride > 1 else f"all {total}"
    body = ""
    for who, one in seen.items():
        box = 44, 34, 330, 230
        plot = Plot(340, 268, linear(0, 1, box[0], box[2]), logarithmic(_LOW, _HIGH, box[3], box[1]), box)
        plot.y_axis(_TICKS, "error, mm")
        plot.x_axis((0, 0.25, 0.5, 0.75, 1), "u")
        plot.text(box[2], 14, names[who], anchor="end", kind="head")
        plot.line(((0, _E_T), (1, _E_T)), "bound")
        if who in bounds:
            plot.line(((bounds[who], _LOW), (bounds[who], _HIGH)), "bound")
            plot.text(plot.x(bounds[who]) + 4, box[1] + 12, f"u_t,g = {bounds[who]:.2f}")
        points = list(zip(one.u, np.minimum(one.errors, _HIGH), one.acted, strict=True))[::stride]
        plot.dots(((u, error) for u, error, acted in points if not acted), "refused")
        plot.dots(((u, error) for u, error, acted in points if acted), "acted")
        body += plot.svg(f"u against error, {names[who]}")
    caption = (
        f"Each dot is an estimate ({told}): blue ones were acted upon. Upper left is certain and wrong, lower right "
        f"uncertain and right. Dashed: u_t,g, and the paper's e_t of {_E_T:g} mm. False detections lie at the top."
    )
    return figure(f"{name}: does u know the error?", body, caption, "wide") if seen else ""


def _risk(name: str, seen: Mapping[Who, Seen], names: Mapping[Who, str], colors: Mapping[Who, str]) -> str:
    box = 44, 24, 330, 210
    plot = Plot(340, 248, linear(0, 100, box[0], box[2]), linear(0, 100, box[3], box[1]), box)
    plot.y_axis((0, 25, 50, 75, 100), "wrong poses among them, %")
    plot.x_axis((0, 25, 50, 75, 100), "estimates kept, least u first, %")
    for who, one in seen.items():
        if not len(one.u):
            continue
        u, counts = np.unique(one.u, return_counts=True)
        wrong = np.array([np.count_nonzero(one.errors[one.u == value] > _E_T) for value in u])
        kept, risk = 100 * np.cumsum(counts) / len(one.u), 100 * np.cumsum(wrong) / np.cumsum(counts)
        thin = np.unique(np.linspace(0, len(u) - 1, 200).astype(int))
        curve = list(zip(kept[thin], risk[thin], strict=True))
        plot.line([(0.0, curve[0][1]), *curve], colors[who])
    caption = f"Lower is better. Wrong is an error above {_E_T:g} mm or a false detection; equal u are kept together."
    return figure(f"{name}: risk against coverage", plot.svg("risk against coverage") + _legend(names, colors), caption)


def _recall(name: str, seen: Mapping[Who, Seen], names: Mapping[Who, str], colors: Mapping[Who, str]) -> str:
    if not seen:
        return ""
    box, errors = (44, 24, 330, 210), np.linspace(0, 0.03, 31)
    plot = Plot(340, 248, linear(0, 30, box[0], box[2]), linear(0, 100, box[3], box[1]), box)
    plot.y_axis((0, 25, 50, 75, 100), "%")
    plot.x_axis((0, 5, 10, 15, 20, 25, 30), "error threshold e_t, mm")
    for who, one in seen.items():
        curve = recall_curve(evaluation_of(one), errors)
        for values, kind in ((curve.ar, "solid"), (curve.aru, "thin"), (curve.ar_star, "dotted")):
            plot.line(zip(1000 * errors, 100 * values, strict=True), f"{colors[who]} {kind}")
    caption = (
        "Solid AR and thin ARU at the greatest u_T that keeps an AP of 99 %; dotted AR* of all poses. Of detected "
        "parts only: the logs do not name those that no mask shows."
    )
    shown = {who: names[who] for who in seen}
    return figure(f"{name}: AR, ARU and AR*", plot.svg("AR, ARU and AR*") + _legend(shown, colors), caption)


def _violins(name: str, seen: Mapping[Who, Seen], names: Mapping[Who, str]) -> str:
    if not seen:
        return ""
    step, box = 84, (44, 24, 44 + 84 * len(seen), 210)
    plot = Plot(max(340, box[2] + 10), 248, linear(0, 1, 0, 1), logarithmic(_LOW, _HIGH, box[3], box[1]), box)
    plot.y_axis(_TICKS, "error, mm")
    plot.marks.append(f'<path class="line bound" d="M{box[0]} {plot.y(_E_T):.1f}H{box[2]}"/>')
    for place, (who, one) in enumerate(seen.items()):
        middle = box[0] + step * (place + 0.5)
        for acted, side, kind in ((True, -1, "acted"), (False, 1, "refused")):
            found = one.errors[(one.acted == acted) & np.isfinite(one.errors)]
            plot.marks.append(_half(found, middle, side, plot, kind))
        plot.text(middle, box[3] + 14 + 12 * (place % 2), names[who], anchor="middle", kind="name")
    caption = (
        "Left halves: poses acted upon; right halves: all others that were seen. A good u keeps the left ones low."
    )
    return figure(f"{name}: errors of poses", plot.svg("errors of poses"), caption)


def _half(errors: NDArray[np.float64], middle: float, side: int, plot: Plot, kind: str) -> str:
    logs = np.log10(np.maximum(errors, _LOW))
    if len(logs) < 3 or np.ptp(logs) == 0:
        return ""
    levels = np.linspace(logs.min(), logs.max(), 60)
    density = gaussian_kde(logs)(levels)
    shape = [
        (middle + side * 38 * d / density.max(), plot.y(10**level)) for d, level in zip(density, levels, strict=True)
    ]
    ends = [(middle, shape[0][1]), *shape, (middle, shape[-1][1])]
    path = "L".join(f"{x:.1f} {y:.1f}" for x, y in ends)
    return f'<path class="violin {kind}" d="M{path}z"><title>{len(errors)} poses</title></path>'


def _times(name: str, groups: Mapping[Who, Sequence[Rows]], names: Mapping[Who, str]) -> str:
    """Seconds of each phase per placed part."""
    bars = {who: _seconds(experiments) for who, experiments in groups.items()}
    longest = max([sum(one) for one in bars.values() if one is not None], default=1.0)
    box = 130, 8, 330, 8 + 30 * len(bars)
    plot = Plot(380, box[3] + 42, linear(0, longest, box[0], box[2]), linear(0, 1, 0, 1), box)
    plot.x_axis(steps(0, longest), "s per placed part")
    for place, (who, one) in enumerate(bars.items()):
        y, start = box[1] + 30 * place + 5, 0.0
        plot.text(box[0] - 8, y + 14, names[who], anchor="end", kind="name")
        for phase, seconds in enumerate(one or ()):
            left, right = plot.x(start), plot.x(start + seconds)
            start += seconds
            title = f"<title>{PHASES[phase]}: {seconds:.1f} s</title>"
            place_and_size = f'x="{left:.1f}" y="{y}" width="{right - left:.1f}" height="20"'
            plot.marks.append(f'<rect class="phase{phase}" {place_and_size}>{title}</rect>')
        plot.text(plot.x(start) + 5, y + 14, "none placed" if one is None else f"{start:.1f}")
    key = "".join(f'<span><i class="phase{number}"></i>{phase}</span>' for number, phase in enumerate(PHASES[:5]))
    return figure(
        f"{name}: where the time goes",
        plot.svg("time per placed part") + f'<p class="key">{key}</p>',
        "All time of all experiments, by what the cell did, per placed part.",
    )


def _seconds(experiments: Sequence[Rows]) -> list[float] | None:
    total, placed = np.zeros(len(PHASES)), 0
    for experiment in experiments:
        phases = experiment["phases"]
        for (begin, phase), (end, _) in pairwise(phases):
            total[int(phase)] += end - begin
        placed += sum(item["k"] == "placed" for item in experiment["items"])
    return [float(one) / placed for one in total] if placed else None


def _legend(names: Mapping[Who, str], colors: Mapping[Who, str]) -> str:
    return (
        '<p class="key">'
        + "".join(f'<span><i class="{colors[who]}"></i>{escape(name)}</span>' for who, name in names.items())
        + "</p>"
    )
