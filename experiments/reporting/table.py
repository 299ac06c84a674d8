"""The table of runs as HTML, beside the paper's, with intervals as bars."""

from collections.abc import Mapping, Sequence
from html import escape

from experiments.reporting.data.source import Source
from experiments.results.paper import ROBOT_TABLE
from experiments.results.report import percent, percents
from experiments.results.table import Cell, Interval

_HEADS = (
    "part",
    "method",
    "≈",
    "AP %",
    "AR %",
    "placed",
    "failed",
    "on",
    "left",
    "void",
    "time-outs",
    "s/part",
    "runs",
)
_WORDS = ("run", "part", "method")
LEGEND = (
    "AP = TP / (TP + FP) and AR = TP / (TP + FN), means over experiments; in brackets 95 % intervals, as whiskers on "
    "the bars; red ticks and “paper”: the paper's robot. Placed: parts (TP). Failed: attempts (FP), on so many parts. "
    "Left: parts on the belt (FN). Void attempts and time-outs cost only time. Runs: experiments with a result. ≈: "
    "rows of one part that share a letter cannot be told apart in parts placed (5 %, Holm). s/part: time of the cell "
    "per placed part."
)


def table(sources: Sequence[Source], names: Mapping[tuple[str, str], str]) -> str:
    """A row for each run, part, method and policy."""
    several = len(sources) > 1
    heads = ("run", *_HEADS) if several else _HEADS
    lines = "".join(f'<th class="{"word" if head in _WORDS else ""}" scope="col">{head}</th>' for head in heads)
    rows = []
    for place, name in enumerate(dict.fromkeys(cell.object for source in sources for cell in source.summary.cells)):
        own = [(source, cell) for source in sources for cell in source.summary.cells if cell.object == name]
        best = max((cell.ap or 0.0) * (cell.ar or 0.0) for _, cell in own)
        for number, (source, cell) in enumerate(own):
            kind = "first" if place and not number else ""
            kind += " best" if (cell.ap or 0.0) * (cell.ar or 0.0) == best else ""
            run = f'<td class="word">{escape(source.name)}</td>' if several else ""
            rows.append(
                f'<tr class="{kind.strip()}" data-run="{escape(source.name)}">{run}{_cells(source, cell, names)}</tr>'
            )
    return f'<table class="rates"><thead><tr>{lines}</tr></thead><tbody>{"".join(rows)}</tbody></table>'


def _cells(source: Source, cell: Cell, names: Mapping[tuple[str, str], str]) -> str:
    paper = ROBOT_TABLE.get((cell.object, cell.method), (None, None)) if source.as_paper else (None, None)
    texts = (
        ("tp", cell.tp),
        ("fp", cell.fp),
        ("parts_failed", cell.parts_failed),
        ("fn", cell.fn),
        ("void", cell.void),
        ("timeouts", cell.timeouts),
        ("cycle_time_s", None if cell.cycle_time_s is None else f"{cell.cycle_time_s:.1f}"),
        ("experiments", f"{cell.experiments} ({cell.failed} failed)" if cell.failed else cell.experiments),
    )
    plain = "".join(
        f'<td data-key="{key}" data-label="{head}">{"–" if text is None else escape(str(text))}</td>'
        for (key, text), head in zip(texts, _HEADS[5:], strict=True)
    )
    return (
        f'<td class="word" data-key="object">{escape(cell.object)}</td>'
        f'<td class="word" data-key="method">{escape(names[cell.method, cell.policy])}</td>'
        f'<td data-key="same" data-label="≈">{escape(cell.same or "–")}</td>'
        f"{_rate('ap', cell.ap, cell.ap_ci, paper[0])}{_rate('ar', cell.ar, cell.ar_ci, paper[1])}{plain}"
    )


def _rate(key: str, rate: float | None, interval: Interval | None, paper: float | None) -> str:
    beside = "" if paper is None else f" paper {100 * paper:.3g}"
    share = "" if rate is None else f'<rect class="share" width="{100 * rate:.1f}" y="4" height="10"/>'
    ends = "" if interval is None else f'<path class="whisker" d="M{100 * interval[0]:.1f} 9H{100 * interval[1]:.1f}"/>'
    tick = "" if paper is None else f'<rect class="paper" x="{100 * paper - 1:.1f}" width="2.5" y="0" height="18"/>'
    return (
        f'<td data-key="{key}" data-label="{key.upper()} %"><span class="rate">{percent(rate)}</span>'
        f'<svg viewBox="-2 0 106 18" aria-hidden="true"><rect class="track" width="100" y="4" height="10"/>'
        f'{share}{ends}{tick}</svg><div class="ends">[{percents(interval)}]{beside}</div></td>'
    )
