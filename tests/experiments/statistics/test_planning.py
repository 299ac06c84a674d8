import numpy as np
import pytest
from scipy.stats import binom, ttest_1samp
from statsmodels.stats.power import TTestPower

from experiments.statistics.pilot import Pilot
from experiments.statistics.planning import failure_free_attempts, plan_bound, plan_difference, student_power
from maskval.statistics.cluster_intervals import clustered_rate_interval

ALONE = Pilot(mean=0.4, between=2.25, within=None, worlds=20, experiments=20)
NESTED = Pilot(mean=0.4, between=0.25, within=2.0, worlds=20, experiments=60)


@pytest.mark.parametrize(("wanted", "power"), [(0.5, 0.8), (1.0, 0.9), (-3.0, 0.8), (0.1, 0.95)])
def test_the_experiments_are_as_many_as_statsmodels_says(wanted: float, power: float) -> None:
    plan = plan_difference(ALONE, wanted, power)
    theirs = TTestPower().solve_power(effect_size=abs(wanted) / 1.5, power=power, alpha=0.05)
    assert plan.experiments == plan.worlds == int(np.ceil(theirs))
    assert plan.power == student_power(wanted / 1.5 * np.sqrt(plan.experiments), plan.experiments - 1) >= power


def test_the_planned_experiments_find_the_difference_as_often_as_planned() -> None:
    rng = np.random.default_rng(1)
    plan = plan_difference(ALONE, 0.7)
    found = (ttest_1samp(rng.normal(0.7, 1.5, (4000, plan.experiments)), 0, axis=1).pvalue <= 0.05).mean()
    assert found == pytest.approx(plan.power, abs=3 * np.sqrt(0.16 / 4000))


@pytest.mark.parametrize(("better", "worse"), [(0.95, 0.9), (0.99, 0.97)])
def test_counts_of_parts_have_the_planned_power_at_least_and_half_as_many_do_not(better: float, worse: float) -> None:
    # Parts placed of 8, both methods with three quarters of the luck in common.
    rng = np.random.default_rng(2)

    def differences(shape: tuple[int, ...]) -> np.ndarray:
        luck = rng.random((*shape, 8))
        other = np.where(rng.random(luck.shape) < 0.75, luck, rng.random(luck.shape))
        return (luck < better).sum(-1) - (other < worse).sum(-1)

    pilot = Pilot(0.0, float(differences((200_000,)).var()), None, 20, 20)
    plan = plan_difference(pilot, 8 * (better - worse))
    found, with_half = (
        (ttest_1samp(differences((2000, count)), 0, axis=1).pvalue <= 0.05).mean()
        for count in (plan.experiments, plan.experiments // 2)
    )
    assert found >= plan.power - 3 * np.sqrt(0.16 / 2000)
    assert with_half < 0.8


def test_few_worlds_need_more_experiments_and_reach_the_planned_power() -> None:
    rng = np.random.default_rng(3)
    plan = plan_difference(NESTED, 0.5, worlds=20)
    assert plan.experiments > plan_difference(NESTED, 0.5).experiments
    assert (plan.worlds, plan.experiments % 20) == (20, 0)
    means = rng.normal(0.5, np.sqrt(0.25), (4000, 20))
    means += rng.normal(0, np.sqrt(2.0 / (plan.experiments / 20)), means.shape)
    assert (ttest_1samp(means, 0, axis=1).pvalue <= 0.05).mean() == pytest.approx(plan.power, abs=0.02)
    fewer = student_power(0.5 / np.sqrt((0.25 + 2.0 / (plan.experiments / 20 - 1)) / 20), 19)
    assert fewer < 0.8 <= plan.power


def test_a_difference_that_worlds_hide_is_out_of_reach_of_any_number_of_experiments() -> None:
    # 10 worlds of variance .25: a standard error of .158 at best, and .3 is 1.9 of them.
    plan = plan_difference(NESTED, 0.3, worlds=10)
    assert plan.experiments is None
    assert plan.power == pytest.approx(student_power(0.3 / np.sqrt(0.025), 9))
    assert plan.power < 0.8


def test_worlds_that_do_not_differ_cost_no_more_than_the_fewer_degrees_of_freedom() -> None:
    # A standard error of 1 / (t.975 + t.8) is needed: of 19 degrees of freedom 2.093 + 0.861, of many 1.960 + 0.842.
    few = plan_difference(Pilot(0.4, 0.0, 2.0, 20, 60), 0.1, worlds=20).experiments
    many = plan_difference(Pilot(0.4, 2.0, None, 20, 20), 0.1).experiments
    assert few == pytest.approx(many * (2.954 / 2.802) ** 2, abs=20)


@pytest.mark.parametrize(("distance", "freedom"), [(0.0, 5), (2.5, 1), (3.0, 19), (1.0, 400)])
def test_the_power_of_students_test_is_that_of_simulation_free_statsmodels(distance: float, freedom: int) -> None:
    count = freedom + 1
    theirs = TTestPower().power(distance / np.sqrt(count), count, 0.05)
    assert student_power(distance, freedom) == student_power(-distance, freedom) == pytest.approx(theirs, abs=1e-6)
    assert student_power(np.inf, freedom) > 0.98


def test_299_attempts_without_a_failure_show_99_percent() -> None:
    assert failure_free_attempts(0.99) == 299
    assert 0.99**299 <= 0.05 < 0.99**298
    assert failure_free_attempts(0.5, 0.5) == 1
    plan = plan_bound(0.99, 1.0, attempts_each=8, correlation=0.0)
    assert (plan.attempts, plan.failures, plan.power) == (299, 0, 1.0)


def test_without_failures_the_table_takes_attempts_of_an_experiment_to_be_correlated_by_a_half() -> None:
    # 8 attempts count as 8 / 4.5, and log(.05) / log(.99) = 298.07 must: 167.7 experiments.
    assert plan_bound(0.99, 1.0, attempts_each=8, correlation=0.0).experiments == 168


@pytest.mark.parametrize(("bound", "expected", "power"), [(0.9, 0.97, 0.8), (0.95, 0.99, 0.9), (0.5, 0.9, 0.8)])
def test_no_fewer_attempts_show_the_bound_with_the_power(bound: float, expected: float, power: float) -> None:
    def reached(attempts: int) -> float:
        """Chance that Clopper and Pearson's lower limit of the successes is not below the bound."""
        successes = np.arange(attempts + 1)
        shown = binom.sf(successes - 1, attempts, bound) <= 0.05
        return float(binom.pmf(successes, attempts, expected)[shown].sum())

    plan = plan_bound(bound, expected, 8, 0.0, power=power)
    assert reached(plan.attempts) >= power
    assert all(reached(attempts) < power for attempts in range(1, plan.attempts))


@pytest.mark.parametrize(("bound", "expected", "correlation"), [(0.8, 0.9, 0.2), (0.9, 0.97, 0.0)])
def test_the_planned_experiments_show_the_bound_as_often_as_planned(bound, expected, correlation) -> None:
    plan = plan_bound(bound, expected, 8, correlation)
    rng = np.random.default_rng(12345)
    weight = 1 / correlation - 1 if correlation else 1e9
    shares = rng.beta(expected * weight, (1 - expected) * weight, (500, plan.experiments))
    lows = [
        clustered_rate_interval(run / 8, np.full(len(run), 8), range(len(run)), 0.9)[0]
        for run in rng.binomial(8, shares)
    ]
    assert np.mean(np.array(lows) >= bound) == pytest.approx(plan.power, abs=3 * np.sqrt(2 * 0.16 / 500))
    assert plan.power >= 0.8
    assert plan.experiments * 8 > plan.attempts * (1 + 7 * correlation)


def test_worlds_that_repeat_need_more_experiments_and_a_few_unlike_ones_never_show_a_high_bound() -> None:
    alone = plan_bound(0.7, 0.9, attempts_each=8, correlation=0.1)
    repeated = plan_bound(0.7, 0.9, attempts_each=8, correlation=0.1, worlds=10)
    assert repeated.experiments % 10 == 0
    assert repeated.experiments >= alone.experiments
    hopeless = plan_bound(0.85, 0.9, attempts_each=8, correlation=0.3, worlds=10)
    assert hopeless.experiments is None
    assert hopeless.power < 0.8


def test_experiments_that_fail_or_succeed_as_a_whole_count_as_one_attempt_each() -> None:
    plan = plan_bound(0.9, 0.97, attempts_each=8, correlation=1.0)
    assert plan.attempts <= plan.experiments < 2 * plan.attempts


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"bound": 0.99, "expected": 0.99}, "bound < expected rate <= 1"),
        ({"bound": 0.0}, "expected 0 < bound"),
        ({"attempts_each": 0.5}, "at least 1 attempt"),
        ({"correlation": 1.5}, r"a correlation in 0\.\.1"),
        ({"power": 1.0}, r"expected a power in \(0, 1\)"),
        ({"confidence": 0.5}, r"a confidence in \(0\.5, 1\)"),
        ({"worlds": 0}, "and a world"),
        ({"bound": 0.99, "expected": 0.99001}, "10,000,000 experiments can answer; this one needs more"),
    ],
)
def test_a_bound_that_cannot_be_planned_for_is_refused(arguments: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        plan_bound(**{"bound": 0.9, "expected": 1.0, "attempts_each": 8, "correlation": 0.0, **arguments})


@pytest.mark.parametrize(
    ("pilot", "arguments", "words"),
    [
        (ALONE, {"wanted": 0.0}, "a difference other than 0"),
        (ALONE, {"wanted": 1.0, "power": 0.01}, "0 < alpha < power < 1"),
        (Pilot(0.0, 0.0, 0.0, 5, 10), {"wanted": 1.0}, "a pilot with scatter"),
        (ALONE, {"wanted": 1.0, "worlds": 20}, "two pilot experiments in one of them"),
        (NESTED, {"wanted": 1.0, "worlds": 1}, "expected two worlds or more"),
        (ALONE, {"wanted": 1e-6}, "expected a question that 10,000,000 experiments can answer"),
    ],
)
def test_a_difference_that_cannot_be_planned_for_is_refused(pilot: Pilot, arguments: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        plan_difference(pilot, **arguments)
