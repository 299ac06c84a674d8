"""Input files: regular ones of a bounded size. A device or a pipe would never end, or never begin."""

import os
import stat
from pathlib import Path

from maskval.errors import InvalidFileError

MOST_TEXT = 64 * 2**20  # bytes; the largest text of the package has 100 kB
MOST_RESULTS = 2 * 2**30  # bytes of BOP's results files, which hold all images of a split
MOST_MESH = 512 * 2**20  # bytes; ten million triangles as STL
MOST_IMAGE = 512 * 2**20  # bytes; 2^28 grey pixels of 16 bits, not compressed

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}


def check_input(path: Path, most: int | None = None) -> Path:
    """The path, for a library that opens the file itself; see `read_input`.

    Args:
        path: the file; a link is followed.
        most: bytes that it may have; None where the library reads it piece by piece.

    Raises:
        InvalidFileError: there is no such file, it is not a regular one, or it is larger.
    """
    try:
        _check(path, os.stat(path), most)
    except InvalidFileError:
        raise
    except (OSError, ValueError) as error:
        raise _refused(path, error) from error
    return path


def read_input(path: Path, most: int = MOST_TEXT) -> bytes:
    """The content of a regular file.

    Args:
        path: the file; a link is followed.
        most: bytes that it may have.

    Raises:
        InvalidFileError: there is no such file, it is not a regular one, larger, or cannot be read.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # a pipe without a writer would block
        try:
            status = os.fstat(descriptor)  # of what was opened, whatever the path says by then
            _check(path, status, most)
            with open(descriptor, "rb", closefd=False) as file:
                return file.read(status.st_size)  # Python makes room for all that it is asked for
        finally:
            os.close(descriptor)
    except InvalidFileError:
        raise
    except (OSError, ValueError) as error:
        raise _refused(path, error) from error


def read_input_text(path: Path, most: int = MOST_TEXT) -> str:
    """The content of a regular file of UTF-8 text; see `read_input`.

    Raises:
        InvalidFileError: see `read_input`; or it is not UTF-8.
    """
    try:
        return read_input(path, most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InvalidFileError(f"{path} cannot be read: expected UTF-8 text: {error}") from error


def _check(path: Path, status: os.stat_result, most: int | None) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
        raise InvalidFileError(f"{path}: expected a regular file, got {kind}")
    if most is not None and status.st_size > most:
        raise InvalidFileError(f"{path}: expected at most {most} bytes, got {status.st_size}")


def _refused(path: Path, error: OSError | ValueError) -> InvalidFileError:
    if isinstance(error, ValueError):  # of NUL, or of a lone surrogate
        return InvalidFileError(f"{str(path)!r} is no path of a file: {error}")
    if isinstance(error, FileNotFoundError):
        return InvalidFileError(f"{path} does not exist")
    return InvalidFileError(f"{path} cannot be read: {error.strerror or error}")
