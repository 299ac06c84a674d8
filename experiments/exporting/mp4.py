"""Videos: H.264 in MP4, as browsers and LeRobot's loader read it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.errors import UsageError

CODEC, PIXELS = "h264", "yuv420p"
# A key frame at every second picture: a loader that takes single pictures then decodes two at most.
_OPTIONS = {"g": "2", "crf": "23", "preset": "veryfast"}


def check_av() -> None:
    """Asks for PyAV before any work is done.

    Raises:
        UsageError: it is not installed.
    """
    try:
        import av  # noqa: F401, PLC0415  # an extra
    except ImportError:
        raise UsageError("videos need PyAV; expected the extra: pip install 'graspcell[lerobot]'") from None


class Mp4:
    """A video that is being written; see `opened_mp4`."""

    def __init__(self, container: Any, stream: Any) -> None:
        self._container, self._stream = container, stream
        self.frames = 0

    def add(self, rgb: NDArray[np.uint8]) -> None:
        """Appends a picture, (H, W, 3) of the video's size."""
        from av import VideoFrame  # noqa: PLC0415  # an extra

        self._container.mux(self._stream.encode(VideoFrame.from_ndarray(rgb, format="rgb24")))
        self.frames += 1


@contextmanager
def opened_mp4(path: Path, width: int, height: int, fps: int) -> Iterator[Mp4]:
    """A video of a file, whole at the end of the block; the folder is made if missing.

    Args:
        path: the file, .mp4.
        width: pixels, even.
        height: pixels, even.
        fps: pictures per second.

    Raises:
        UsageError: it cannot be written.
    """
    import av  # noqa: PLC0415  # an extra

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with av.open(os.fspath(path), "w") as container:
            stream = container.add_stream("libx264", rate=fps, options=_OPTIONS)
            stream.width, stream.height, stream.pix_fmt = width, height, PIXELS
            yield Mp4(container, stream)
            container.mux(stream.encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error
