import numpy as np
import pytest
from scipy.special import hyp2f1

from experiments.errors import UsageError
from experiments.statistics.sequential import confidence_sequence
from experiments.statistics.until import Condition, judge, parse_condition


@pytest.mark.parametrize(
    ("text", "condition"),
    [
        ("ap(maskval) >= 0.99", Condition("ap", "maskval", True, 0.99, None, None)),
        ("ar(x)>0.9", Condition("ar", "x", True, 0.9, None, None)),
        (" failed( none ) <= 1.5 ", Condition("failed", "none", False, 1.5, None, None)),
        (
            "placed(maskval) > placed(ensemble-add)",
            Condition("placed", "maskval", True, None, "ensemble-add", None),
        ),
        ("failed(a)<failed(b)", Condition("failed", "a", False, None, "b", None)),
        ("handle:ap(maskval) >= 0.99", Condition("ap", "maskval", True, 0.99, None, "handle")),
        (
            "parts/my.toml:ap(my.uq:Method) > ap(none)",
            Condition("ap", "my.uq:Method", True, None, "none", "parts/my.toml"),
        ),
    ],
)
def test_a_condition_is_read_with_its_part_methods_and_direction(text: str, condition: Condition) -> None:
    assert parse_condition(text) == condition


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected a condition such as"),
        ("ap(maskval)", 'got "ap(maskval)"'),
        ("ap(maskval) == 0.9", "expected a condition such as"),
        ("ap(maskval) >= 0.9 now", "expected a condition such as"),
        ("ap() >= 0.9", "expected a condition such as"),
        ("speed(maskval) >= 0.9", 'expected ap, ar, placed or failed in "speed(maskval) >= 0.9", got speed'),
        ("placed(a) > failed(b)", 'expected placed of another method on the right of "placed(a) > failed(b)", got'),
        ("placed(a) > placed(a)", "expected placed of another method"),
        ("ap(a) >= high", 'expected a number or ap(METHOD) on the right of "ap(a) >= high", got high'),
        ("ap(a) >= 1", "expected a rate between 0 and 1"),
        ("ap(a) >= 0", "expected a rate between 0 and 1"),
        ("ap(a) >= nan", "expected a rate between 0 and 1"),
        ("ap(a) >= 99", "expected a rate between 0 and 1"),
        ("placed(a) >= -1", "expected parts per experiment, above 0"),
        ("placed(a) >= inf", "expected parts per experiment, above 0"),
    ],
)
def test_what_is_no_condition_is_refused_in_one_line(text: str, words: str) -> None:
    with pytest.raises(UsageError) as error:
        parse_condition(text)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_rate_is_answered_after_as_many_experiments_as_it_takes() -> None:
    condition, worlds = parse_condition("ap(maskval) >= 0.8"), range(200)
    assert judge(condition, [1.0] * 10, worlds=worlds, parts=8).holds is None
    found = judge(condition, [1.0, None] * 100, worlds=worlds, parts=8)
    assert found.holds is True
    assert found.experiments == 2 * len(found.observations) - 1  # every second one has no AP
    assert found.mean == 1.0
    assert found.interval() == confidence_sequence(found.observations, 0, 1)
    assert found.interval()[0] > 0.8


@pytest.mark.parametrize("text", ["ap(m) >= 0.5", "ap(m) > 0.5"])
def test_a_condition_that_fails_is_answered_too(text: str) -> None:
    found = judge(parse_condition(text), [0.1] * 100, worlds=range(100), parts=8)
    assert found.holds is False
    assert found.interval()[1] < 0.5
    contrary = judge(parse_condition("ap(m) <= 0.5"), [0.1] * 100, worlds=range(100), parts=8)
    assert (contrary.holds, contrary.experiments) == (True, found.experiments)


def test_two_methods_are_compared_experiment_by_experiment() -> None:
    rng = np.random.default_rng(4)
    base = rng.integers(0, 6, 300).astype(float)  # scatter that both share
    condition = parse_condition("placed(a) > placed(b)")
    found = judge(condition, list(base + 2), list(base), worlds=range(300), parts=8)
    assert (found.holds, found.mean) == (True, 2.0)
    # Two more of 8 grow what is staked by a quarter of it, in both halves of the capital.
    needed = next(n for n in range(99) if (1.25**n + hyp2f1(-n, 0.5, 1, -0.25)) / 2 >= 40)
    assert found.experiments == needed
    less = judge(parse_condition("failed(a) < failed(b)"), list(base + 2), list(base), worlds=range(300), parts=8)
    assert (less.holds, less.experiments) == (False, needed)


def test_experiments_that_one_method_failed_are_left_out_of_a_comparison() -> None:
    condition = parse_condition("placed(a) > placed(b)")
    found = judge(condition, [8.0, None, 7.0], [1.0, 2.0, None], worlds=range(9), parts=8)
    assert found.observations == (7.0,)
    assert (found.holds, found.experiments, found.mean) == (None, None, 7.0)
    assert judge(condition, [], [], worlds=range(9), parts=8).mean is None


def test_repeated_worlds_are_judged_by_rounds_over_all_of_them() -> None:
    found = judge(parse_condition("ap(m) >= 0.5"), [1.0] * 60, worlds=[0, 1, 2] * 20, parts=8)
    alone = judge(parse_condition("ap(m) >= 0.5"), [1.0] * 60, worlds=range(60), parts=8)
    assert found.holds is alone.holds is True
    assert found.experiments == 3 * alone.experiments


def test_a_count_that_no_experiment_can_exceed_is_refused_as_a_bound() -> None:
    with pytest.raises(UsageError, match="expected placed held against less than 8, got 8"):
        judge(parse_condition("placed(a) >= 8"), [8.0], worlds=[0], parts=8)


def test_values_of_another_method_belong_to_a_condition_that_has_one() -> None:
    with pytest.raises(ValueError, match="expected values of b, got None"):
        judge(parse_condition("placed(a) > placed(b)"), [1.0], worlds=[0], parts=8)
    with pytest.raises(ValueError, match="expected values of one method only"):
        judge(parse_condition("ap(a) > 0.5"), [1.0], [1.0], worlds=[0], parts=8)
