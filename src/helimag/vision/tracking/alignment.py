"""Bring two cameras that are neither triggered together nor on one clock to the same instants."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from helimag.vision.cameras import Rig
from helimag.vision.tracking.search import Sighting

Floats = NDArray[np.float64]

BRIDGE = 1.6  # frames between two sightings across which the device's path is interpolated
FURTHEST = 5.0  # clock offset that is looked for (s)
SYSTEMATIC = 0.03  # px by which a view's detections may be off all along
LEAST_TURN = 2.0  # rolled over the film (rad) from which the roll tells the time
LEAST_FRAMES = 8
LEAST_TURNS = 4  # whose means tell how uncertain the mean of all is
LEAST_OF_TURN = 4  # frames of one
LARGEST_SPREAD = 0.5  # of the views' difference in roll (rad), beyond which they do not show the same roll
CERTAIN = 0.5  # frames: an offset less certain than this is not used


class Offset(NamedTuple):
    """How far the second clock is ahead (s), its standard deviation, and whether the films show enough motion to
    tell."""

    value: float
    sd: float
    found: bool


def frame_interval(time: Floats) -> float:
    """Typical time between frames (s)."""
    return float(np.median(np.diff(time)))


def at(sighting: Sighting, times: Floats) -> Floats:
    """Rows of a sighting at other instants (m, 13), by splines through its frames; NaN where frames are missing
    around one."""
    seen = np.isfinite(sighting.rows[:, 0])
    known, rows = sighting.time[seen], sighting.rows[seen]
    result = np.full((times.size, rows.shape[1]), np.nan)
    step = frame_interval(sighting.time)
    cuts = np.flatnonzero(np.diff(known) > 2.5 * step) + 1
    for part in np.split(np.arange(known.size), cuts):
        if part.size < 4:
            continue
        within = (times >= known[part[0]] - 1e-9) & (times <= known[part[-1]] + 1e-9)
        result[within] = CubicSpline(known[part], rows[part])(times[within])
    if known.size < 2:
        return result
    after = np.clip(np.searchsorted(known, times), 1, known.size - 1)
    wide = known[after] - known[after - 1] > BRIDGE * step
    exact = np.minimum(np.abs(times - known[after]), np.abs(times - known[after - 1])) < 0.02 * step
    result[wide & ~exact] = np.nan
    nearest = np.where(np.abs(times - known[after]) < np.abs(times - known[after - 1]), after, after - 1)
    result[:, 4:] = np.where(np.isfinite(result[:, :1]), rows[nearest, 4:], np.nan)
    return result


def find_offset(first: Sighting, second: Sighting, rig: Rig) -> Offset:
    """The clock offset at which the lines of sight through both views' middles miss each other least.

    Right to some milliseconds: the middle between two ends as seen is not where the device's middle is seen.
    The cost is the sum of squared misses; its curvature gives the standard deviation, with misses taken to be
    independent once a half second. What calibration and detection may be off by all along counts as an offset, too.
    """
    seen = np.isfinite(first.rows[:, 0])
    times, middles = first.time[seen], first.rows[seen, :2]
    step = frame_interval(first.time)

    def miss(offset: float) -> Floats:
        rows = at(second, times + offset)
        good = np.isfinite(rows[:, 0])
        if good.sum() < max(8, 0.3 * times.size):
            return np.full(1, np.nan)
        return rig.triangulate(middles[good], rows[good, :2])[1]

    def cost(offset: float) -> float:
        values = miss(offset)
        return float(np.mean(np.minimum(values, 3.0 * np.median(values) + 1e-6) ** 2))

    coarse = np.arange(-FURTHEST, FURTHEST + step / 2.0, 2.0 * step)
    costs = np.array([cost(offset) for offset in coarse])
    if not np.any(np.isfinite(costs)):
        return Offset(0.0, np.inf, False)
    best = float(coarse[np.nanargmin(costs)])
    for width in (step, step / 4.0, step / 16.0):
        fine = best + width * np.arange(-3, 4)
        best = float(fine[np.nanargmin([cost(offset) for offset in fine])])
    reach = step / 2.0
    low, middle, high = cost(best - reach), cost(best), cost(best + reach)
    curvature = (low - 2.0 * middle + high) / reach**2
    if np.isfinite(curvature) and curvature > 0.0:
        best += float(np.clip((low - high) / (2.0 * curvature * reach), -0.5, 0.5)) * reach
    independent = max(1.0, (times[-1] - times[0]) / 0.5)
    sd = np.inf
    if (
        np.isfinite(curvature) and curvature > 0.0
    ):  # the cost is (speed x offset)^2: the calibration's error counts as an offset
        pixel = 1.0 / float(rig.cameras[0].scale(rig.tank.mean(axis=0)[None])[0])
        apart = 8.0 * rig.accuracy**2 + 2.0 * (SYSTEMATIC * pixel) ** 2  # of a miss: two views, each over half of it
        sd = float(np.sqrt(2.0 * middle / (curvature * independent) + 2.0 * apart / curvature))
    return Offset(best, sd, sd < CERTAIN * step)


def by_roll(offset: Offset, first: Floats, second: Floats, rolls: tuple[Floats, Floats], roll_sd: float) -> Offset:
    """A clock offset from the device's roll, which each view shows on its own; any speed along the tank will do.

    The roll repeats itself, so ``offset``, which makes lines of sight meet, says which turn is meant. Not found where
    the device hardly rolls, or that offset leaves more than one turn.

    Parameters
    ----------
    first, second
        Times (n,) and (m,) of the views (s), each on its own clock.
    rolls
        (n,) and (m,): at those times (rad).
    roll_sd
        By which the two views' rolls may differ all along (rad).
    """
    step = frame_interval(first)
    unknown = Offset(0.0, offset.sd, False)
    rate = rolling(first, rolls[0])
    if not abs(rate) * (first[-1] - first[0]) > LEAST_TURN:
        return unknown
    period = 2.0 * np.pi / abs(rate)
    if not offset.sd < period / 4.0:
        return unknown
    value, sd = offset.value, np.inf
    for _ in range(4):
        after = np.clip(np.searchsorted(second, first + value), 1, second.size - 1)
        wide = second[after] - second[after - 1]
        share = (first + value - second[after - 1]) / wide
        inside = (share >= 0.0) & (share <= 1.0) & (wide < BRIDGE * step)
        if inside.sum() < LEAST_FRAMES:
            return unknown
        turn = _wrapped(rolls[1][after] - rolls[1][after - 1])
        ahead = _wrapped(rolls[1][after - 1] + share * turn - rolls[0])[inside]
        mean = float(np.angle(np.exp(1j * ahead).mean()))
        spread = float(np.std(_wrapped(ahead - mean)))
        value -= mean / rate
        sd = float(np.hypot(_mean_sd(_wrapped(ahead - mean), first[inside], rate), roll_sd)) / abs(rate)
    if not (spread < LARGEST_SPREAD and abs(value - offset.value) < period / 2.0 and sd < CERTAIN * step):
        return unknown
    return Offset(value, sd, True)


def rolling(time: Floats, roll: Floats) -> float:
    """Rate (rad/s) of a roll (n,) that advances by less than half a turn between most frames."""
    return float(np.median(_wrapped(np.diff(roll)) / np.diff(time)))


def _mean_sd(ahead: Floats, time: Floats, rate: float) -> float:
    """Standard deviation of the mean of ``ahead`` (n,), from its means over whole turns: what comes back with every
    turn cancels in them."""
    turn = np.floor(abs(rate) * (time - time[0]) / (2.0 * np.pi)).astype(int)
    counts = np.bincount(turn)
    means = (np.bincount(turn, ahead) / np.maximum(counts, 1))[counts >= LEAST_OF_TURN]
    if means.size < LEAST_TURNS:
        return float(np.std(ahead) / np.sqrt(ahead.size))
    return float(np.std(means, ddof=1) / np.sqrt(means.size))


def _wrapped(angle: Floats) -> Floats:
    """Between -pi and pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
