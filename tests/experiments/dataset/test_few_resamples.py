import json

from tests.experiments.command import command


def test_one_resample_gives_figures_and_thresholds_but_no_interval(capsys, tmp_path) -> None:
    told = command(
        capsys,
        *("dataset", "--objects", "handle", "--methods", "maskval", "--images", 8),
        *("--resamples", 1, "--jobs", 1, "--out", tmp_path),
    )
    assert told.code == 0
    (found,) = json.loads((tmp_path / "dataset.json").read_text(encoding="utf-8"))["objects"]
    rows = (found, found["mask"], found["methods"]["maskval"])
    assert [value for row in rows for name, value in row.items() if name.endswith("_ci")] == 7 * [None]
    assert f"median MDD {1e3 * found['median_mdd_m']:.2f} mm;" in told.out
    assert "maskval" in (tmp_path / "thresholds.toml").read_text(encoding="utf-8")
