from dataclasses import replace

from experiments.results.report import format_table
from experiments.results.table import Cell

CELL = Cell(
    object="antenna",
    method="maskval",
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
)
EMPTY = replace(
    CELL,
    method="none",
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
)


def test_the_papers_figures_stand_beside_its_own_experiments_only() -> None:
    (row,) = format_table([CELL], as_paper=False).splitlines()[2:]
    assert row.split().count("–") == 2
    (row,) = format_table([CELL]).splitlines()[2:]
    assert row.split().count("–") == 0


def words(*cells: Cell) -> list[dict[str, str]]:
    """The rows of the table as words by column; the two columns of the paper become paper and paper 2, and so on."""
    header, _, *rows = format_table(cells).splitlines()
    names: list[str] = []
    for name in header.replace("AP %", "AP%").replace("AR %", "AR%").replace("[95 %]", "[95%]").split():
        names.append(name if name not in names else f"{name} 2")
    return [dict(zip(names, row.split(maxsplit=len(names) - 1), strict=True)) for row in rows]


def test_figures_stand_under_their_names_with_the_papers_beside() -> None:
    (row,) = words(CELL)
    assert row == {
        "object": "antenna",
        "method": "maskval",
        "AP%": "97.5",
        "[95%]": "87–100",
        "paper": "97.5",
        "AR%": "100.0",
        "[95%] 2": "91–100",
        "paper 2": "100.0",
        "TP": "39",
        "FP": "1",
        "FN": "0",
        "void": "3",
        "time-outs": "2",
        "s/part": "11.0",
        "runs": "5",
    }


def test_the_papers_figures_are_those_of_the_same_object_and_method() -> None:
    rows = words(replace(CELL, object="handle", method="none"), replace(CELL, method="ensemble-add"))
    assert [(row["paper"], row["paper 2"]) for row in rows] == [("61.4", "50.0"), ("96.0", "50.0")]


def test_an_object_or_method_that_the_paper_does_not_have_shows_a_dash() -> None:
    rows = words(replace(CELL, object="mug"), replace(CELL, method="coin-toss"))
    assert [(row["paper"], row["paper 2"]) for row in rows] == 2 * [("–", "–")]
    assert [row["AP%"] for row in rows] == 2 * ["97.5"]


def test_undefined_rates_show_a_dash_and_no_zero() -> None:
    (row,) = words(EMPTY)
    assert [row[name] for name in ("AP%", "[95%]", "AR%", "[95%] 2", "s/part")] == 5 * ["–"]
    assert row["paper"] == "90.0"


def test_missing_experiments_are_told_beside_those_that_count() -> None:
    good, bad = words(CELL, replace(CELL, experiments=3, failed=2))
    assert good["runs"] == "5"
    assert bad["runs"] == "3 (2 failed)"


def test_columns_are_aligned_words_to_the_left_and_numbers_to_the_right() -> None:
    wide = replace(CELL, object="a-part-with-a-long-name", tp=12345)
    header, rule, *rows = format_table([CELL, wide, EMPTY]).splitlines()
    assert len(rows) == 3
    assert set(rule) == {"-"}
    assert len(rule) == max(map(len, (header, *rows)))
    method = header.index("method")
    assert [row.index(name) for row, name in zip(rows, ("maskval", "maskval", "none"), strict=True)] == 3 * [method]
    end_of_tp = header.index("TP") + len("TP")
    assert [row[:end_of_tp].split()[-1] for row in rows] == ["39", "12345", "0"]
    assert not any(line.endswith(" ") for line in (header, *rows))


def test_the_table_of_no_cell_is_its_header() -> None:
    header, rule = format_table([]).splitlines()
    assert header.split()[:2] == ["object", "method"]
    assert len(rule) == len(header)
