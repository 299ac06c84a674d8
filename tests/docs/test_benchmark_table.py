"""The figures on the library's page are those of the committed benchmark."""

import json
from pathlib import Path

from benchmarks.table import tables

ROOT = Path(__file__).parents[2]


def test_the_tables_of_the_page_are_made_of_the_committed_figures() -> None:
    figures = json.loads((ROOT / "benchmarks" / "results" / "silhouettes.json").read_text())
    page = (ROOT / "docs" / "maskval.md").read_text()
    shown = page.split("<!-- table -->\n")[1].split("\n<!-- end -->")[0]
    assert shown == tables(figures)
    assert figures["missing"] == {}
    assert set(figures["jobs"]) == {
        f"{name} | {size} | {job}"
        for name in ("antenna", "handle", "antenna, fine")
        for size in ("VGA", "HD")
        for job in ("mask", "depth", "task")
    }
    # Every contender draws the same: rasterisers that snap corners differ in hardly a pixel.
    wrong = {name: sum(case["wrong"] for case in cases.values()) for name, cases in figures["pixels"].items()}
    pixels = sum(case["of"] for case in figures["pixels"]["ours, Numba"].values())
    assert wrong["ours, Numba"] == wrong["ours, NumPy"] == 0
    assert max(wrong.values()) < 0.02 / 100 * pixels
