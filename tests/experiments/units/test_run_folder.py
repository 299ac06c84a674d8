"""A run's folder: it goes on, it grows, it refuses what does not belong to it, and nothing is lost."""

import errno
import json
import os
import shutil
from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.setup import experiment
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from experiments.units import identity
from experiments.units.run_folder import RunFolder
from experiments.units.unit import Unit, run_unit
from tests.experiments.command import Told, command, overriding
from tests.experiments.comparisons import contents, rows, spec, table_of

ROOT = Path(__file__).parents[3]


def compared(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object) -> Told:
    """The smallest comparison there is: one part, exact estimates; "none" unless other methods are named."""
    small = ("--objects", "antenna", "--methods", "none", "--parts", 1, "--estimator", "oracle", "--speed", "fast")
    return command(capsys, "compare", *overriding(*small, "--jobs", 1, "--out", out, *arguments))


def counting(monkeypatch: pytest.MonkeyPatch) -> list[ExperimentSpec]:
    """The experiments that run from now on."""
    ran: list[ExperimentSpec] = []

    def run(spec: ExperimentSpec) -> ExperimentResult:
        ran.append(spec)
        return run_experiment(spec)

    monkeypatch.setattr(experiment, "run_experiment", run)
    return ran


# --- it goes on and grows


def test_nothing_that_is_finished_runs_again(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert compared(capsys, tmp_path, "--experiments", 2).code == 0
    before, ran = contents(tmp_path), counting(monkeypatch)
    told = compared(capsys, tmp_path, "--experiments", 2)
    assert (told.code, ran, contents(tmp_path)) == (0, [], before)
    assert "2 of 2 experiments are in" in told.out


def test_more_experiments_methods_and_policies_add_to_a_folder(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0
    ran = counting(monkeypatch)
    assert compared(capsys, tmp_path, "--experiments", 2).code == 0
    assert (
        compared(capsys, tmp_path, "--experiments", 1, "--methods", "maskval", "--policy", "fuse", "threshold").code
        == 0
    )
    assert [(one.method, one.policy, one.experiment) for one in ran] == [
        ("none", None, 1),
        ("maskval", "fuse", 0),
        ("maskval", "threshold", 0),
    ]
    cells = [(cell["method"], cell["policy"], cell["experiments"]) for cell in table_of(tmp_path)]
    assert cells == [("none", "always", 2), ("maskval", "fuse", 1), ("maskval", "threshold", 1)]
    assert {row["policy"] for row in rows(tmp_path, "attempts", method="maskval")} == {"fuse", "threshold"}


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (("--seed", 7), "common.seed: 0 there, 7 here"),
        (("--parts", 2), "parts: 1 there, 2 here"),
        (("--mass", 2), "conditions.mass: 1.0 there, 2.0 here"),
        (
            ("--methods", "maskval", "--u-grasp", "maskval=0.3"),
            "of antenna × maskval × threshold of another kind: cell.u_grasp",
        ),
    ],
)
def test_a_folder_of_another_kind_is_refused_with_what_differs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, other: tuple[object, ...], words: str
) -> None:
    assert compared(capsys, tmp_path, "--experiments", 1, "--methods", "none", "maskval").code == 0
    before = contents(tmp_path)
    told = compared(capsys, tmp_path, "--experiments", 1, *other)
    assert told.code == 2
    assert words.removeprefix("common.") in told.err
    assert "--overwrite" in told.err
    assert len(told.err.strip().splitlines()) == 1
    assert contents(tmp_path) == before


def test_another_version_of_the_code_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0
    there = identity.versions()
    monkeypatch.setattr(identity, "versions", lambda: {**there, "code": "0123456789abcdef"})
    told = compared(capsys, tmp_path, "--experiments", 1)
    assert (told.code, f"versions.code: {there['code']} there, 0123456789abcdef here" in told.err) == (2, True)


def test_overwrite_makes_the_folder_anew_and_leaves_what_is_not_the_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert compared(capsys, tmp_path / "run", "--experiments", 2).code == 0
    (tmp_path / "run" / "notes.txt").write_text("mine")
    assert compared(capsys, tmp_path / "run", "--experiments", 1, "--seed", 7, "--overwrite").code == 0
    assert compared(capsys, tmp_path / "new", "--experiments", 1, "--seed", 7).code == 0
    assert contents(tmp_path / "run") == contents(tmp_path / "new") | {"notes.txt": b"mine"}


def test_results_without_units_are_not_mixed_with_new_ones(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "table.json").write_text("{}")
    told = compared(capsys, tmp_path, "--experiments", 1)
    assert (told.code, "holds results without run.json" in told.err) == (2, True)
    assert compared(capsys, tmp_path, "--experiments", 1, "--overwrite").code == 0


# --- one at a time, whole or not at all


def test_a_second_command_in_a_folder_says_so(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with RunFolder.opened(tmp_path):
        told = compared(capsys, tmp_path, "--experiments", 1)
    assert told.code == 2
    assert f"another command works in {tmp_path} (process {os.getpid()})" in told.err
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0


def test_what_a_killed_command_left_half_written_is_swept_away(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0
    whole = contents(tmp_path)
    for folder in (tmp_path, tmp_path / "units" / "antenna.none.always"):
        (folder / ".something.0123.part").write_bytes(b"half")
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0
    assert contents(tmp_path) == whole


@pytest.mark.parametrize(("number", "words"), [(errno.ENOSPC, "No space left"), (errno.EROFS, "Read-only file system")])
def test_a_disk_that_fails_in_mid_run_is_one_line_and_what_is_finished_stays(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, words: str
) -> None:
    replace = os.replace

    def fails(source: object, target: object) -> None:
        if "000001-" in str(target):
            raise OSError(number, os.strerror(number))
        replace(source, target)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "replace", fails)
    told = compared(capsys, tmp_path, "--experiments", 3)
    assert (told.code, words in told.err, "Traceback" in told.err) == (2, True, False)
    assert len(told.err.strip().splitlines()) == 1
    assert "1 of 3 experiments are kept, and the same command goes on" in told.err
    assert len(list((tmp_path / "units").rglob("*.gz"))) == 1
    monkeypatch.undo()
    assert "1 of 3 experiments are in" in compared(capsys, tmp_path, "--experiments", 3).out


def test_a_folder_that_is_removed_in_mid_run_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(spec: ExperimentSpec) -> ExperimentResult:
        shutil.rmtree(tmp_path / "run")
        return run_experiment(spec)

    monkeypatch.setattr(experiment, "run_experiment", run)
    told = compared(capsys, tmp_path / "run", "--experiments", 1)
    assert (told.code, "No such file or directory" in told.err) == (2, True)
    assert len(told.err.strip().splitlines()) == 1


# --- units


def test_a_unit_that_comes_twice_must_be_equal(tmp_path: Path) -> None:
    place, ok, packed = run_unit(spec(parts=1))
    other = Unit.from_bytes(packed, "")
    changed = Unit(
        other.description, other.count, other.first, other.failure, other.trace, {**other.tables, "slots": []}
    )
    with RunFolder.opened(tmp_path) as folder:
        folder.add(place, packed, ok=ok)
        folder.add(place, packed, ok=ok)
        with pytest.raises(
            UsageError, match=r"the same experiment came to two results: .*json\.gz and .*other-.*json\.gz"
        ):
            folder.add(place, changed.to_bytes(), ok=True)
    assert len(list((tmp_path / "units").rglob("*.gz"))) == 2


def test_a_unit_read_is_the_unit_written() -> None:
    _, _, packed = run_unit(spec(parts=1))
    read = Unit.from_bytes(packed, "")
    result = run_experiment(spec(parts=1))
    assert (read.count, read.first, read.failure) == (result.count, result.first, None)
    assert read.tables == json.loads(json.dumps(result.tables))
    assert read.to_bytes() == packed


def test_a_damaged_unit_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0
    (file,) = (tmp_path / "units").rglob("*.gz")
    file.write_bytes(file.read_bytes()[:100])
    told = compared(capsys, tmp_path, "--experiments", 1)
    assert (told.code, f"{file} is damaged" in told.err) == (2, True)
    file.unlink()
    assert compared(capsys, tmp_path, "--experiments", 1).code == 0


# --- failures


def test_a_failed_experiment_keeps_reason_and_traceback_until_it_is_retried(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(spec: ExperimentSpec) -> ExperimentResult:
        if spec.experiment == 1:
            raise ZeroDivisionError("by nothing")
        return run_experiment(spec)

    monkeypatch.setattr(experiment, "run_experiment", fails)
    told = compared(capsys, tmp_path, "--experiments", 3)
    assert told.code == 3
    assert "failed: antenna × none, experiment 1: unexpected ZeroDivisionError: by nothing" in told.out
    assert "3 experiments expected = 2 completed + 1 failed" in told.out
    (file,) = (tmp_path / "failed").rglob("*.json")
    kept = json.loads(file.read_text(encoding="utf-8"))
    assert kept["failure"] == "unexpected ZeroDivisionError: by nothing"
    assert "Traceback" in kept["trace"]
    assert rows(tmp_path, "experiments", experiment=1)[0]["failure"] == kept["failure"]
    ran = counting(monkeypatch)
    assert (compared(capsys, tmp_path, "--experiments", 3).code, ran) == (3, [])
    assert compared(capsys, tmp_path, "--experiments", 3, "--retry-failed").code == 0
    assert [one.experiment for one in ran] == [1]
    assert not list((tmp_path / "failed").rglob("*.json"))


# --- shards


def test_merged_shards_are_the_bytes_of_one_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ("--experiments", 3, "--methods", "none", "maskval")
    assert compared(capsys, tmp_path / "whole", *arguments).code == 0
    shards = [tmp_path / str(number) for number in (1, 2, 3, 4)]
    for number, folder in enumerate(shards, start=1):
        assert compared(capsys, folder, *arguments, "--shard", f"{number}/4").code == 0
        assert not (folder / "table.json").exists()
    assert [len(list((folder / "units").rglob("*.gz"))) for folder in shards] == [2, 2, 1, 1]
    told = command(capsys, "merge", *shards, "--out", tmp_path / "merged")
    assert (told.code, "6 experiments expected = 6 completed + 0 failed" in told.out) == (0, True)
    assert contents(tmp_path / "merged") == contents(tmp_path / "whole")


def test_a_merge_says_what_is_missing_and_compare_runs_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert compared(capsys, tmp_path / "1", "--experiments", 3, "--shard", "1/2").code == 0
    told = command(capsys, "merge", tmp_path / "1", "--out", tmp_path / "merged")
    assert (told.code, "3 experiments expected = 2 completed + 0 failed + 1 to do" in told.out) == (3, True)
    assert compared(capsys, tmp_path / "merged", "--experiments", 3).code == 0
    assert compared(capsys, tmp_path / "whole", "--experiments", 3).code == 0
    assert contents(tmp_path / "merged") == contents(tmp_path / "whole")


def test_runs_of_different_kinds_are_not_merged(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for name, seed in (("a", 0), ("b", 1)):
        assert compared(capsys, tmp_path / name, "--experiments", 1, "--seed", seed).code == 0
    told = command(capsys, "merge", tmp_path / "a", tmp_path / "b", "--out", tmp_path / "merged")
    assert (told.code, "seed: 0 there, 1 here" in told.err) == (2, True)


@pytest.mark.parametrize("shard", ["0/2", "3/2", "1", "a/b", "1/2/3", "-1/2"])
def test_a_shard_is_one_of_so_many(capsys: pytest.CaptureFixture[str], tmp_path: Path, shard: str) -> None:
    told = compared(capsys, tmp_path, "--shard", shard)
    assert (told.code, "expected --shard I/N with I in 1..N" in told.err) == (2, True)
