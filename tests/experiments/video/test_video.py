"""`graspcell video`: the file, what it shows, and what is refused."""

import sys
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from cell.interfaces import Outcome
from experiments.video.drawing import AMBER, GREEN, MASK, MODEL, RED, ascii_of, color_of
from experiments.video.overlay import overlaid
from maskval import silhouette
from sim.instance_ids import PIXEL_CENTER
from tests.experiments.command import command
from tests.experiments.video.test_take import SPEC, take

SHORT = ("--parts", 1, "--estimator", "oracle", "--samples", 1, "--speed-up", 20, "--frames-per-second", 4)


def frames_of(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert stream.average_rate == 4
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_two_methods_stand_one_below_the_other_and_end_with_their_outcome(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "cell.mp4"
    told = command(capsys, "video", "--object", "handle", "--methods", "none", "maskval", *SHORT, "--out", path)
    assert (told.code, told.out, told.err.strip()) == (0, f"video in {path}\n", "")
    frames = frames_of(path)
    assert (
        4 + 1 < len(frames) < 4 + 1 + 20 / 5
    )  # one second of standing still; a part takes less than 20 s, 5 s a frame
    assert frames[0].shape == (2 * 672, 1200, 3)  # 600 px and a bar of 72, twice
    for tile in (slice(0, 672), slice(672, 1344)):
        assert np.abs(frames[0][tile].astype(int) - frames[-1][tile]).max() > 100
        square = frames[-1][tile][672 - 12 - 25 : 672 - 14, 14:18]  # the box of the first part
        assert np.abs(square.mean(axis=(0, 1)) - GREEN).max() < 12


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--speed-up", 0), "expected --speed-up within 0.1 and 20, got 0"),
        (("--frames-per-second", 61), "expected --frames-per-second within 1 and 60, got 61"),
        (("--samples", 0), "expected --samples within 1 and 64, got 0"),
        (("--out", "cell.gif"), "expected --out to end in .mp4, got cell.gif"),
        (("--methods", "none", "none"), "expected different values for --methods, got none none"),
        (("--attempt", -1), "expected --attempt of at least 0"),
    ],
)
def test_bad_options_are_one_line(capsys: pytest.CaptureFixture[str], options: tuple[Any, ...], words: str) -> None:
    told = command(capsys, "video", *options)
    assert told.code == 2
    assert words in told.err
    assert len(told.err.strip().splitlines()) == 1


def test_without_pyav_the_extra_is_named_before_anything_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setattr("experiments.video.make.take", lambda _: pytest.fail("an experiment was run"))
    told = command(capsys, "video", "--out", tmp_path / "cell.mp4")
    assert told.code == 2
    assert "videos need PyAV; expected the extra: pip install 'graspcell[video]'" in told.err


def test_an_attempt_that_never_was_names_those_that_were_and_leaves_no_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = command(capsys, "video", *SHORT, "--methods", "none", "--attempt", 5, "--out", tmp_path / "cell.mp4")
    assert told.code == 2
    assert "expected --attempt in 0..0 for antenna × none, experiment 0, got 5" in told.err
    assert list(tmp_path.iterdir()) == []


def test_a_look_shows_mask_and_model_where_they_are() -> None:
    taken = take(SPEC)
    decided = next(one for one in (status.decided for status in taken.history) if one and one.decision.detection == 0)
    part, observation = taken.cell.world.part_model.part, decided.observation
    black = np.zeros((480, 640, 3), np.uint8)
    image = overlaid(black, decided, part)
    assert not black.any()
    detection, pose = observation.detections[0], observation.poses[0][0]
    model = silhouette(part.mesh, pose, observation.frame.camera, pixel_center=PIXEL_CENTER).mask
    inside = np.zeros_like(model)
    inside[8:-8, 8:-8] = True
    for shape, color in ((detection.mask, MASK), (model, MODEL)):
        drawn = np.abs(image.astype(int) - color).max(axis=2) < 10
        assert drawn.sum() > 50
        near = np.zeros_like(shape)
        for one in observation.detections if color == MASK else ():
            near |= one.mask
        for one in observation.poses[0] if color == MODEL else ():
            near |= silhouette(part.mesh, one, observation.frame.camera, pixel_center=PIXEL_CENTER).mask
        rows, columns = np.nonzero(drawn & inside)
        assert all(near[v - 4 : v + 5, u - 4 : u + 5].any() for v, u in zip(rows, columns, strict=True))


def test_outcomes_have_the_colour_of_how_they_count() -> None:
    assert color_of(Outcome.PLACED) == GREEN
    assert {color_of(one) for one in Outcome if one.is_false_positive} == {RED}
    assert {color_of(one) for one in (Outcome.VOID, Outcome.UNREACHABLE, None)} == {AMBER}


def test_text_is_ascii_as_opencv_draws_it() -> None:
    assert ascii_of("u ≤ 0.3, 2 × 30°, −1 N") == "u <= 0.3, 2 x 30 deg, -1 N"
    assert ascii_of("é") == "?"
