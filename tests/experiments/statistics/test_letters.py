from itertools import combinations

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.statistics.letters import compact_letters

NAMES = "abcdefg"


@st.composite
def tables(draw: st.DrawFn) -> tuple[dict[str, float], list[tuple[str, str]]]:
    names = NAMES[: draw(st.integers(1, len(NAMES)))]
    pairs = list(combinations(names, 2))
    different = draw(st.lists(st.sampled_from(pairs), unique=True)) if pairs else []
    return {name: draw(st.sampled_from([0.1, 0.2, 0.5])) for name in names}, different


def test_overlapping_groups_have_a_letter_each() -> None:
    # Best and worst differ; the one between them cannot be told from either.
    letters = compact_letters({"low": 0.1, "top": 0.9, "middle": 0.5}, [("top", "low")])
    assert letters == {"top": "a", "middle": "ab", "low": "b"}
    assert list(letters) == ["top", "middle", "low"]


def test_without_differences_all_share_one_letter_and_with_all_none_does() -> None:
    means = {"x": 3.0, "y": 2.0, "z": 1.0}
    assert compact_letters(means, []) == {"x": "a", "y": "a", "z": "a"}
    assert compact_letters(means, combinations(means, 2)) == {"x": "a", "y": "b", "z": "c"}
    assert compact_letters({}, []) == {}


@given(tables())
def test_two_methods_share_a_letter_if_and_only_if_they_are_not_different(table) -> None:
    means, different = table
    letters = compact_letters(means, different)
    apart = {frozenset(pair) for pair in different}
    assert letters.keys() == means.keys()
    for one, other in combinations(means, 2):
        assert bool(set(letters[one]) & set(letters[other])) == (frozenset((one, other)) not in apart)


@given(tables())
def test_letters_are_the_largest_groups_without_a_difference(table) -> None:
    # Cliques of the graph of pairs that are not told apart, by another algorithm (Bron and Kerbosch's).
    means, different = table
    graph = networkx.complement(networkx.Graph(different))
    graph.add_nodes_from(means)
    told = {node for pair in different for node in pair}
    graph.add_edges_from((a, b) for a, b in combinations(means, 2) if not {a, b} <= told)
    letters = compact_letters(means, different)
    groups = {
        letter: frozenset(name for name in means if letter in letters[name]) for letter in "".join(letters.values())
    }
    assert set(groups.values()) == {frozenset(clique) for clique in networkx.find_cliques(graph)}
    assert len(set(groups.values())) == len(groups)


@given(tables(), st.randoms(use_true_random=False))
def test_the_order_of_the_pairs_does_not_matter(table, random) -> None:
    means, different = table
    turned = [pair[::-1] for pair in different]
    random.shuffle(turned)
    assert compact_letters(means, turned) == compact_letters(means, different)


@given(tables())
def test_the_best_method_has_the_letter_a(table) -> None:
    means, different = table
    best = min(means, key=lambda name: (-means[name], name))
    letters = compact_letters(means, different)
    assert next(iter(letters)) == best
    assert "a" in letters[best]


@pytest.mark.parametrize("pair", [("x", "q"), ("x", "x")])
def test_pairs_of_other_methods_are_refused(pair: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match="expected pairs of two of y, x, got x and"):
        compact_letters({"x": 1.0, "y": 2.0}, [pair])


def test_more_groups_than_letters_are_refused() -> None:
    names = [f"m{number}" for number in range(12)]  # six pairs that differ, and nothing else: 2^6 groups
    with pytest.raises(ValueError, match="52 letters can tell apart, got 64 groups"):
        compact_letters(dict.fromkeys(names, 0.0), zip(names[::2], names[1::2], strict=True))
