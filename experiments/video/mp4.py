"""Writes MP4 files: H.264 in 4:2:0, which every player shows. Needs the extra `graspcell[video]`."""

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from experiments.observing.drawing import Image
from experiments.results.files import replacing

CRF = 20  # x264's constant rate factor: 18 is said to look like the original, 23 is x264's default
_CODEC = "libx264"


class Writer:
    """Takes one picture after the other, all of one even size."""

    def __init__(self, av: Any, container: Any, stream: Any) -> None:
        self._av, self._container, self._stream = av, container, stream

    def write(self, image: Image) -> None:
        """Adds a picture, (H, W, 3) RGB."""
        frame = self._av.VideoFrame.from_ndarray(image, format="rgb24")
        for packet in self._stream.encode(frame):
            self._container.mux(packet)

    def finish(self) -> None:
        """Writes what the encoder still holds."""
        for packet in self._stream.encode():
            self._container.mux(packet)


def load_av() -> Any:
    """The module that encodes.

    Raises:
        UsageError: it is not installed, or knows no H.264.
    """
    try:
        import av  # noqa: PLC0415  # an extra
    except ImportError:
        raise UsageError("videos need PyAV; expected the extra: pip install 'graspcell[video]'") from None
    if _CODEC not in av.codecs_available:
        raise UsageError(f"expected a PyAV that encodes by {_CODEC}, got version {av.__version__} without it")
    return av


@contextmanager
def mp4(path: Path, size: tuple[int, int], frames_per_second: int) -> Iterator[Writer]:
    """A file to write pictures to; it replaces an earlier one when all are written.

    Args:
        path: the file.
        size: height and width, px, both even.
        frames_per_second: of the video.

    Raises:
        UsageError: it cannot be written, or PyAV is missing.
    """
    av = load_av()
    with replacing(path) as file, av.open(file, "w", format="mp4") as container:
        stream = container.add_stream(_CODEC, rate=Fraction(frames_per_second))
        stream.height, stream.width = size
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": str(CRF), "preset": "veryfast"}
        writer = Writer(av, container, stream)
        yield writer
        writer.finish()
