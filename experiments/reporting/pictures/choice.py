"""Which attempts and time-outs get pictures: failures first, of every method, in few experiments."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, zip_longest

from experiments.reporting.data.happened import Rows

Place = tuple[int, int]  # of an item: number of its experiment in the list, and number of the item in that
_FAILURES = ("failed", "time-out")


def chosen(experiments: Sequence[Rows], most: int) -> list[Place]:
    """The items to picture, `most` at most.

    The methods take turns, each with the experiment of its most failures first. The failures of an experiment are
    taken, then those of the next; what is left goes to the other items of the experiments that were taken.

    Args:
        experiments: as the page has them.
        most: how many items.
    """
    groups: dict[tuple[str, str, str], list[int]] = {}
    for number, one in enumerate(experiments):
        if one["failure"] is None:
            groups.setdefault((one["o"], one["m"], one["p"]), []).append(number)
    ranked = [
        sorted(group, key=lambda number: -len(_items(experiments[number], failures=True))) for group in groups.values()
    ]
    turns = [number for turn in zip_longest(*ranked) for number in turn if number is not None]
    failures = [_places(experiments, number, failures=True) for number in turns]
    taken = list(chain.from_iterable(failures))[:most]
    known = dict.fromkeys(number for number, _ in taken) or dict.fromkeys(turns[: len(groups)])
    others = zip_longest(*(_places(experiments, number, failures=False) for number in known))
    rest = [place for turn in others for place in turn if place is not None]
    return [*taken, *rest[: most - len(taken)]]


def by_experiment(places: Sequence[Place]) -> Mapping[int, list[int]]:
    """The items to picture of each experiment."""
    found: dict[int, list[int]] = {}
    for number, item in places:
        found.setdefault(number, []).append(item)
    return found


def _places(experiments: Sequence[Rows], number: int, *, failures: bool) -> list[Place]:
    return [(number, item) for item in _items(experiments[number], failures=failures)]


def _items(experiment: Rows, *, failures: bool) -> list[int]:
    """Those that have failed, or the others, that were made for a detection."""
    return list(_of_kind(experiment, failures))


def _of_kind(experiment: Rows, failures: bool) -> Iterator[int]:
    for number, item in enumerate(experiment["items"]):
        if "f" in item and (item["k"] in _FAILURES) == failures:
            yield number
