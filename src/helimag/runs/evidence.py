"""Whether a run that is inside at its end stays: only where it lasted long enough to have shown the contrary.

A device hangs below its magnet in an unstable balance, which swimming around it makes stable, or not. So a run can look
settled while a disturbance too small to be seen grows. *Bounded* needs three things of the heights: the run is long
beside the slow times of its dynamics; its mean height has settled, in steps that shrink; and so do its swings. The
numbers were chosen on random runs that were continued to 20,000 s (benchmarks/false_bounded.py).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import Reason
from helimag.runs.heights import PARTS, Heights, SlowTimes

Floats = NDArray[np.float64]
Said = tuple[Reason, dict[str, object]]  # why a run has its verdict, and the numbers of the sentence that says so

SETTLED = 0.01  # of the input: how far the mean height of a settled run may still be expected to move
STILL = 0.002  # of the input: a change between quarters too small to extrapolate
SEEN = 1e-5  # of the input: changes of mean and swing below this are rounding
LEAK = 0.3  # of a swing that takes less than half a quarter of the run: what may look like a step of its trend
SHRINKS = 0.92  # from one quarter of the run to the next: swings that shrink by less may not be dying out
SLOWING = 1.25  # by how much larger the ratio of two quarters' swings may be than the ratio before
STEADY = 2e-3  # by how much the swings of a steady motion may differ from quarter to quarter
SLOWEST = 1e6  # s; a device that needs longer to show anything does not move
DEVIATIONS = 3.0  # standard deviations by which noise may make swings look larger


def evidence(run: Heights) -> Said:
    """Reason for the verdict on a run that is inside at its end, and numbers for its sentence."""
    found = None if run.slow is None else _too_short(run, run.slow)
    found = found or _too_sparse(run) or _on_the_move(run)
    if found is not None:
        return found
    if run.slow is None:
        return Reason.SLOWNESS_UNKNOWN, {"time": run.time[-1]}
    found = _not_dying_out(run)
    if found is not None:
        return found
    last = float(_steps(run)[-1])
    return Reason.SETTLED, {"time": run.time[-1], "change": 1e3 * last}


def _too_short(run: Heights, slow: SlowTimes) -> Said | None:
    """Whether a run is too short beside the slow times of its scenario."""
    if run.span >= slow.decisive:
        return None
    if slow.decisive > SLOWEST:
        return Reason.NOTHING_MOVES, {"time": run.span, "needed": slow.decisive}
    return Reason.TOO_SHORT, {"time": run.span, "slow": slow, "needed": slow.decisive}


def _too_sparse(run: Heights) -> Said | None:
    """Whether there are too few samples, or too few in one quarter of the run, to see how the height develops."""
    if run.time.size > PARTS and np.bincount(run.quarters(), minlength=4).min() >= PARTS // 4:
        return None
    return Reason.TOO_FEW_SAMPLES, {"time": run.time[-1], "samples": run.time.size, "needed": PARTS + 1}


def _steps(run: Heights) -> Floats:
    """Changes of the mean height from quarter to quarter: (3,) in m."""
    return np.diff(run.part_means().reshape(4, -1).mean(axis=1))


def _on_the_move(run: Heights) -> Said | None:
    """Whether the height is visibly on the move: its mean does not near a limit, or it swings ever more.

    With changes that shrink by a constant ratio r, the rest after the last change is change * r / (1 - r) (Aitken).
    """
    time = float(run.time[-1])
    _, before, last = _steps(run)
    ratio = last / before if before != 0.0 else 0.0
    rest = abs(last) if abs(last) <= STILL * run.initial_gap or ratio < 0.0 else np.inf
    if 0.0 <= ratio < 1.0:
        rest = min(rest, abs(last) * ratio / (1.0 - ratio))
    growth = _growth(run)
    if growth > SETTLED * run.initial_gap:
        return Reason.SWINGS_EVER_MORE, {"time": time, "growth": 1e3 * growth}
    if rest > SETTLED * run.initial_gap:
        moves = Reason.STILL_RISES if last > 0.0 else Reason.STILL_SINKS
        left = "" if np.isinf(rest) else f", {1e3 * rest:.2f} mm more by extrapolation"
        return moves, {"time": time, "change": 1e3 * last, "left": left}
    return None


def _growth(run: Heights) -> float:
    """By how much the range of heights in the last quarter of the run exceeds that in the quarter before (m)."""
    quarter = run.quarters()
    ranges = [np.ptp(np.concatenate([run.low[quarter == i], run.high[quarter == i]])) for i in (2, 3) if i in quarter]
    return float(ranges[1] - ranges[0]) if len(ranges) == 2 else 0.0


def _not_dying_out(run: Heights) -> Said | None:
    """Whether what is left of motion does not shrink, however little it is: it may grow for as long as it likes."""
    time = float(run.time[-1])
    before, last = (_about_trend(run, quarter, smooth=True) for quarter in (2, 3))
    unseen = STILL * run.initial_gap + LEAK * last.swing
    if abs(last.step) > unseen and not _rest(before.step, last.step) <= SETTLED * run.initial_gap:
        return Reason.MOVES_ON, {"time": time, "last": 1e3 * last.step, "before": 1e3 * before.step}
    smooth, sharp = (_swings(run, smooth=each) for each in (True, False))
    unseen = SEEN * run.initial_gap + _noise(run)
    steady = _steady(smooth) and sharp[2] <= sharp[1] + unseen
    for swings in (smooth, sharp):
        if not steady and not _die_out(swings, unseen):
            return Reason.SWINGS_ON, {"time": time, "last": 1e3 * swings[2], "before": 1e3 * swings[1]}
    return None


def _swings(run: Heights, *, smooth: bool) -> tuple[float, float, float]:
    """Swings in the last three quarters of a run (m); zero where they are not beyond what noise alone may show."""
    noise = _deviation(run) ** 2
    spread = DEVIATIONS * noise * math.sqrt(16.0 / run.time.size)  # of a quarter's mean square, by a window's weights
    squares = (_about_trend(run, quarter, smooth=smooth).swing ** 2 - noise for quarter in (1, 2, 3))
    first, second, third = (math.sqrt(square) if square > spread else 0.0 for square in squares)
    return first, second, third


def _die_out(swings: tuple[float, float, float], unseen: float) -> bool:
    """Whether swings in successive quarters shrink, by as much as before or more: a slow one may hide under a fast one.

    While a fast swing dies out, one that grows slowly beneath it looks as if it shrank, but ever less.
    """
    first, second, third = swings
    shrinks = third <= SHRINKS * second + unseen
    steadily = third * first <= SLOWING * second * second or third <= unseen
    return shrinks and steadily


def _steady(swings: tuple[float, float, float]) -> bool:
    """Whether swings keep their size so well, twice, that no growth would show in them for as long as anybody runs."""
    first, second, third = swings
    return abs(second - first) <= STEADY * second and abs(third - second) <= STEADY * second


def _rest(before: float, last: float) -> float:
    """How far a height still goes whose last two steps are these (m), if each is a constant share of the one before."""
    ratio = last / before if before != 0.0 else math.inf
    if abs(ratio) >= 1.0:
        return math.inf
    return abs(last) * max(ratio, 0.0) / (1.0 - ratio)


class _AboutTrend(NamedTuple):
    """Motion in a quarter of a run (m): the step of its trend, and the standard deviation of heights about it."""

    step: float
    swing: float


def _about_trend(run: Heights, quarter: int, *, smooth: bool) -> _AboutTrend:
    """Trend of the mean height in a quarter of the run, and its swing about it.

    Smooth: about a line, with weights that vanish at the quarter's ends, so that parts of a swing there do not count.
    Otherwise about a parabola without weights, which tells short swings from a bend in the trend.
    """
    where = run.quarters() == quarter
    share = 4.0 * (run.time[where] - run.time[0]) / run.span - quarter
    weights = np.sin(np.pi * share) ** 2 + SEEN if smooth else np.ones_like(share)
    columns = share[:, None] ** np.arange(2 if smooth else 3)
    root = np.sqrt(weights)
    trend, *_ = np.linalg.lstsq(root[:, None] * columns, root * run.mean[where], rcond=None)
    square = float(np.average((run.mean[where] - columns @ trend) ** 2, weights=weights))
    return _AboutTrend(float(trend[1]), float(np.sqrt(square)))


def _noise(run: Heights) -> float:
    """How much larger noise alone may make a quarter's swing look than the one before (m)."""
    return DEVIATIONS * _deviation(run) / math.sqrt(run.time.size / 4.0)


def _deviation(run: Heights) -> float:
    """Standard deviation of noise (m): that of second differences over sqrt(6), of which slow motion hardly has any."""
    return float(np.std(np.diff(run.mean, 2))) / math.sqrt(6.0)
