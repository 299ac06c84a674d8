"""Masks and silhouettes as outlines that a browser draws."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.part import Part
from maskval import Camera, Pose, silhouette, uncertainty
from sim.instance_ids import PIXEL_CENTER

Mask = NDArray[np.bool_]
_TOLERANCE_PX = 0.7  # by how much an outline may leave the pixels' borders: less than is seen


@dataclass(frozen=True, slots=True)
class Projected:
    """An estimated pose as its detection's camera sees it.

    Attributes:
        model: outline of the silhouette.
        c: intersection over union with the mask, the paper's c.
        v: share of the silhouette inside the image, the paper's v.
    """

    model: str
    c: float
    v: float


def projected(part: Part, X_CO_est: Pose, mask: Mask, camera: Camera) -> Projected:
    """The silhouette of a part at an estimated pose, and how far it agrees with the mask."""
    seen = silhouette(part.mesh, X_CO_est, camera, pixel_center=PIXEL_CENTER)
    judged = uncertainty(part.mesh, [X_CO_est], mask[None], camera, pixel_center=PIXEL_CENTER)
    return Projected(outline(seen.mask), float(judged.c[0]), float(judged.v[0]))


def silhouette_outline(part: Part, X_CO: Pose, camera: Camera) -> str:
    """The outline of a part at a pose."""
    return outline(silhouette(part.mesh, X_CO, camera, pixel_center=PIXEL_CENTER).mask)


def outline(mask: Mask) -> str:
    """A mask, (H, W), as the data of an SVG path in pixels, holes left out by the rule "evenodd"; empty for none."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    rings = [np.asarray(cv2.approxPolyDP(ring, _TOLERANCE_PX, closed=True)[:, 0], np.int32) for ring in found]
    return "".join(_ring(ring) for ring in rings if len(ring) > 2)


def _ring(points: NDArray[np.int32]) -> str:
    steps: Sequence[Sequence[int]] = np.diff(points, axis=0).tolist()
    moves = "".join(f"{dx}{',' if dy >= 0 else ''}{dy} " for dx, dy in steps).rstrip()
    return f"M{points[0, 0]},{points[0, 1]}l{moves}z"
