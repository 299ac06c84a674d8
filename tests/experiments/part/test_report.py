import numpy as np
import pytest
import trimesh

from cell.part import Grasp, Part
from experiments.part.report import out_of_reach, why_uncovered
from maskval import Mesh, Pose
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


FROM_ABOVE = Pose.from_rotvec((np.pi, 0.0, 0.0))


@pytest.mark.parametrize(
    ("X_OT", "words"),
    [
        (FROM_ABOVE, ()),
        (FROM_ABOVE @ Pose.from_rotvec((0.0, 1.1, 0.0)), ("poses[0]: the arm reaches", "60.0% of them, on 9", " only")),
        (Pose.from_translation((0.0, 0.0, 2.0)) @ FROM_ABOVE, ("poses[0]: ", "60.0% of them, nowhere on the belt")),
        (Pose.identity(), ()),  # no grasp from above: another line says so
    ],
    ids=["in reach", "tilted", "far up", "from below"],
)
def test_a_stable_pose_whose_grasp_is_out_of_reach_is_said_to_be_so(X_OT: Pose, words: tuple[str, ...]) -> None:
    box = trimesh.creation.box((0.1, 0.05, 0.02))
    part = Part("box", Mesh(box.vertices, box.faces), (Grasp("one", X_OT, 0.03, 1.2),), (0.2, 0.2))
    told = out_of_reach(part, [RestingPose.from_up(np.array([0.0, 0.0, 1.0]), box.vertices, 0.6)])
    assert len(told) == (1 if words else 0)
    assert all(word in told[0] for word in words)
