import sys
from pathlib import Path

import av
import numpy as np
import pytest

from experiments.errors import UsageError
from experiments.exporting.mp4 import check_av, opened_mp4


def test_a_video_has_every_picture_at_its_time(tmp_path: Path) -> None:
    file, greys = tmp_path / "new" / "video.mp4", [20, 90, 160, 230, 60]
    with opened_mp4(file, 64, 48, 10) as video:
        for grey in greys:
            video.add(np.full((48, 64, 3), grey, dtype=np.uint8))
    assert video.frames == len(greys)
    with av.open(str(file)) as container:
        stream = container.streams.video[0]
        pictures = [(float(frame.time), frame.to_ndarray(format="rgb24")) for frame in container.decode(stream)]
        assert (stream.width, stream.height, stream.pix_fmt, stream.codec.canonical_name) == (64, 48, "yuv420p", "h264")
    assert [time for time, _ in pictures] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert [picture.mean() for _, picture in pictures] == pytest.approx(greys, abs=4)


def test_a_video_that_cannot_be_written_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(UsageError, match=r"cannot write .*video.mp4"),
        opened_mp4(tmp_path / "file" / "video.mp4", 8, 8, 5),
    ):
        pass


def test_without_pyav_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(UsageError, match=r"videos need PyAV; expected the extra: pip install 'graspcell\[lerobot\]'"):
        check_av()
