"""The success of grasps at one size of pose error, and the curve of them as text."""

from collections.abc import Sequence
from dataclasses import dataclass

from cell.interfaces import Outcome


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """All trials of one part at one error; rates in [0, 1].

    Attributes:
        object: name of the part.
        mdd_mm: error, mm.
        trials: how many.
        placed: how many ended with the part in its slot.
        rate: share of them.
        rate_ci: its 95 % Clopper-Pearson interval.
        outcomes: how many ended how.
    """

    object: str
    mdd_mm: float
    trials: int
    placed: int
    rate: float
    rate_ci: tuple[float, float] | None
    outcomes: dict[str, int]


def format_curve(levels: Sequence[CurvePoint]) -> str:
    """The curve as text, one line per part and error."""
    lines = [f"{'object':10} {'MDD mm':>7} {'placed':>9} {'%':>6} {'[95 %]':>8}  what came of the others"]
    for level in levels:
        others = ", ".join(f"{count} {name}" for name, count in level.outcomes.items() if name != Outcome.PLACED.value)
        low, high = level.rate_ci or (0.0, 1.0)
        lines.append(
            f"{level.object:10} {level.mdd_mm:7g} {level.placed:4}/{level.trials:<4} {100 * level.rate:6.1f} "
            f"{100 * low:4.0f}–{100 * high:<3.0f}  {others}"
        )
    return "\n".join(lines)
