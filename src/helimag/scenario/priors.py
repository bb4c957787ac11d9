"""Priors of a scalar input (SI): bounds, and the transform from the unit interval that sampling needs."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError

Floats = NDArray[np.float64]


class Prior(Protocol):
    """What is known of an input beforehand: where it lies, and how likely there."""

    @property
    def low(self) -> float:
        """Least value, SI; minus infinity where there is none."""
        ...

    @property
    def high(self) -> float:
        """Largest value, SI; infinity where there is none."""
        ...

    def quantile(self, share: Floats) -> Floats:
        """Values below which shares (in [0, 1]) of the probability lie."""
        ...


@dataclass(frozen=True)
class Uniform:
    """Every value between two is as likely."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_bounds("a uniform prior", self.low, self.high)

    def quantile(self, share: Floats) -> Floats:
        """``low + (high - low) share``; written out, so that a sweep's points need no scipy."""
        return np.asarray(self.low + (self.high - self.low) * share)


@dataclass(frozen=True)
class LogUniform:
    """Every value between two is as likely by its logarithm."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_bounds("a log-uniform prior", self.low, self.high)
        if not self.low > 0.0:
            raise InputError(f"a log-uniform prior must have a low above zero; got {self.low:g}")

    def quantile(self, share: Floats) -> Floats:
        """Quantiles of :data:`scipy.stats.loguniform`."""
        from scipy import stats

        return np.asarray(stats.loguniform(self.low, self.high).ppf(share))


@dataclass(frozen=True)
class Normal:
    """Normally distributed, cut off at bounds where they are given (and then renormalised)."""

    mean: float
    deviation: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mean) and math.isfinite(self.deviation) and self.deviation > 0.0):
            raise InputError(
                f"a normal prior must have a finite mean and a deviation above zero; got {self.mean:g}, "
                f"{self.deviation:g}"
            )
        if not self.low < self.high:
            raise InputError(f"a normal prior must have a low below its high; got {self.low:g}, {self.high:g}")

    def quantile(self, share: Floats) -> Floats:
        """Quantiles of :data:`scipy.stats.truncnorm`, or of :data:`scipy.stats.norm` without bounds."""
        from scipy import stats

        cut: Any = stats.norm(self.mean, self.deviation)
        if math.isfinite(self.low) or math.isfinite(self.high):
            ends = ((end - self.mean) / self.deviation for end in (self.low, self.high))
            cut = stats.truncnorm(*ends, loc=self.mean, scale=self.deviation)
        return np.asarray(cut.ppf(share))


def _check_bounds(what: str, low: float, high: float) -> None:
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"{what} must have a finite low below its high; got {low:g}, {high:g}")
