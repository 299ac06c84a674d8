import csv
import io
import json
from dataclasses import replace
from pathlib import Path

from experiments.results.table_files import as_csv, as_latex, as_markdown, write_tables
from tests.experiments.results.test_report import CELL, EMPTY


def test_every_form_has_a_line_per_cell_and_the_figures_of_table_json(tmp_path: Path) -> None:
    write_tables(tmp_path, [CELL, EMPTY], [], [])
    cells = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["cells"]
    rows = list(csv.DictReader(io.StringIO((tmp_path / "table.csv").read_text(encoding="utf-8"))))
    assert len(cells) == len(rows) == 2
    for cell, row in zip(cells, rows, strict=True):
        assert (row["ap"], row["tp"]) == ("" if cell["ap"] is None else str(cell["ap"]), str(cell["tp"]))
        low, high = cell["ap_ci"] or ("", "")
        assert (row["ap_ci_low"], row["ap_ci_high"]) == (str(low), str(high))


def test_markdown_and_latex_show_the_main_figures() -> None:
    (line,) = as_markdown([CELL]).splitlines()[2:]
    assert line == "| antenna | maskval | threshold | 97.5 | 87–100 | 100.0 | 91–100 | 97.5/100 | 39 | 1 | 0 | 5 |  |"
    row = as_latex([CELL]).splitlines()[4]
    assert row == r"antenna & maskval & threshold & 97.5 & 87--100 & 100.0 & 91--100 & 97.5/100 & 39 & 1 & 0 & 5 &  \\"


def test_names_cannot_break_a_table() -> None:
    odd = replace(CELL, object="a|b", method="my_method:Class&More")
    assert as_markdown([odd]).splitlines()[2].startswith(r"| a\|b | my_method:Class&More |")
    assert r"my\_method:Class\&More" in as_latex([odd])
    assert next(csv.DictReader(io.StringIO(as_csv([replace(odd, object='a,"b')]))))["object"] == 'a,"b'
