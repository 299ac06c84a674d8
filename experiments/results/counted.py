"""What the tables need of an experiment that has ended."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cell.interfaces import Outcome
from cell.records import Tally
from experiments.results.first_attempts import FirstAttempts

Of = tuple[str, str, str]  # object, method, policy


@dataclass(frozen=True, slots=True)
class Counted:
    """An experiment's counts.

    Attributes:
        of: object, method and policy.
        experiment: its number.
        world: equal for experiments with the same error model of a domain gap, which are not independent.
        count: what it came to; None if it failed.
        first: its first attempts; None if it failed.
        placed: whether each of its parts was placed; empty if it failed.
        failure: why it failed; None if it did not.
    """

    of: Of
    experiment: int
    world: Hashable
    count: Tally | None
    first: FirstAttempts | None
    placed: tuple[bool, ...] = ()
    failure: str | None = None


def parts_placed(tables: Mapping[str, Sequence[Mapping[str, Any]]], parts: int) -> tuple[bool, ...]:
    """Whether each part was placed, from the rows of one experiment's attempts and estimates.

    The part of an attempt is the one that the detection's mask shows in truth. One upon a false detection shows none.
    """
    true_part = {(row["frame"], row["detection"]): row["true_part"] for row in tables["estimates"]}
    placed = {
        true_part[row["frame"], row["detection"]]
        for row in tables["attempts"]
        if Outcome(row["outcome"]).is_true_positive
    }
    return tuple(part in placed for part in range(parts))
