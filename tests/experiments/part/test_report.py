import numpy as np
import pytest
import trimesh

from experiments.part.report import why_uncovered
from sim.parts.stable_poses import RestingPose


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((0.1, 0.08, 0.001), "1.0 mm high, and finger tips stay 3 mm off the belt"),
        ((0.15, 0.12, 0.15), "at least 120 mm wide, and jaws go around 96 mm at most"),
        ((0.15, 0.05, 0.05), "no two opposite faces"),
    ],
)
def test_why_a_stable_pose_has_no_grasp(size: tuple[float, float, float], words: str) -> None:
    vertices = trimesh.creation.box(size).vertices
    pose = RestingPose.from_up(np.array([0.0, 0.0, 1.0]), vertices, 1.0)
    assert words in why_uncovered(vertices, pose)
