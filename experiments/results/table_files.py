"""The table in the forms that others read: JSON for programs, CSV for spreadsheets, Markdown and LaTeX for papers."""

import csv
import io
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from experiments.results.files import write_text
from experiments.results.pair_tests import PairTest
from experiments.results.paired import Paired
from experiments.results.paper import ROBOT_TABLE
from experiments.results.provenance import write_json
from experiments.results.report import percent, percents
from experiments.results.table import Cell

_HEADER = (
    "object",
    "method",
    "policy",
    "AP %",
    "95 %",
    "AR %",
    "95 %",
    "paper AP/AR",
    "TP",
    "FP",
    "FN",
    "runs",
    "same",
)
_LATEX = str.maketrans({"%": r"\%", "_": r"\_", "&": r"\&", "#": r"\#", "–": "--", "$": r"\$", "{": r"\{", "}": r"\}"})


def write_tables(folder: Path, cells: Sequence[Cell], pairs: Sequence[Paired], tests: Sequence[PairTest]) -> None:
    """Writes table.json, table.csv, table.md and table.tex, all from the same cells.

    Raises:
        UsageError: they cannot be written.
    """
    content = {
        "cells": [cell.as_json() for cell in cells],
        "paired": [row.as_json() for row in pairs],
        "tests": [test.as_json() for test in tests],
    }
    write_json(folder / "table.json", content)
    write_text(folder / "table.csv", as_csv(cells))
    write_text(folder / "table.md", as_markdown(cells))
    write_text(folder / "table.tex", as_latex(cells))


def as_csv(cells: Sequence[Cell]) -> str:
    """Every figure of every cell under its name in table.json; the ends of intervals in columns of their own."""
    told = io.StringIO()
    writer = csv.writer(told, lineterminator="\n")
    names = [field.name for field in fields(Cell)]
    writer.writerow([part for name in names for part in ((f"{name}_low", f"{name}_high") if _ends(name) else (name,))])
    for cell in cells:
        row: list[object] = []
        for name in names:
            value = getattr(cell, name)
            row += (value or (None, None)) if _ends(name) else (value,)
        writer.writerow(row)
    return told.getvalue()


def as_markdown(cells: Sequence[Cell]) -> str:
    """The main figures as a Markdown table."""
    lines = [_HEADER, ("---",) * len(_HEADER), *(_row(cell) for cell in cells)]
    return "".join(f"| {' | '.join(text.replace('|', chr(92) + '|') for text in line)} |\n" for line in lines)


def as_latex(cells: Sequence[Cell]) -> str:
    """The main figures as a LaTeX tabular, for the package booktabs."""
    rows = [" & ".join(text.translate(_LATEX) for text in line) + r" \\" for line in (_HEADER, *map(_row, cells))]
    begin = [rf"\begin{{tabular}}{{lll{'r' * (len(_HEADER) - 4)}l}}", r"\toprule", rows[0], r"\midrule"]
    return "\n".join([*begin, *rows[1:], r"\bottomrule", r"\end{tabular}", ""])


def _row(cell: Cell) -> tuple[str, ...]:
    paper = ROBOT_TABLE.get((cell.object, cell.method))
    return (
        *(cell.object, cell.method, cell.policy),
        *(percent(cell.ap), percents(cell.ap_ci), percent(cell.ar), percents(cell.ar_ci)),
        "" if paper is None else "/".join("–" if rate is None else f"{100 * rate:.3g}" for rate in paper),
        *(str(number) for number in (cell.tp, cell.fp, cell.fn, cell.experiments)),
        cell.same or "",
    )


def _ends(name: str) -> bool:
    return name.endswith("_ci")
