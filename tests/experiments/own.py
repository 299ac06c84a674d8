"""A person's own modules in the folder where the command runs."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def folder_with(folder: Path, modules: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder has these modules; what is imported meanwhile is forgotten afterwards."""
    before, path = set(sys.modules), list(sys.path)
    for name, code in modules.items():
        (folder / f"{name}.py").write_text(code)
    with monkeypatch.context() as patch:
        patch.chdir(folder)
        try:
            yield folder
        finally:
            sys.path[:] = path
            for name in modules.keys() & (set(sys.modules) - before):
                del sys.modules[name]
