"""The Rerun file, read back. The reader is large: it is not among what the tests install."""

from pathlib import Path

import pytest

from experiments.observing.take import Take
from experiments.viewing.recording import TIMELINE, write_recording


@pytest.mark.study
def test_a_recording_has_bodies_looks_and_decisions_on_one_timeline(taken: Take, tmp_path: Path) -> None:
    from rerun.chunk import RrdReader  # noqa: PLC0415  # an extra

    path, span = tmp_path / "cell.rrd", taken.span(None)
    write_recording(taken, path, span=span, interval=0.5)
    rows: dict[str, int] = {}
    for chunk in RrdReader(path).stream():
        if not chunk.is_static:
            name = str(chunk.entity_path)
            rows[name] = rows.get(name, 0) + chunk.num_rows
            assert TIMELINE in chunk.timeline_names
    looks, moments = len(taken.observer.decisions()), 1 + -int(-(span[1] / 0.5) // 1)
    assert looks >= 2
    for body in ("part_0", "part_1", "wrist"):
        assert rows[f"/world/{body}"] == moments
    for entity in ("/world/look", "/world/look/camera/picture", "/world/look/camera/masks", "/look"):
        assert rows[entity] == looks
    assert rows["/u/decided"] == sum(one.decision.detection is not None for one in taken.observer.decisions())
    assert rows["/world/estimated/0"] >= 1
    assert rows["/decisions"] > looks
