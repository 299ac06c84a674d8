"""Text and colours of a video; OpenCV draws ASCII only. Colours are RGB."""

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Outcome

Image = NDArray[np.uint8]
Color = tuple[int, int, int]

BLACK, WHITE, GREY, DARK = (0, 0, 0), (255, 255, 255), (172, 178, 186), (26, 29, 34)
GREEN, RED, AMBER, BLUE = (60, 176, 96), (222, 66, 60), (240, 172, 48), (96, 170, 226)
MASK, MODEL = (255, 140, 26), (40, 220, 255)  # the detected mask, and the model at the estimated pose

_FONT = cv2.FONT_HERSHEY_SIMPLEX
_CAPITAL = 21.0  # px: height of a capital at a scale of 1


def write(image: Image, text: str, left_base: tuple[int, int], *, height: float, color: Color, width: float) -> int:
    """Draws a line of text; returns its width, px.

    Args:
        image: it is drawn into this.
        text: ASCII.
        left_base: where it begins, px (u, v of the base line).
        height: of a capital, px; less where the text would be too wide.
        color: of the text.
        width: the most it may take, px.
    """
    scale = height / _CAPITAL
    thickness = max(1, round(2 * scale))
    (wide, _), _ = cv2.getTextSize(text, _FONT, scale, thickness)
    if wide > width:
        scale *= width / wide
    cv2.putText(image, text, left_base, _FONT, scale, color, thickness, cv2.LINE_AA)
    return int(min(wide, width))


def tint(image: Image, mask: NDArray[np.bool_], color: Color, share: float = 0.35) -> None:
    """Mixes a colour into what a mask covers, by its share."""
    image[mask] = np.rint((1 - share) * image[mask] + share * np.array(color)).astype(np.uint8)


def outline(image: Image, mask: NDArray[np.bool_], color: Color, thickness: int) -> None:
    """Draws the outline of a mask, so many pixels thick."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(image, found, -1, color, thickness, cv2.LINE_AA)


def label(image: Image, text: str, left_top: tuple[int, int], *, height: float, color: Color, ground: Color) -> None:
    """Draws a line of text on a box of a colour, which it makes as wide as it must be."""
    scale = height / _CAPITAL
    thickness = max(1, round(2 * scale))
    (wide, _), _ = cv2.getTextSize(text, _FONT, scale, thickness)
    (left, top), pad = left_top, round(0.7 * height)
    cv2.rectangle(image, (left, top), (left + wide + 2 * pad, top + round(height) + 2 * pad), ground, cv2.FILLED)
    base = (left + pad, top + round(height) + pad)
    cv2.putText(image, text, base, _FONT, scale, color, thickness, cv2.LINE_AA)


def ascii_of(text: str) -> str:
    """The text in signs that OpenCV can draw."""
    for sign, plain in (("≤", "<="), ("≥", ">="), ("×", "x"), ("−", "-"), ("°", " deg")):
        text = text.replace(sign, plain)
    return text.encode("ascii", "replace").decode()


def color_of(outcome: Outcome | None) -> Color:
    """Green for a placed part, red for what counts as failed, amber for what only cost time."""
    if outcome is None:
        return AMBER
    if outcome.is_true_positive:
        return GREEN
    return RED if outcome.is_false_positive else AMBER
