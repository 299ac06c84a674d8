"""Attempts by the part that they were made for: a repeated look at an unchanged scene repeats its error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cell.interfaces import Outcome


@dataclass(frozen=True, slots=True)
class FirstAttempts:
    """What an experiment's attempts came to, each part counted once.

    An attempt is for the part that the detection's mask shows in truth, which need not be the part that the gripper
    meets. One upon a false detection, which shows none, counts as the only one for a part of its own. Attempts that
    are neither TP nor FP (void, unreachable) do not count.

    Attributes:
        parts: distinct parts with an attempt that counts.
        placed: those of which the first such attempt is a TP.
        failed: those with an FP.
    """

    parts: int
    placed: int
    failed: int

    @property
    def ap(self) -> float | None:
        """AP of the first attempts; None without one."""
        return self.placed / self.parts if self.parts else None


def first_attempts(tables: Mapping[str, Sequence[Mapping[str, Any]]]) -> FirstAttempts:
    """From the rows of one experiment's attempts and estimates, in the order of time."""
    true_part = {(row["frame"], row["detection"]): row["true_part"] for row in tables["estimates"]}
    by_part: dict[object, list[Outcome]] = {}
    for row in tables["attempts"]:
        outcome = Outcome(row["outcome"])
        if outcome.is_true_positive or outcome.is_false_positive:
            part = true_part[row["frame"], row["detection"]]
            key = ("false detection", row["attempt"]) if part is None else part
            by_part.setdefault(key, []).append(outcome)
    return FirstAttempts(
        parts=len(by_part),
        placed=sum(outcomes[0].is_true_positive for outcomes in by_part.values()),
        failed=sum(any(outcome.is_false_positive for outcome in outcomes) for outcomes in by_part.values()),
    )
