"""The proof that the cell itself works: with exact masks and poses, every part is placed."""

import json
from pathlib import Path

import pytest

from tests.experiments.command import command

PARTS = 4


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_with_exact_masks_and_poses_every_part_is_placed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, part: str
) -> None:
    told = command(
        capsys,
        *("compare", "--estimator", "oracle", "--methods", "maskval", "--objects", part),
        *("--experiments", 1, "--parts", PARTS, "--out", tmp_path),
    )
    assert told.code == 0
    (cell,) = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["cells"]
    assert (cell["tp"], cell["fp"], cell["fn"], cell["timeouts"]) == (PARTS, 0, 0, 0)
    assert (cell["ap"], cell["ar"]) == (1.0, 1.0)
    # Clopper-Pearson of n of n: the lower end p solves pⁿ = 2.5 %.
    assert cell["ap_pooled_ci"] == [pytest.approx(0.025 ** (1 / PARTS)), 1.0]
    # In one world they count as n / (1 + (n - 1) / 2): correlated by a half.
    assert cell["ap_ci"] == [pytest.approx(0.025 ** ((1 + (PARTS - 1) / 2) / PARTS)), 1.0]
