from dataclasses import replace

import pytest

from experiments.results.report import format_table
from experiments.results.table import Cell

CELL = Cell(
    object="antenna",
    method="maskval",
    policy="threshold",
    experiments=5,
    failed=0,
    parts=40,
    tp=39,
    fp=1,
    fn=0,
    void=3,
    timeouts=2,
    ap=0.975,
    ar=1.0,
    ap_pooled=39 / 40,
    ar_pooled=1.0,
    ap_ci=(0.868, 0.999),
    ar_ci=(0.910, 1.0),
    cycle_time_s=11.04,
    worlds=5,
    ap_pooled_ci=(0.868, 0.999),
    ar_pooled_ci=(0.910, 1.0),
    ap_first=37 / 39,
    ap_first_ci=(0.851, 0.999),
    parts_failed=1,
)
EMPTY = replace(
    CELL,
    method="none",
    policy="always",
    tp=0,
    ap=None,
    ar=None,
    ap_pooled=None,
    ar_pooled=None,
    ap_ci=None,
    ar_ci=None,
    cycle_time_s=None,
    ap_pooled_ci=None,
    ar_pooled_ci=None,
    ap_first=None,
    ap_first_ci=None,
    parts_failed=None,
)


def words(*cells: Cell, as_paper: bool = True) -> list[dict[str, str]]:
    """The rows of the table as words by column; AP and AR with the paper's beside, the second interval as [95%] 2."""
    header, _, *rows = format_table(cells, as_paper=as_paper).splitlines()
    names: list[str] = []
    for name in header.replace(" % (paper)", "").replace(" %", "").split():
        names.append(name if name not in names else f"{name} 2")
    return [
        dict(zip(names, row.replace(" (", "(", 2 * as_paper).split(maxsplit=len(names) - 1), strict=True))
        for row in rows[: len(cells)]
    ]


def test_figures_stand_under_their_names_with_the_papers_beside() -> None:
    (row,) = words(CELL)
    assert row == {
        "object": "antenna",
        "method": "maskval",
        "AP": "97.5(97.5)",
        "[95]": "87–100",
        "first": "94.9",
        "AR": "100.0(100)",
        "[95] 2": "91–100",
        "TP": "39",
        "FP": "1",
        "on": "1",
        "FN": "0",
        "s": "11.0",
        "runs": "5",
    }


def test_the_papers_figures_stand_beside_its_own_experiments_only() -> None:
    assert "paper" in format_table([CELL])
    assert "paper" not in format_table([CELL], as_paper=False)
    (row,) = words(CELL, as_paper=False)
    assert (row["AP"], row["AR"]) == ("97.5", "100.0")


def test_the_papers_figures_are_those_of_the_same_object_and_method() -> None:
    rows = words(replace(CELL, object="handle", method="none"), replace(CELL, method="ensemble-add"))
    assert [(row["AP"], row["AR"]) for row in rows] == [("97.5(61.4)", "100.0(50)"), ("97.5(96)", "100.0(50)")]


def test_an_object_or_method_that_the_paper_does_not_have_has_nothing_beside() -> None:
    for cell in (replace(CELL, object="mug"), replace(CELL, method="coin-toss")):
        _, _, row, *_ = format_table([cell]).splitlines()
        assert "(" not in row
        assert row.split()[2:6] == ["97.5", "87–100", "94.9", "100.0"]


def test_undefined_rates_show_a_dash_and_no_zero() -> None:
    (row,) = words(EMPTY)
    assert [row[name] for name in ("[95]", "first", "[95] 2", "on", "s")] == 5 * ["–"]
    assert (row["AP"], row["AR"]) == ("–(90)", "–(82.5)")


def six() -> list[Cell]:
    """The paper's rows with the longest figures."""
    worst = replace(CELL, ap=1.0, ar=1.0, ap_ci=(0.9, 1.0), ar_ci=(0.9, 1.0), ap_first=1.0, tp=160, fp=160, fn=160)
    worst = replace(worst, parts_failed=99, experiments=20, same="ab")
    methods = ("none", "ensemble-add", "maskval")
    return [replace(worst, object=part, method=name) for part in ("antenna", "handle") for name in methods]


@pytest.mark.parametrize(
    ("width", "left_out"),
    [(200, []), (97, ["s"]), (90, ["s", "runs"]), (80, ["s", "runs", "on", "first"])],
)
def test_a_table_fits_the_width_or_leaves_out_the_least_important(width: int, left_out: list[str]) -> None:
    lines = format_table(six(), width=width).splitlines()
    assert max(map(len, lines[:8])) <= width
    columns = lines[0].split()
    assert [name for name in ("s", "runs", "on", "first", "≈") if name not in columns] == left_out
    explained = [line.partition(":")[0] for line in lines[8:]]
    assert [name for name in left_out if name in explained] == []
    assert ("experiments of each cell: 20" in lines) == ("runs" in left_out)


def test_letters_are_shown_and_explained_where_there_are_some() -> None:
    assert "≈" not in format_table([CELL])
    lines = format_table([replace(CELL, same="a"), CELL]).splitlines()
    assert [line.split()[-1] for line in (lines[0], lines[2], lines[3])] == ["≈", "a", "–"]
    assert any(line.startswith("≈: ") for line in lines)


def test_missing_experiments_are_told_beside_those_that_count() -> None:
    good, bad = words(CELL, replace(CELL, experiments=3, failed=2))
    assert good["runs"] == "5"
    assert bad["runs"] == "3 (2 failed)"


def test_columns_are_aligned_words_to_the_left_and_numbers_to_the_right() -> None:
    wide = replace(CELL, object="a-part-with-a-long-name", tp=12345)
    header, rule, *rows = format_table([CELL, wide, EMPTY]).splitlines()[:5]
    assert len(rows) == 3
    assert set(rule) == {"-"}
    assert len(rule) == max(map(len, (header, *rows)))
    method = header.index("method")
    assert [row.index(name) for row, name in zip(rows, ("maskval", "maskval", "none"), strict=True)] == 3 * [method]
    end_of_tp = header.index("TP") + len("TP")
    assert [row[:end_of_tp].split()[-1] for row in rows] == ["39", "12345", "0"]
    assert not any(line.endswith(" ") for line in (header, *rows))


def test_the_table_of_no_cell_is_its_header() -> None:
    header, rule, *_ = format_table([]).splitlines()
    assert header.split()[:2] == ["object", "method"]
    assert len(rule) == len(header)
