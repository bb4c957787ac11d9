"""Samples of a posterior on the unit cube, by sequential Monte Carlo: whole batches of points at a time.

Points spread over the prior are taken to the posterior in stages, in each of which the likelihood counts with a higher
power, chosen such that half of the points' weight survives (Del Moral, Doucet and Jasra, J. R. Stat. Soc. B 68 (2006)
411). Between stages the points move, each half by differences of the other half (ter Braak and Vrugt, Stat. Comput. 18
(2008) 435), which takes the posterior's shape by itself and hops between modes. The evidence comes along with it.
Against known posteriors in six dimensions it takes two thirds to a twentieth of the likelihoods that nested sampling
with ultranest took (``benchmarks/calibration.py samplers``), needs no compiler, and goes on after a stop to the same
numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError

Floats = NDArray[np.float64]
Likelihood = Callable[[Floats], Floats]

SURVIVING = 0.5  # share of the points' weight that a stage keeps
MOVED = 1.5  # accepted moves a point before the next stage, on average
LAST_MOVED = 4.0  # and after the last
MOST_SWEEPS = 40
WANTED = 0.25  # share of moves that are accepted
HOPS = 0.1  # share of moves that go the whole way between two points, which takes them to other modes
JITTER = 1e-4
LEAST_POSSIBLE = 0.05  # of the points of the prior


@dataclass(frozen=True)
class Stand:
    """How far a sampling is: all that is needed to go on, to the same numbers.

    Attributes
    ----------
    points
        (n, k), in the unit cube.
    loglikelihood
        (n,).
    power
        With which the likelihood counts now; 1 in the last stage.
    evidence, variance
        Logarithm of the evidence so far, and its variance.
    moved, sweeps, length
        Accepted moves a point in this stage, sweeps in it, and the length of a step.
    evaluations, random
        Likelihoods computed so far; state of the random generator.
    """

    points: Floats
    loglikelihood: Floats
    power: float
    evidence: float
    variance: float
    moved: float
    sweeps: int
    length: float
    evaluations: int
    random: dict[str, Any]

    @property
    def settled(self) -> bool:
        """Whether the points have moved enough in this stage."""
        wanted = LAST_MOVED if self.power == 1.0 else MOVED
        return self.moved >= wanted or self.sweeps >= MOST_SWEEPS

    @property
    def done(self) -> bool:
        """Whether these are samples of the posterior."""
        return self.power == 1.0 and self.settled

    @property
    def fraction(self) -> float:
        """Roughly how much is behind: powers grow by factors from about a millionth."""
        stage = (np.log10(self.power) + 6.0) / 6.0 if self.power > 0.0 else 0.0
        return float(np.clip(0.9 * stage, 0.0, 0.9)) + 0.1 * (self.power == 1.0) * min(self.moved / LAST_MOVED, 1.0)


def begin(likelihood: Likelihood, dimensions: int, count: int, seed: int) -> Stand:
    """Points over the prior with their likelihoods.

    Raises
    ------
    InputError
        Where hardly any point of the prior is possible at all.
    """
    random = np.random.default_rng(seed)
    points = random.random((count, dimensions))
    found = likelihood(points)
    possible = int(np.isfinite(found).sum())
    if possible < LEAST_POSSIBLE * count:
        raise InputError(
            f"of {count} values drawn from the priors only {possible} make runs that can be computed; give the free "
            "inputs bounds inside which each makes a scenario"
        )
    return Stand(points, found, 0.0, 0.0, 0.0, MOVED, 0, 1.0, count, dict(random.bit_generator.state))


def advanced(stand: Stand, likelihood: Likelihood) -> Stand:
    """One step further: the next stage where the points have moved enough, and one sweep of moves."""
    random = np.random.default_rng()
    random.bit_generator.state = stand.random
    if stand.settled:
        stand = _next_stage(stand, random)
    return replace(_sweep(stand, likelihood, random), random=dict(random.bit_generator.state))


def _next_stage(stand: Stand, random: np.random.Generator) -> Stand:
    power = next_power(stand.loglikelihood, stand.power)
    logarithms = (power - stand.power) * stand.loglikelihood
    top = logarithms.max()
    weights = np.exp(logarithms - top)
    mean = weights.mean()
    kept = chosen(weights / weights.sum(), random)
    return replace(
        stand,
        points=stand.points[kept],
        loglikelihood=stand.loglikelihood[kept],
        power=power,
        evidence=stand.evidence + float(top + np.log(mean)),
        variance=stand.variance + float(weights.var() / mean**2) / weights.size,
        moved=0.0,
        sweeps=0,
    )


def next_power(loglikelihood: Floats, power: float) -> float:
    """The power at which the weights' effective number is ``SURVIVING`` of the points; 1 where that is beyond."""

    def surviving(step: float) -> float:
        logarithms = step * loglikelihood
        weights = np.exp(logarithms - logarithms.max())
        return float(weights.sum() ** 2 / (weights**2).sum() / weights.size)

    least = np.isfinite(loglikelihood).mean()  # what is impossible goes at the first step, however short
    if surviving(1.0 - power) >= SURVIVING * least:
        return 1.0
    low, high = 0.0, 1.0 - power
    for _ in range(100):
        middle = (low + high) / 2.0
        low, high = (middle, high) if surviving(middle) > SURVIVING * least else (low, middle)
    return power + high


def chosen(weights: Floats, random: np.random.Generator) -> NDArray[np.int64]:
    """Indices (n,) drawn in proportion to weights (n,) that add up to 1, evenly (systematic resampling), shuffled."""
    places = (random.random() + np.arange(weights.size)) / weights.size
    found = np.searchsorted(np.cumsum(weights), places).clip(max=weights.size - 1)
    return np.asarray(random.permutation(found))


def _sweep(stand: Stand, likelihood: Likelihood, random: np.random.Generator) -> Stand:
    """Both halves of the points tried to move once, each by differences of points of the other."""
    points, found = stand.points.copy(), stand.loglikelihood.copy()
    count = points.shape[0]
    order = random.permutation(count)
    halves = order[: count // 2], order[count // 2 :]
    accepted, computed = 0.0, 0
    for own, other in (halves, halves[::-1]):
        tried = points[own] + _steps(points[other], own.size, stand.length, random)
        inside = np.all((tried >= 0.0) & (tried <= 1.0), axis=1)  # mirrors would make a step likelier than its reverse
        new = np.full(own.size, -np.inf)
        if inside.any():
            new[inside] = likelihood(tried[inside])
            computed += int(inside.sum())
        with np.errstate(invalid="ignore"):  # from impossible to impossible
            rises = stand.power * (new - found[own])
        taken = np.log(random.random(own.size)) < np.nan_to_num(rises, nan=-np.inf)
        points[own[taken]], found[own[taken]] = tried[taken], new[taken]
        accepted += float(taken.sum())
    share = accepted / count
    return replace(
        stand,
        points=points,
        loglikelihood=found,
        moved=stand.moved + share,
        sweeps=stand.sweeps + 1,
        length=float(np.clip(stand.length * np.exp(0.6 * (share - WANTED) / WANTED), 0.02, 2.0)),
        evaluations=stand.evaluations + computed,
    )


def _steps(others: Floats, count: int, length: float, random: np.random.Generator) -> Floats:
    """Steps (count, k): differences of two other points each, times a length that fits a normal posterior."""
    dimensions = others.shape[1]
    first = random.integers(others.shape[0], size=count)
    second = (first + random.integers(1, others.shape[0], size=count)) % others.shape[0]
    scale = length * 2.38 / np.sqrt(2.0 * dimensions) * random.uniform(0.5, 1.5, (count, 1))
    scale[random.random(count) < HOPS] = 1.0
    jitter = JITTER * random.standard_normal((count, dimensions))
    return np.asarray(scale * (others[first] - others[second]) + jitter)
