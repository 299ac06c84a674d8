"""Axes and marks of a chart as SVG; colours are the page's, by class, so that they follow dark and light."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from html import escape

Scale = Callable[[float], float]
Points = Iterable[tuple[float, float]]


def linear(low: float, high: float, start: float, end: float) -> Scale:
    """From values to pixels; values beyond the ends stay at them."""
    span = (high - low) or 1.0
    return lambda value: start + (end - start) * min(1.0, max(0.0, (value - low) / span))


def logarithmic(low: float, high: float, start: float, end: float) -> Scale:
    """The same, equal ratios being equally far apart; both ends above 0."""
    inner = linear(math.log(low), math.log(high), start, end)
    return lambda value: inner(math.log(max(value, low)))


@dataclass(slots=True)
class Plot:
    """A chart under construction.

    Attributes:
        width: px of its own coordinates; the page scales it.
        height: px.
        x: from values to px.
        y: likewise.
        box: left, top, right and bottom of the area that is drawn in, px.
        marks: what has been drawn.
    """

    width: int
    height: int
    x: Scale
    y: Scale
    box: tuple[int, int, int, int]
    marks: list[str] = field(default_factory=list)

    def x_axis(self, ticks: Sequence[float], name: str, text: Callable[[float], str] = "{:g}".format) -> None:
        """Ticks below with their grid lines, and the axis's name."""
        left, top, right, bottom = self.box
        for tick in ticks:
            place = self.x(tick)
            self.marks.append(f'<path class="grid" d="M{place:.1f} {top}V{bottom}"/>')
            self.text(place, bottom + 14, text(tick), anchor="middle")
        self.text((left + right) / 2, bottom + 30, name, anchor="middle", kind="name")

    def y_axis(self, ticks: Sequence[float], name: str, text: Callable[[float], str] = "{:g}".format) -> None:
        """Ticks at the left with their grid lines, and the axis's name above."""
        left, top, right, _ = self.box
        for tick in ticks:
            place = self.y(tick)
            self.marks.append(f'<path class="grid" d="M{left} {place:.1f}H{right}"/>')
            self.text(left - 6, place + 4, text(tick), anchor="end")
        self.text(left, top - 8, name, kind="name")

    def text(self, x: float, y: float, text: str, *, anchor: str = "start", kind: str = "tick") -> None:
        """A line of text."""
        self.marks.append(f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>')

    def line(self, points: Points, kind: str) -> None:
        """A line through points given in values."""
        path = "L".join(f"{self.x(a):.1f} {self.y(b):.1f}" for a, b in points)
        if path:
            self.marks.append(f'<path class="line {kind}" d="M{path}"/>')

    def dots(self, points: Points, kind: str) -> None:
        """Dots at points given in values: one path, however many there are."""
        path = "".join(f"M{self.x(a):.1f} {self.y(b):.1f}h0" for a, b in points)
        if path:
            self.marks.append(f'<path class="dots {kind}" d="{path}"/>')

    def svg(self, title: str) -> str:
        """The chart as an element."""
        return (
            f'<svg viewBox="0 0 {self.width} {self.height}" role="img" aria-label="{escape(title)}">'
            f"{''.join(self.marks)}</svg>"
        )


def figure(title: str, body: str, caption: str, kind: str = "") -> str:
    """A chart, or several, with a title and a line that says how to read it."""
    return (
        f'<figure class="{kind}"><h4>{escape(title)}</h4><div class="plots">{body}</div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def steps(low: float, high: float, most: int = 6) -> list[float]:
    """Round values between two ends, `most` at most."""
    span = (high - low) or 1.0
    step = next(
        size
        for power in range(-6, 7)
        for size in (10.0**power, 2 * 10.0**power, 5 * 10.0**power)
        if span / size <= most - 1
    )
    first = math.ceil(low / step - 1e-9)
    return [round(step * number, 9) for number in range(first, math.floor(high / step + 1e-9) + 1)]
