"""The committed prediction is what its counts come to, and the page shows it."""

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from cell.records import Tally
from experiments.prediction.summary import format_summary, main, reread, summarise
from experiments.results.first_attempts import FirstAttempts
from experiments.results.provenance import write_json

DOCS = Path(__file__).parents[3] / "docs"


def leaves(value: object) -> list[object]:
    """All numbers and words of nested lists and objects, keys included."""
    if isinstance(value, dict):
        return [leaf for key, one in value.items() for leaf in (key, *leaves(one))]
    if isinstance(value, list | tuple):
        return [leaf for one in value for leaf in leaves(one)]
    return [value]


def test_the_committed_figures_are_those_of_the_committed_counts_and_stand_on_the_page() -> None:
    variants = json.loads((DOCS / "results" / "predict.json").read_text(encoding="utf-8"))["variants"]
    page = (DOCS / "reproduction.md").read_text(encoding="utf-8")
    assert list(variants) == ["base"]
    summary = reread(variants["base"])
    found, committed = leaves(asdict(summary)), leaves(variants["base"])
    assert len(found) == len(committed) > 4800
    assert [one for one in found if isinstance(one, str)] == [one for one in committed if isinstance(one, str)]
    numbers = [[one for one in all_ if isinstance(one, int | float)] for all_ in (found, committed)]
    assert numbers[0] == pytest.approx(numbers[1], abs=1e-9)
    assert format_summary("base", summary).rstrip("\n") in page


def test_a_file_is_rewritten_with_its_first_attempts(tmp_path, capsys) -> None:
    counts = [[Tally(8, 6, 2, 2, 0, 0, 0, 0.0), Tally(8, 4, 4, 4, 0, 0, 0, 0.0)]]
    firsts = [[FirstAttempts(7, 6, 1), FirstAttempts(5, 4, 1)]]
    key = ("handle", "maskval")
    summary = summarise({key: counts}, {key: firsts}, 0)
    file = tmp_path / "predict.json"
    write_json(file, {"worlds": {"handle": [{}]}, "variants": {"base": summary}})
    before = json.loads(file.read_text(encoding="utf-8"))
    main(file)
    assert json.loads(file.read_text(encoding="utf-8")) == before
    (cell,) = before["variants"]["base"]["cells"]
    assert (cell["ap_first"], cell["parts_failed"]) == (pytest.approx((6 / 7 + 4 / 5) / 2), 2)
    assert f" {100 * cell['ap_first']:.1f} " in capsys.readouterr().out


def test_without_a_predicted_cell_nothing_is_said_of_all_together() -> None:
    key = ("handle", "none")
    summary = summarise({key: [[Tally(8, 6, 2, 2, 0, 0, 0, 0.0)]]}, {}, 0)
    assert summary.joint == {}
    assert "jointly" not in format_summary("base", summary)
