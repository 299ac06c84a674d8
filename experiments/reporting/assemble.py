"""One self-contained page: a template, its style and its program, and the data of the runs."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from experiments.reporting.charts.forest import forest
from experiments.reporting.charts.of_part import charts
from experiments.reporting.data.command_lines import changes
from experiments.reporting.data.happened import PHASES
from experiments.reporting.data.source import Source, cells_by_object
from experiments.reporting.data.words import verdict
from experiments.reporting.origin import origin, took
from experiments.reporting.table import LEGEND, table
from experiments.results.paired import have_several_policies

_STYLES = ("page.css", "list.css", "detail.css")
_PROGRAMS = ("data.js", "shapes.js", "list.js", "outcomes.js", "parts.js", "detail.js")
_UNSAFE = {ord(sign): f"\\u{ord(sign):04x}" for sign in "<>&\u2028\u2029"}  # within a script element

Names = Mapping[tuple[str, str], str]


def page(sources: Sequence[Source]) -> str:
    """The page of runs, each with its name."""
    names = _names(sources)
    filled = {
        "title": escape(" and ".join(source.name for source in sources)),
        "subtitle": escape(_subtitle(sources)),
        "took": "".join(took(source, named=len(sources) > 1) for source in sources),
        "style": _texts(_STYLES),
        "verdicts": "".join(_verdicts(source, names, named=len(sources) > 1) for source in sources),
        "notes": "".join(_notes(source, sources) for source in sources),
        "table": table(sources, names),
        "legend": escape(LEGEND),
        "forest": "".join(_forest(source, names, named=len(sources) > 1) for source in sources),
        "charts": "".join(_charts(source, names, named=len(sources) > 1) for source in sources),
        "origin": "".join(origin(source) for source in sources),
        "data": as_script(_data(sources)),
        "script": _texts(_PROGRAMS),
    }
    whole = _text("page.html")
    pieces = whole.split("{{")  # each piece is replaced once: nothing within a value is a place to fill
    return pieces[0] + "".join(filled[name] + rest for name, _, rest in (piece.partition("}}") for piece in pieces[1:]))


def as_script(content: Any) -> str:
    """JSON that no content can end the script element with."""
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).translate(_UNSAFE)


def _data(sources: Sequence[Source]) -> dict[str, Any]:
    whos = _whos(sources)
    methods = [method for method, _ in whos]
    return {
        "runs": [
            {
                "name": source.name,
                "seed": source.folder.asked[0].description["common"]["seed"],
                "pictured": source.pictured,
            }
            for source in sources
        ],
        "phases": PHASES,
        "several": sorted({method for method in methods if methods.count(method) > 1}),
        "experiments": [{"r": place, **one} for place, source in enumerate(sources) for one in source.experiments],
    }


def _whos(sources: Sequence[Source]) -> list[tuple[str, str]]:
    return list(
        dict.fromkeys((one.of["method"], one.of["policy"]) for source in sources for one in source.folder.asked)
    )


def _names(sources: Sequence[Source]) -> Names:
    """What each method and policy is called: by the method alone, unless that occurs with several policies."""
    whos = _whos(sources)
    return {
        who: f"{who[0]} + {who[1]}"
        if have_several_policies([other for other in whos if other[0] == who[0]])
        else who[0]
        for who in whos
    }


def _subtitle(sources: Sequence[Source]) -> str:
    total = sum(source.total for source in sources)
    parts = sorted({one.description["common"]["parts"] for source in sources for one in source.folder.asked})
    return f"graspcell report: {total} experiments of {' or '.join(map(str, parts))} parts"


def _verdicts(source: Source, names: Names, *, named: bool) -> str:
    told = ""
    for name, cells in cells_by_object(source):
        title, text = f"{source.name}: {name}" if named else name, verdict(cells, names, source.summary.pairs)
        told += f"<p><b>{escape(title)}</b>: {escape(text)}</p>"
    return told


def _notes(source: Source, sources: Sequence[Source]) -> str:
    told = list(source.notes)
    left = source.folder.expected - source.total
    if left > 0:
        told.append(f"{source.name}: {left} of {source.folder.expected} experiments have not ended yet.")
    told += [
        f"{source.name}: {one.of[0]} × {one.of[1]}, experiment {one.experiment} has no result: {one.failure}"
        for one in source.summary.failures
    ]
    if source is not sources[0]:
        differing = changes(source.folder.options, sources[0].folder.options)
        told.append(f"{source.name} differs from {sources[0].name} by {' '.join(differing) or 'no option'}.")
    return "".join(f'<p class="note">{escape(line)}</p>' for line in told)


def _forest(source: Source, names: Names, *, named: bool) -> str:
    return (f"<h3>{escape(source.name)}</h3>" if named else "") + forest(source.summary.pairs, names)


def _charts(source: Source, names: Names, *, named: bool) -> str:
    told = ""
    for name, _ in cells_by_object(source):
        groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
        for one in source.experiments:
            if one["o"] == name and one["failure"] is None:
                groups.setdefault((one["m"], one["p"]), []).append(one)
        title = f"{source.name}: {name}" if named else name
        told += f'<h3>{escape(title)}</h3><div class="figures">{charts(name, groups, names, source.thresholds)}</div>'
    return told


def _texts(names: Sequence[str]) -> str:
    return "\n".join(map(_text, names))


def _text(name: str) -> str:
    return (files("experiments") / "reporting" / "page" / name).read_text(encoding="utf-8")
