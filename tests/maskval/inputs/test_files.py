import os
from pathlib import Path

import pytest

from maskval import InvalidFileError
from maskval.inputs.files import check_input, read_input, read_input_text


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe")
    return folder / "pipe"


def test_a_regular_file_is_read_whole_through_a_link_too(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("ü\n", encoding="utf-8")
    (tmp_path / "link").symlink_to("a")
    assert read_input(tmp_path / "link") == "ü\n".encode()
    assert read_input_text(tmp_path / "a") == "ü\n"
    assert check_input(tmp_path / "link") == tmp_path / "link"


@pytest.mark.parametrize("read", [read_input, read_input_text, check_input])
def test_what_is_no_regular_file_is_refused_before_anything_is_read(tmp_path: Path, read: object) -> None:
    assert callable(read)
    for path, kind in ((Path("/dev/full"), "a device"), (pipe(tmp_path), "a pipe"), (tmp_path, "a folder")):
        with pytest.raises(InvalidFileError, match=f"^{path}: expected a regular file, got {kind}$"):
            read(path)
    with pytest.raises(InvalidFileError, match="none does not exist"):
        read(tmp_path / "none")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InvalidFileError, match=r"loop cannot be read: Too many levels"):
        read(tmp_path / "loop")


@pytest.mark.parametrize("read", [read_input, read_input_text, check_input])
def test_a_file_beyond_the_bound_is_refused_and_one_at_it_is_not(tmp_path: Path, read: object) -> None:
    assert callable(read)
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    read(path, 5)
    with pytest.raises(InvalidFileError, match=f"^{path}: expected at most 4 bytes, got 5$"):
        read(path, 4)


def test_what_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xff\xd8")
    with pytest.raises(InvalidFileError, match="a cannot be read: expected UTF-8 text"):
        read_input_text(tmp_path / "a")
