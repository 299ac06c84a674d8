"""Compact letter display: methods that share a letter cannot be told apart."""

from collections.abc import Iterable, Mapping
from string import ascii_letters


def compact_letters(means: Mapping[str, float], different: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The letters of each method, best first: two methods share one if, and only if, they are not told apart.

    Insert and absorb (Piepho, J. Comput. Graph. Stat. 13, 2004): every column begins with all methods. A pair that
    differs splits each column with both into one without the first and one without the second; columns within another
    are left out. A column is a letter, "a" that of the best method.

    Args:
        means: What methods are ordered by, the largest first; equal ones by name.
        different: The pairs that are significantly different.

    Raises:
        ValueError: a pair is of an unknown method or of one with itself, or there are more than 52 letters.
    """
    names = sorted(means, key=lambda name: (-means[name], name))
    rank = {name: place for place, name in enumerate(names)}
    columns = [frozenset(names)] if names else []
    for pair in different:
        if len(set(pair)) != 2 or not set(pair) <= rank.keys():
            raise ValueError(f"expected pairs of two of {', '.join(names)}, got {' and '.join(pair)}")
        columns = _absorbed(part for column in columns for part in _split(column, pair))
    columns.sort(key=lambda column: sorted(rank[name] for name in column))
    if len(columns) > len(ascii_letters):
        raise ValueError(
            f"expected methods that {len(ascii_letters)} letters can tell apart, got {len(columns)} groups"
        )
    return {
        name: "".join(letter for letter, column in zip(ascii_letters, columns, strict=False) if name in column)
        for name in names
    }


def _split(column: frozenset[str], pair: tuple[str, str]) -> list[frozenset[str]]:
    return [column - {name} for name in pair] if column.issuperset(pair) else [column]


def _absorbed(columns: Iterable[frozenset[str]]) -> list[frozenset[str]]:
    """The columns that are not within another one; each once."""
    kept = list(dict.fromkeys(columns))
    return [column for column in kept if not any(column < other for other in kept)]
