"""One experiment in one part of the picture: overview, wrist camera, newest look, and a bar that says what happens."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from cell.records import DecisionRecord
from experiments.observing.drawing import (
    BLUE,
    DARK,
    GREY,
    MASK,
    MODEL,
    WHITE,
    Image,
    ascii_of,
    color_of,
    label,
    write,
)
from experiments.observing.looks import Looks
from experiments.observing.observer import Status
from experiments.observing.take import Take
from experiments.observing.words import in_words, just_ended, slot_in_words
from sim.runtime.pictures import SHADOWS, Pictures

_QUICK_SHADOWS = 1024, 0  # px, of overview and wrist camera; of pictures that are no mean


@dataclass(slots=True, eq=False)
class _Cameras:
    """The pictures of one experiment; those of a moment at which nothing has moved are kept."""

    overview: Pictures
    wrist: Pictures
    looks: Looks
    shown: dict[str, tuple[bytes, Image]] = field(default_factory=dict)


class Tile:
    """Draws an experiment at any time.

    Args:
        taken: the experiment.
        height: of the overview, px, a multiple of 12; the tile is twice as wide, and higher by its bar.
        samples: per pixel; with 1, shadows are coarse, and the wrist camera's picture has none.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """

    def __init__(self, taken: Take, height: int, samples: int) -> None:
        self._taken, self._height, self.bar = taken, height, 2 * round(0.06 * height)
        world, half = taken.world, height // 2
        shadows = _QUICK_SHADOWS if samples == 1 else (SHADOWS, SHADOWS)
        self._cameras = _Cameras(
            Pictures(world, height, 4 * height // 3, samples, shadows=shadows[0]),
            Pictures(world, half, 2 * height // 3, samples, shadows=shadows[1]),
            Looks(world),
        )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of its pictures."""
        return self._height + self.bar, 2 * self._height, 3

    def close(self) -> None:
        """Gives the OpenGL contexts back."""
        for pictures in (self._cameras.overview, self._cameras.wrist, self._cameras.looks):
            pictures.close()

    def draw(self, time: float) -> Image:
        """The experiment at a time, s."""
        taken, height, half = self._taken, self._height, self._height // 2
        status, wide = taken.observer.at(time), 4 * self._height // 3
        image = np.full(self.shape, DARK, dtype=np.uint8)
        image[self.bar :, :wide] = self._seen("overview", time)
        image[self.bar : self.bar + half, wide:] = self._seen("wrist", time)
        if status.decided is not None:
            look = self._look_of(status.decided)
            image[self.bar + half :, wide:] = cv2.resize(
                look, (2 * height - wide, height - half), interpolation=cv2.INTER_AREA
            )
        cv2.line(image, (wide, self.bar), (wide, height + self.bar), DARK, 2)
        cv2.line(image, (wide, self.bar + half), (2 * height, self.bar + half), DARK, 2)
        self._write_bar(image, status, time)
        self._write_panels(image, status, time)
        return image

    def _seen(self, camera: str, time: float) -> Image:
        positions = self._taken.film.at(time)
        key = np.round(positions, 4).tobytes()
        kept = self._cameras.shown.get(camera)
        if kept is None or kept[0] != key:
            pictures = self._cameras.overview if camera == "overview" else self._cameras.wrist
            kept = self._cameras.shown[camera] = key, pictures.rgb(camera, positions)
        return kept[1]

    def _look_of(self, decided: DecisionRecord) -> Image:
        return self._cameras.looks.overlaid(decided, self._taken.film.at(decided.observation.frame.time))

    def _write_bar(self, image: Image, status: Status, time: float) -> None:
        """What is run, the clock, the slot and the state; and the newest decision."""
        height, bar, spec = self._height, self.bar, self._taken.spec
        middle, margin = round(1.22 * height), round(0.25 * bar)
        first, second = round(0.42 * bar), round(0.85 * bar)
        part = self._taken.part.name
        how = spec.method if spec.policy is None else f"{spec.method}, {spec.policy}"
        doing = f"{status.state}: {status.reason}" if status.reason else f"{status.state}"
        decision = "" if status.decided is None else in_words(status.decided)
        for text, place, color in (
            (f"{part}  |  {how}  |  experiment {spec.experiment}", (margin, first), WHITE),
            (doing, (margin, second), GREY),
            (f"{time:6.2f} s   {slot_in_words(status, spec.parts)}", (middle, first), WHITE),
            (decision, (middle, second), BLUE),
        ):
            end = middle if place[0] == margin else 2 * height
            write(image, ascii_of(text), place, height=0.24 * bar, color=color, width=end - place[0] - margin)

    def _write_panels(self, image: Image, status: Status, time: float) -> None:
        """What the right-hand panels show, a box per time slot, and the outcome where an attempt has just ended."""
        height, bar = self._height, self.bar
        small, pad = 0.018 * height + 3, round(0.02 * height)
        right, top = 4 * height // 3 + pad, bar + pad // 2
        label(image, "wrist camera", (right, top), height=small, color=WHITE, ground=DARK)
        if status.decided is not None:
            seen = f"look at {status.decided.observation.frame.time:.2f} s"
            label(image, seen, (right, top + height // 2), height=small, color=WHITE, ground=DARK)
            low = bar + height - round(2.4 * small)
            image[low:, 4 * height // 3 + 2 :] = DARK
            base, middle = low + round(1.7 * small), right + round(0.22 * height)
            write(image, "detected mask", (right, base), height=small, color=MASK, width=0.2 * height)
            text = "model at the estimated pose"
            write(image, text, (middle, base), height=small, color=MODEL, width=2 * height - middle - pad)
        side, low = round(0.045 * height), bar + height - pad
        for slot, outcome in enumerate(status.slots):
            left = pad + slot * (side + pad // 3)
            cv2.rectangle(image, (left, low - side), (left + side, low), color_of(outcome), cv2.FILLED)
            place = (left + side // 4, low - side // 4)
            write(image, str(slot), place, height=0.5 * side, color=WHITE, width=side)
        ended = just_ended(status, time)
        if ended is not None:
            words, outcome = ended
            label(image, words, (pad, bar + pad), height=0.032 * height, color=WHITE, ground=color_of(outcome))
