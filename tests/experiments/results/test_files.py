import errno
import os
from pathlib import Path

import numpy as np
import pytest

from experiments.commands import picture as picture_module
from experiments.errors import UsageError
from experiments.results.files import replacing, write_text
from experiments.results.provenance import write_json
from experiments.results.store import SCHEMAS, LogWriter
from tests.experiments.command import command


def full_disk(descriptor: int) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_file_has_its_name_only_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "earlier")
    with replacing(path) as file:
        file.write(b"later, ")
        assert path.read_text() == "earlier"
        file.write("größer".encode())
    assert path.read_text(encoding="utf-8") == "later, größer"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_an_error_on_the_way_leaves_the_earlier_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.json"
    write_json(path, 1)
    with pytest.raises(TypeError), replacing(path) as file:
        file.writelines([b"half", None])  # type: ignore[list-item]
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(UsageError, match=f"cannot write {path}: No space left on device"):
        write_json(path, 2)
    assert (path.read_text(), os.listdir(tmp_path)) == ("1\n", ["a.json"])


def test_a_result_is_on_the_disk_before_it_takes_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    sync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda file: calls.append("fsync") or sync(file))
    monkeypatch.setattr(os, "replace", lambda *paths: calls.append("replace") or replace(*paths))
    write_text(tmp_path / "a.txt", "text")
    assert calls == ["fsync", "replace"]


def test_links_planted_in_the_folder_are_replaced_and_not_followed(tmp_path: Path) -> None:
    elsewhere, out = tmp_path / "elsewhere", tmp_path / "out"
    elsewhere.mkdir()
    out.mkdir()
    planted = ["table.json", ".graspcell-probe"]
    planted += [name for table in SCHEMAS for name in (f"{table}.parquet", f".{table}.parquet.part")]
    for name in planted:
        (elsewhere / name).write_text("precious")
        (out / name).symlink_to(elsewhere / name)
    write_json(out / "table.json", {"cells": []})
    with LogWriter(out):
        pass
    assert {path.read_text() for path in elsewhere.iterdir()} == {"precious"}
    assert len(list(elsewhere.iterdir())) == len(planted)
    written = ["table.json", *(f"{table}.parquet" for table in SCHEMAS)]
    assert [name for name in written if (out / name).is_symlink()] == []


def test_a_full_disk_at_the_end_of_the_logs_leaves_the_earlier_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with LogWriter(tmp_path):
        pass
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(OSError, match="No space left"), LogWriter(tmp_path):
        pass
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_a_picture_is_not_written_into_a_folder_of_its_name(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "cell.png").mkdir()
    told = command(capsys, "picture", "--out", tmp_path / "cell.png")
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert f"cannot write {tmp_path / 'cell.png'}: expected the path of a picture, got a folder" in told.err


def test_a_picture_that_does_not_fit_onto_the_disk_is_an_error(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Blue:
        def rgb(self, camera: str) -> np.ndarray:
            return np.full((2, 3, 3), (0, 0, 255), dtype=np.uint8)

        def close(self) -> None:
            pass

    path = tmp_path / "cell.png"
    monkeypatch.setattr(picture_module, "Pictures", lambda *_: Blue())
    arguments = ("picture", "--after", 0, "--state", "search", "--out", path)
    assert command(capsys, *arguments).out == f"picture in {path}\n"
    assert picture_module.cv2.imread(str(path)).tolist() == [[[255, 0, 0]] * 3] * 2
    monkeypatch.setattr(os, "fsync", full_disk)
    told = command(capsys, *arguments)
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert f"cannot write {path}: No space left on device" in told.err
