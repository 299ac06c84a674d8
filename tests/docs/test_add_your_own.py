"""The page `docs/add-your-own.md`: its files are written where a reader would write them, its commands run."""

import re
import shlex
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from experiments.cli import main
from tests.experiments.own import folder_with

PAGE = Path(__file__).parents[2] / "docs" / "add-your-own.md"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
FILES = {code.split()[1]: code for language, code in BLOCKS if language in ("python", "toml")}
COMMANDS = [line for language, code in BLOCKS if language == "sh" for line in code.splitlines()]


def experiments(out: str) -> dict[str, Any]:
    (row,) = pq.read_table(Path(out) / "experiments.parquet").to_pylist()
    assert row["failure"] is None
    return dict(row)


def test_each_class_is_written_in_less_than_25_lines() -> None:
    lengths = {name: sum(map(bool, code.splitlines())) for name, code in FILES.items() if name.endswith(".py")}
    assert sorted(lengths) == ["my_estimator.py", "my_method.py", "my_policy.py"]
    assert max(lengths.values()) < 25


def test_every_class_runs_through_compare_as_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    modules = {Path(name).stem: code for name, code in FILES.items() if name.endswith(".py")}
    with folder_with(tmp_path, modules, monkeypatch):
        for name, code in FILES.items():
            Path(name).write_text(code)
        assert len(COMMANDS) == 4
        for line in COMMANDS:
            graspcell, *arguments = shlex.split(line)
            assert graspcell == "graspcell"
            with pytest.raises(SystemExit, match=r"^0$"):
                main([*arguments, "--jobs", "1"])
        assert experiments("out/policy")["policy"] == "my_policy:Hurry"
        assert experiments("out/seeing")["estimator"] == "my_estimator:DepthBlobs"
        assert experiments("out/seeing")["tp"] > 0, "no part of two was placed"
        assert experiments("out/method")["method"] == "my_method:CenterDistance"
        replayed = experiments("out/replay")
        assert {**replayed, "estimator": "noisy"} == experiments("out/policy")
