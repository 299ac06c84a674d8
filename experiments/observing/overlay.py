"""A look as a picture: what the detector found, and the model where the network estimates it."""

import numpy as np

from cell.part import Part
from cell.records import DecisionRecord
from experiments.observing.drawing import BLACK, MASK, MODEL, WHITE, Image, outline, tint, write
from maskval import silhouette
from sim.instance_ids import PIXEL_CENTER


def overlaid(picture: Image, decided: DecisionRecord, part: Part) -> Image:
    """The wrist camera's picture with every detection: its mask, the silhouette at its estimated pose, and its u.

    Args:
        picture: of the moment of the look, (H, W, 3), as large as the camera's.
        decided: the look, and the decision upon it, whose detection is drawn with thicker lines.
        part: the kind of part.
    """
    image, observation = picture.copy(), decided.observation
    for index, detection in enumerate(observation.detections):
        is_chosen = index == decided.decision.detection
        mask = detection.mask
        tint(image, mask, MASK)
        seen = silhouette(part.mesh, observation.poses[0][index], observation.frame.camera, pixel_center=PIXEL_CENTER)
        for shape, color, thickness in ((mask, MASK, 5 if is_chosen else 2), (seen.mask, MODEL, 2 if is_chosen else 1)):
            outline(image, shape, color, thickness)
        rows, columns = np.nonzero(mask)
        if len(rows):
            width = image.shape[1] - 140
            place = int(np.clip(columns.min(), 4, width)), int(np.clip(rows.min() - 8, 24, image.shape[0] - 8))
            text, size = f"u {observation.uncertainties[index]:.2f}", 17 if is_chosen else 13
            write(image, text, (place[0] + 1, place[1] + 1), height=size, color=BLACK, width=130)
            write(image, text, place, height=size, color=WHITE, width=130)
    return image
