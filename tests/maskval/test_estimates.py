import numpy as np

from maskval import Estimates, Pose
from tests.maskval import shapes
from tests.maskval.shapes import VGA


def test_masks_that_nobody_can_write_to_are_shared_and_others_copied() -> None:
    X_CO = Pose.from_translation((0, 0, 0.6))
    masks = np.zeros((1, 480, 640), dtype=bool)
    view = masks.view()
    view.setflags(write=False)
    for writable in (masks, view):  # what the view shows can still be written to
        made = Estimates(VGA, shapes.square(), writable, ((X_CO,),), np.ones(1))
        assert not made.masks.flags.writeable
        masks[0, 0, 0] = not masks[0, 0, 0]
        assert made.masks[0, 0, 0] != masks[0, 0, 0]
    masks.setflags(write=False)
    assert Estimates(VGA, shapes.square(), masks, ((X_CO,),), np.ones(1)).masks is masks
