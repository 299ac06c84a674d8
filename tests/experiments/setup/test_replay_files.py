"""Recordings whose numbers were spoilt."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cell.layout import Layout
from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from experiments.setup.replay import load_recording
from sim.model.parts import load_part

SETUP = EstimatorSetup(load_part("handle").part, Layout().camera, 0.5, seed=5, experiment=0)
POSE = [0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0]
WHOLE = 480 * 640


def write(folder: Path, mask_rle: list[int], X_CO_est: list[float]) -> None:
    key: dict[str, Any] = {"object": "handle", "method": "maskval", "experiment": 0, "frame": 3}
    frame = key | {"X_BC": POSE, "detections": 1, "inference_s": 0.5}
    estimate = key | {"mask_rle": mask_rle, "score": 1.0, "X_CO_est": X_CO_est, "X_CO_est_2": None}
    for name, row in (("frames", frame), ("estimates", estimate)):
        pq.write_table(pa.Table.from_pylist([row]), folder / f"{name}.parquet")


def test_a_recorded_mask_fills_the_image(tmp_path: Path) -> None:
    write(tmp_path, [WHOLE], POSE)
    assert len(load_recording(tmp_path, SETUP, "maskval").networks) == 1


@pytest.mark.parametrize(
    ("mask_rle", "X_CO_est", "words"),
    [
        # The sum is that of the image in 64 bits.
        (
            [2**62, 2**62, 2**62, 2**62 + WHOLE],
            POSE,
            f"counts must add up to 480 x 640 = {WHOLE}, but to {2**64 + WHOLE}",
        ),
        ([WHOLE], [0.0, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0], "quaternion_wxyz must have norm 1"),
    ],
)
def test_a_spoilt_mask_or_pose_is_refused_with_its_experiment_and_frame(
    tmp_path: Path, mask_rle: list[int], X_CO_est: list[float], words: str
) -> None:
    write(tmp_path, mask_rle, X_CO_est)
    with pytest.raises(UsageError, match=f"handle × maskval, experiment 0: frame 3: {words}"):
        load_recording(tmp_path, SETUP, "maskval")
