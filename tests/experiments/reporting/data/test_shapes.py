import re

import numpy as np

from cell.part import Part
from experiments.reporting.data.shapes import outline, projected, silhouette_outline
from maskval import Camera, Mesh, Pose, mask_iou, silhouette
from sim.instance_ids import PIXEL_CENTER
from tests.experiments.reporting.data.drawn import filled
from tests.maskval import shapes

CAMERA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)


def test_the_outline_of_a_square_is_its_corners() -> None:
    mask = np.zeros((480, 640), dtype=bool)
    mask[100:141, 200:261] = True
    assert outline(mask) == "M200,100l0,40 60,0 0-40z"


def test_an_empty_mask_has_no_outline() -> None:
    assert outline(np.zeros((480, 640), dtype=bool)) == ""


def test_holes_stay_holes() -> None:
    mask = np.zeros((480, 640), dtype=bool)
    mask[100:200, 100:200] = True
    mask[140:160, 140:160] = False
    assert len(re.findall("M", outline(mask))) == 2
    assert not filled(outline(mask))[150, 150]


def test_an_outline_that_is_filled_is_the_silhouette_again() -> None:
    vertices, faces = shapes.star()
    part = Part("star", Mesh(vertices, faces), (), (0.1, 0.1))
    pose = Pose.from_translation((0.02, 0.01, 0.5))
    mask = silhouette(part.mesh, pose, CAMERA, pixel_center=PIXEL_CENTER).mask
    assert mask_iou(filled(silhouette_outline(part, pose, CAMERA)), mask) > 0.97


def test_a_model_upon_its_own_mask_has_a_c_of_1_and_half_beyond_the_picture_a_v_of_a_half() -> None:
    box = shapes.cube()
    part = Part("box", box, (), (0.1, 0.1))
    for x, v in ((0.0, 1.0), (-0.5 * 640 / 600, 0.5)):
        pose = Pose.from_translation((x, 0.0, 1.0))
        mask = silhouette(box, pose, CAMERA, pixel_center=PIXEL_CENTER).mask
        seen = projected(part, pose, mask, CAMERA)
        assert seen.c == 1.0
        assert abs(seen.v - v) < 0.1
