"""In place of moviepy, which is an extra."""

import sys
from types import ModuleType
from typing import Any

import pytest


class Clip:
    """Keeps what it is given."""

    written: tuple[list[Any], int, str] | None = None

    def __init__(self, frames: list[Any], fps: int) -> None:
        self._frames, self._fps = list(frames), fps

    def write_videofile(self, path: str, logger: object) -> None:
        Clip.written = (self._frames, self._fps, path)


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Has `import moviepy` give this module's clip."""
    names = ("moviepy", "moviepy.video", "moviepy.video.io", "moviepy.video.io.ImageSequenceClip")
    for name in names:
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    vars(sys.modules[names[-1]])["ImageSequenceClip"] = Clip
