"""The sampler against posteriors that are known."""

import numpy as np
import pytest

from helimag.calibration import sampling
from helimag.errors import InputError


def sampled(likelihood, dimensions, count=256, seed=0):
    stand = sampling.begin(likelihood, dimensions, count, seed)
    while not stand.done:
        stand = sampling.advanced(stand, likelihood)
    return stand


def normal(points, mean, covariance):
    """Logarithm of the normal density."""
    off = points - mean
    quadratic = np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)
    return -0.5 * quadratic - 0.5 * np.linalg.slogdet(2.0 * np.pi * covariance)[1]


@pytest.fixture(scope="module")
def leaning():
    """A covariance in six dimensions whose axes are 40 to 1, turned at random."""
    turned, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(6, 6)))
    return turned @ np.diag(np.geomspace(0.002, 0.08, 6) ** 2) @ turned.T


def test_a_leaning_normal_posterior(leaning):
    """Mean and covariance, seen through its own axes, and an evidence of one: the density adds up to one."""
    runs = [sampled(lambda x: normal(x, 0.5, leaning), 6, seed=seed) for seed in range(4)]
    points = np.concatenate([stand.points for stand in runs]) - 0.5
    whitened = points @ np.linalg.inv(np.linalg.cholesky(leaning)).T
    np.testing.assert_allclose(whitened.mean(axis=0), 0.0, atol=0.15)
    np.testing.assert_allclose(whitened.std(axis=0), 1.0, atol=0.12)
    assert np.mean([stand.evidence for stand in runs]) == pytest.approx(0.0, abs=0.8)
    assert max(stand.evaluations for stand in runs) < 30_000


def test_both_of_two_modes_are_kept_in_proportion():
    """Three quarters of the weight at one, a quarter at the other, eighty standard deviations apart in all."""
    small = 0.05**2 * np.eye(4)

    def likelihood(points):
        return np.logaddexp(np.log(0.25) + normal(points, 0.25, small), np.log(0.75) + normal(points, 0.75, small))

    shares = [(sampled(likelihood, 4, seed=seed).points[:, 0] > 0.5).mean() for seed in range(6)]
    assert np.mean(shares) == pytest.approx(0.75, abs=0.08)


def test_at_the_cube_s_edge_nothing_is_lost():
    """exp(-x/0.1) in each of three coordinates: mean a tenth, largest at the corner; evidence a thousandth."""
    stand = sampled(lambda x: -x.sum(axis=1) / 0.1, 3, count=1000)
    np.testing.assert_allclose(stand.points.mean(axis=0), 0.1, rtol=0.15)
    assert stand.evidence == pytest.approx(3.0 * np.log(0.1), abs=0.3)


def test_a_leaning_posterior_at_the_edge():
    """x + y <= 0.2 alone is possible, all as likely: mean 0.2/3 each, evidence 0.02; mirrors would pile up there."""

    def likelihood(points):
        return np.where(points.sum(axis=1) <= 0.2, 0.0, -1e3)

    stand = sampled(likelihood, 2, count=2000)
    np.testing.assert_allclose(stand.points.mean(axis=0), 0.2 / 3.0, rtol=0.07)
    assert stand.evidence == pytest.approx(np.log(0.02), abs=0.3)


def test_what_says_nothing_leaves_the_prior():
    stand = sampled(lambda x: np.zeros(len(x)), 2, count=1000)
    assert stand.evidence == 0.0
    np.testing.assert_allclose(
        np.quantile(stand.points, [0.1, 0.5, 0.9], axis=0), [[0.1] * 2, [0.5] * 2, [0.9] * 2], atol=0.06
    )


def test_impossible_points_count_in_the_evidence():
    """Half of the cube impossible, the other half all as likely: evidence a half."""
    stand = sampled(lambda x: np.where(x[:, 0] < 0.5, 0.0, -np.inf), 2, count=2000)
    assert stand.points[:, 0].max() < 0.5
    assert stand.evidence == pytest.approx(np.log(0.5), abs=0.1)


def test_a_prior_that_holds_nothing_is_refused():
    with pytest.raises(InputError, match="only 0 make runs"):
        sampling.begin(lambda x: np.full(len(x), -np.inf), 2, 64, 0)


def test_the_same_seed_gives_the_same_numbers_and_another_others(leaning):
    one, two, other = (sampled(lambda x: normal(x, 0.5, leaning), 6, count=64, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(one.points, two.points)
    assert not np.array_equal(one.points, other.points)


def test_a_stage_keeps_half_of_the_weight():
    loglikelihood = -np.linspace(0.0, 100.0, 200)
    power = sampling.next_power(loglikelihood, 0.0)
    weights = np.exp(power * loglikelihood)
    assert weights.sum() ** 2 / (weights**2).sum() == pytest.approx(100.0, rel=1e-6)


def test_resampling_draws_in_proportion():
    weights = np.array([0.5, 0.3, 0.2, 0.0])
    counts = np.zeros(4)
    for seed in range(200):
        counts += np.bincount(sampling.chosen(weights, np.random.default_rng(seed)), minlength=4)
    np.testing.assert_allclose(counts / counts.sum(), weights, atol=0.03)
