from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from experiments.commands import compare as compare_module
from tests.experiments.command import command


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "interrupted after 0 of 3 experiments"),
        (BrokenProcessPool("killed"), 1, "a worker process died (out of memory?); ended after 0 of 3 experiments"),
    ],
)
def test_what_ends_compare_before_its_first_result_leaves_the_earlier_ones(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
    words: str,
) -> None:
    arguments = ("compare", "--objects", "antenna", "--parts", 1, "--estimator", "oracle", "--speed", "fast")
    arguments += ("--jobs", 1, "--out", tmp_path)
    assert command(capsys, *arguments, "--methods", "none", "--experiments", 1).code == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert {"table.json", "manifest.json", "estimates.parquet"} <= set(before)

    def end(spec: object) -> None:
        raise error

    monkeypatch.setattr(compare_module, "run_experiment", end)
    told = command(capsys, *arguments, "--experiments", 1)
    assert told.code == code
    assert words in told.out
    assert f"{tmp_path} is as it was" in told.out
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
