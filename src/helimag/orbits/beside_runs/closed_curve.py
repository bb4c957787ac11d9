"""A run that stays without a stable orbit: does it go round a closed curve, turn by turn of the magnet?

On such a curve the device swings for ever around an orbit that repels it, as it does beyond a supercritical
Neimark-Sacker point. Averages with a smooth weight tell: on a closed curve they converge faster than any power of the
time, in disordered motion no faster than its square root.
S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111.
"""

from dataclasses import dataclass

import numpy as np

from helimag.orbits.strobe import Floats

REGULAR = 1e-3  # of the heights' standard deviation: two halves of a swing that agree this well are one closed curve
FEWEST_SWINGS = 8  # in each half, to tell


@dataclass(frozen=True)
class Swinging:
    """Motion that stays, at whole turns of the magnet; SI.

    Attributes
    ----------
    low, high
        Of the head's height, m.
    period
        Mean time between upward passes through the mean height, s; nan where there are none.
    disagreement
        Of the weighted mean heights of its two halves, over the standard deviation.
    """

    low: float
    high: float
    period: float
    disagreement: float
    duration: float

    @property
    def closed(self) -> bool:
        """Whether it is a closed curve, as far as the swings seen tell."""
        return self.disagreement < REGULAR and self.duration > 2.0 * FEWEST_SWINGS * self.period

    @property
    def text(self) -> str:
        """The motion in a clause."""
        kind = "a closed curve" if self.closed else "no closed curve that could be made out"
        heights = f"heights {1e3 * self.low:.1f} to {1e3 * self.high:.1f} mm"
        swing = f", a swing in {self.period:.4g} s" if np.isfinite(self.period) else ""
        return f"on {kind}, {heights}{swing}"


def swinging(times: Floats, heights: Floats) -> Swinging:
    """Describe the later half of a motion that stays, so that what led to it has died out.

    Parameters
    ----------
    times, heights
        (n,) at whole turns of the magnet, s and m, equally spaced; several in each swing.
    """
    late = len(times) // 2
    z, t = heights[late:], times[late:]
    half = len(z) // 2
    means = weighted_mean(z[:half]), weighted_mean(z[half : 2 * half])
    spread = max(float(z.std()), 1e-12)
    above = z > z.mean()
    passes = t[1:][above[1:] & ~above[:-1]]
    period = float(np.diff(passes).mean()) if passes.size > 1 else float("nan")
    return Swinging(float(z.min()), float(z.max()), period, abs(means[0] - means[1]) / spread, float(t[-1] - t[0]))


def weighted_mean(values: Floats) -> float:
    """Mean with the weight exp(-1 / (t (1 - t))) over the span, which dies out smoothly at both ends."""
    t = (np.arange(len(values)) + 1.0) / (len(values) + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    return float(weight @ values / weight.sum())
