"""Result files: each grows aside and takes its name at the end, so that a reader meets a whole one or the earlier one.

A killed run leaves its asides behind: hidden files with names of their own, which nothing reads.
"""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from experiments.errors import UsageError


class Aside:
    """A new file beside the one that it is to replace: `keep` it if it is whole, then `drop` it in any case.

    Args:
        path: the file to replace. A link of this name is replaced itself; what it points to stays as it is.

    Raises:
        OSError: the folder cannot be written to.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._aside = path, path.with_name(f".{path.name}.{secrets.token_hex(8)}.part")
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        self.file: BinaryIO = os.fdopen(os.open(self._aside, flags, 0o666), "wb")

    def keep(self) -> None:
        """Puts it in place of the earlier file, once its content is on the disk.

        Raises:
            OSError: the disk is full, or a folder has the name.
        """
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        os.replace(self._aside, self._path)

    def drop(self) -> None:
        """Removes it, and the earlier file stays; nothing where it was kept."""
        with contextlib.suppress(OSError):  # of a full disk, to which nothing has to be written any more
            self.file.close()
        self._aside.unlink(missing_ok=True)


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file to write to, that replaces the earlier one at the end; an exception leaves that as it is.

    Raises:
        UsageError: it cannot be written.
    """
    try:
        aside = Aside(path)
        try:
            yield aside.file
            aside.keep()
        finally:
            aside.drop()
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error


def write_text(path: Path, text: str) -> None:
    """Writes UTF-8 text.

    Raises:
        UsageError: it cannot be written.
    """
    with replacing(path) as file:
        file.write(text.encode("utf-8"))
