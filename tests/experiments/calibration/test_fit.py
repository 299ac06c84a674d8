import numpy as np
import pytest

from experiments.calibration.fit import Fit, fit


def linear(matrix, wanted):
    return lambda points: [matrix @ z - wanted for z in points]


def test_the_fit_of_a_linear_model_is_the_posterior_of_linear_gaussian_theory() -> None:
    rng = np.random.default_rng(3)
    matrix, wanted = 2.0 * rng.normal(size=(4, 6)), rng.normal(size=4)
    found = fit(linear(matrix, wanted), start=np.zeros(6), rounds=10)
    covariance = np.linalg.inv(matrix.T @ matrix + np.eye(6))
    assert found.z == pytest.approx(covariance @ matrix.T @ wanted, abs=1e-3)
    assert found.covariance == pytest.approx(covariance, abs=1e-6)
    assert found.misses == pytest.approx(matrix @ found.z - wanted)


def test_what_no_target_speaks_of_keeps_its_prior() -> None:
    matrix = np.array([[5.0, 0.0]])
    found = fit(linear(matrix, np.array([5.0])), start=np.zeros(2), rounds=10)
    # One target of weight 25 against a prior of weight 1: 25/26 of the way, 1/26 of the variance.
    assert found.z == pytest.approx([25 / 26, 0.0], abs=1e-3)
    assert found.sd == pytest.approx([26**-0.5, 1.0])
    assert found.determined == 1


def test_draws_have_the_posteriors_mean_and_covariance() -> None:
    jacobian = np.array([[3.0, 1.0], [0.0, 2.0]])
    found = Fit(np.array([0.5, -1.0]), np.zeros(2), jacobian, 1)
    draws = found.draw(20_000, np.random.default_rng(0))
    assert draws.mean(axis=0) == pytest.approx([0.5, -1.0], abs=0.02)
    assert np.cov(draws.T) == pytest.approx(np.linalg.inv(jacobian.T @ jacobian + np.eye(2)), abs=0.01)


def test_a_curved_model_is_fitted_within_a_few_rounds() -> None:
    found = fit(lambda points: [100.0 * (np.exp(z[:1]) - 2.0) for z in points], start=np.zeros(1), rounds=8)
    assert found.z[0] == pytest.approx(np.log(2.0), abs=2e-3)
    assert found.rounds <= 8


def test_one_round_stays_at_the_start_and_takes_the_jacobian_there() -> None:
    matrix = np.array([[2.0, -1.0]])
    found = fit(linear(matrix, np.array([7.0])), start=np.array([0.3, 0.1]), rounds=1)
    assert found.z == pytest.approx([0.3, 0.1])
    assert found.jacobian == pytest.approx(matrix)
    assert found.misses == pytest.approx([2.0 * 0.3 - 0.1 - 7.0])


def test_a_draw_that_misses_what_it_was_meant_to_stays() -> None:
    found = Fit(np.array([0.5, -1.0]), np.array([0.2]), np.array([[3.0, 1.0]]), 1)
    z = np.array([1.0, 0.0])
    meant = np.array([0.2 + 3.0 * 0.5 + 1.0])
    assert found.corrected(z, meant) == pytest.approx(z)


def test_a_correction_brings_a_curved_figure_nearer_to_what_was_meant() -> None:
    def misses(z):
        return np.array([10.0 * (z[0] + 0.3 * z[0] ** 2 + 0.5 * z[1])])

    found = Fit(np.zeros(2), misses(np.zeros(2)), np.array([[10.0, 5.0]]), 1)
    z = np.array([1.0, -1.0])
    meant = found.jacobian @ z
    off = [abs(misses(one) - meant)[0] for one in (z, found.corrected(z, misses(z)))]
    assert off[0] == pytest.approx(3.0)
    assert off[1] < 2.0
