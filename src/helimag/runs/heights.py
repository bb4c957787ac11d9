"""What a judgement needs of a run, simulated or measured alike: heights over time, and how slow its dynamics are."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import End
from helimag.runs.touches import Touch

Floats = NDArray[np.float64]

# chosen on random runs continued to 20,000 s, see benchmarks/false_bounded.py: fewer of either are too few to tell
LAPS = 5.0
FOLDS = 6.0
PARTS = 20  # pieces that a run is cut into to see how its mean height develops


@dataclass(frozen=True, kw_only=True)
class SlowTimes:
    """How slow the dynamics of a scenario are (s).

    Attributes
    ----------
    lap
        Of one turn of the drive's yaw; None where it does not yaw.
    fold
        In which an error of height grows e-fold where the magnet's pull balances the weight.
    """

    lap: float | None
    fold: float

    @property
    def decisive(self) -> float:
        """Shortest run (s) that can show where the device goes."""
        return max(FOLDS * self.fold, LAPS * (self.lap or 0.0))

    def __str__(self) -> str:
        """Both in words."""
        lap = "" if self.lap is None else f"a lap takes {self.lap:.3g} s, and "
        return f"{lap}an error of height grows e-fold in {self.fold:.3g} s"


def spans_between(time: Floats) -> Floats:
    """How long the interval is that each sample of a run ends, none for the first (s), from times (..., n)."""
    spans = np.zeros_like(time)
    np.subtract(time[..., 1:], time[..., :-1], out=spans[..., 1:])
    return spans


@dataclass(frozen=True, kw_only=True)
class Heights:
    """What a judgement needs of a run: samples, each with what happened since the sample before. All arrays (n,), SI.

    A measured run, which knows nothing between its frames, gives its heights as ``low``, ``high`` and ``mean`` alike,
    and no slow times where its scenario is not known.
    """

    time: Floats
    low: Floats
    high: Floats
    mean: Floats
    attack: Floats
    attack_square: Floats
    slips: int
    initial_gap: float
    end: End
    slow: SlowTimes | None = None
    touches: tuple[Touch, ...] = ()

    @property
    def multiply_errors(self) -> bool:
        """Whether the run multiplies every error of place: the device loses step, or is drawn into the magnet."""
        return self.slips > 0 or self.end is End.CONTACT

    @property
    def span(self) -> float:
        """From the first sample to the last (s)."""
        return float(self.time[-1] - self.time[0])

    @property
    def spans(self) -> Floats:
        """How long the interval is that each sample ends (n,): none for the first (s)."""
        return spans_between(self.time)

    def part_means(self) -> Floats:
        """Mean height in each of ``PARTS`` equally long pieces of the run (m)."""
        if not self.span > 0.0:
            return np.full(PARTS, self.mean[0])
        edges = np.linspace(self.time[0], self.time[-1], PARTS + 1)
        integral = np.cumsum(self.spans * self.mean)
        return np.asarray(np.diff(np.interp(edges, self.time, integral)) / np.diff(edges))

    def quarters(self) -> NDArray[np.int64]:
        """To which quarter of the run each sample belongs (n,): 0 to 3."""
        share = 4.0 * (self.time - self.time[0]) / max(self.span, 1e-300)
        return np.asarray(np.minimum(share, 3.0), dtype=np.int64)
