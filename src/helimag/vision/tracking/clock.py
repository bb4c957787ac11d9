"""How far the second clock is ahead: where both views' lines of sight meet, and where both show the same roll."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.cameras import Rig
from helimag.vision.tracking.alignment import LEAST_FRAMES, Offset, at, by_roll, rolling
from helimag.vision.tracking.detection import HALF, SDS, along_and_across
from helimag.vision.tracking.pose import Fit, residuals, solve
from helimag.vision.tracking.search import Sighting
from helimag.vision.tracking.views import PreparedView

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
Views = tuple[PreparedView, PreparedView]

STEP = 0.5e-3  # of the differences (s),
LENGTH_STEP = 1e-6  # and of the length (m)
ROUNDS = 2  # of Gauss and Newton's method: from a few milliseconds off the second changes microseconds


class Clock(NamedTuple):
    """How far the second clock is ahead (s), whether the films tell, and what it would be off by.

    Parameters
    ----------
    own
        Standard deviation (s) from what is this clock's alone: noise from frame to frame, the roll of drawings.
    numbers
        (8,) in s/px: by how much the offset is off where one of both views' numbers is off all along.
    variants
        (k,) in s: by how much where a variant of the rig is the true one.
    lasting
        (8,): standard deviations (px) by which the numbers may be off all along.
    """

    value: float
    found: bool
    own: float
    numbers: Floats
    variants: Floats
    lasting: Floats

    @property
    def sd(self) -> float:
        """Standard deviation (s) of the offset."""
        return float(np.sqrt(self.own**2 + np.sum((self.numbers * self.lasting) ** 2) + np.sum(self.variants**2)))


def told(value: float, own: float, rig: Rig, *, found: bool = True) -> Clock:
    """A clock offset that does not hang on what the views are off by."""
    return Clock(value, found, own, np.zeros(8), np.zeros(len(rig.variants)), np.zeros(8))


def clock_rates(second: Sighting, times: Floats, ahead: float) -> Floats:
    """By how much the second view's rows change with the offset (n, 4) in px/s: middle and half length."""
    early, late = (at(second, times + ahead + shift)[:, :4] for shift in (-STEP, STEP))
    return np.asarray((late - early) / (2.0 * STEP))


def by_meeting(views: Views, frames: Numbers, length: float, rig: Rig, start: float) -> Clock | None:
    """The clock offset at which one device explains both views best.

    Gauss-Newton in the offset and the device's length as seen: of the numbers' change with them only what no change of
    pose explains counts. Linear in the numbers, so what they and the rig are off by all along goes through to the
    offset as it is.

    Parameters
    ----------
    frames
        (n,): numbers of the first view's frames on which both agree.
    length
        Of the device as seen (m).
    start
        Offset (s), right to some milliseconds.

    Returns
    -------
    Clock or None
        None where too few frames are left, or the device does not move across the lines of sight.
    """
    value = start
    for _ in range(ROUNDS):
        near = _linear(views, frames, rig, value, length)
        if near is None:
            return None
        value, length = np.array([value, length]) - np.einsum("pnk,nk->p", near.influence, near.fit.rest)
    near = _linear(views, frames, rig, value, length)
    if near is None:
        return None
    numbers = -near.influence[0] / near.spread
    fresh, lasting = (np.concatenate(pair) for pair in zip(*((v.fresh, v.lasting) for v in views), strict=True))
    own = float(np.sqrt(np.sum((numbers * fresh) ** 2)))
    by_number = numbers.sum(axis=0)
    if not rig.variants:
        own = float(np.hypot(own, _by_accuracy(rig, by_number, near.fit.middle)))
    variants = [float(np.sum(near.influence[0] * near.beside(replace(rig, cameras=pair)))) for pair in rig.variants]
    return Clock(float(value), True, own, by_number, np.array(variants), lasting)


class _Linear(NamedTuple):
    """Both views' rows at an offset, the fit to them, its standard deviations (n, 8), and by how much offset and length
    follow numbers over those (2, n, 8)."""

    rows: tuple[Floats, Floats]
    fit: Fit
    length: float
    spread: Floats
    influence: Floats

    def beside(self, rig: Rig, longer: float = 0.0) -> Floats:
        """By how much the numbers over their standard deviations differ by another rig, or of a longer device."""
        middle, axis = self.fit.middle, self.fit.axis
        return np.asarray(residuals(rig, self.rows, middle, axis, self.length + longer) - self.fit.rest)


def _linear(views: Views, frames: Numbers, rig: Rig, value: float, length: float) -> _Linear | None:
    """None where too few frames are left, or the numbers do not tell the offset."""
    first, second = (view.sighting for view in views)
    time = first.time[frames]
    rates, other = clock_rates(second, time, value), at(second, time + value)
    good = np.isfinite(rates[:, 0]) & np.isfinite(other[:, 0])
    if good.sum() < LEAST_FRAMES:
        return None
    rows = (first.rows[frames[good]], other[good])
    fit = solve(rig, *rows, length)
    spread = np.concatenate([part[:, SDS] for part in rows], axis=1)
    moved = along_and_across(rates[good], rows[1][:, HALF])
    near = _Linear(rows, fit, length, spread, np.zeros((2, *spread.shape)))
    slopes = np.stack(
        [np.concatenate([np.zeros_like(moved), moved], axis=1) / spread, near.beside(rig, LENGTH_STEP) / LENGTH_STEP],
        axis=2,
    )
    influence = _influence(_unexplained(fit.gain * spread[:, None, :], slopes))
    return None if influence is None else near._replace(influence=influence)


def _by_accuracy(rig: Rig, numbers: Floats, places: Floats) -> float:
    """Standard deviation (s) of an offset by a rig of which only its accuracy is known: each view may be off by it."""
    scales = [float(np.median(camera.scale(places))) for camera in rig.cameras]
    along = (numbers[0] + numbers[2], numbers[4] + numbers[6])
    return rig.accuracy * float(np.hypot(scales[0] * along[0], scales[1] * along[1]))


def _influence(slopes: Floats) -> Floats | None:
    """By how much offset and length follow numbers over their standard deviation: (2, n, 8); None where they do not."""
    size = np.sqrt(np.sum(slopes**2, axis=(0, 1)))
    if not np.all(size > 0.0):
        return None
    scaled = slopes / size
    normal = np.einsum("nkp,nkq->pq", scaled, scaled)
    return np.asarray(np.einsum("pq,nkq->pnk", np.linalg.pinv(normal, hermitian=True), scaled) / size[:, None, None])


def _unexplained(gain: Floats, change: Floats) -> Floats:
    """What is left of changes (n, 8, k) once the pose, which moves by ``gain`` (n, 5, 8) with them, has followed."""
    ways, _ = np.linalg.qr(gain.transpose(0, 2, 1))
    return np.asarray(change - ways @ (ways.transpose(0, 2, 1) @ change))


def by_rolls(views: Views, rig: Rig, met: Offset) -> Clock | None:
    """The clock offset at which both views show the same roll; ``met`` says which turn is meant.

    Returns
    -------
    Clock or None
        None where a view does not show the roll, or :func:`by_roll` finds none.
    """
    one, two = views[0].roll, views[1].roll
    if one is None or two is None or min(one.time.size, two.time.size) < 2:
        return None
    rolled = by_roll(met, one.time, two.time, (one.angle, two.angle), float(np.hypot(one.sd, two.sd)))
    if not rolled.found:
        return None
    rate = rolling(one.time, one.angle)
    numbers = np.zeros(8)
    numbers[[0, 4]] = one.by_end / rate, -two.by_end / rate
    lasting = np.concatenate([view.lasting for view in views])
    return Clock(rolled.value, True, rolled.sd, numbers, np.zeros(len(rig.variants)), lasting)


def combined(one: Clock, two: Clock) -> Clock:
    """The weighted mean of two tellings that is off least, with what they share; no weight is negative."""
    shared = float(np.sum(one.numbers * two.numbers * one.lasting**2) + np.sum(one.variants * two.variants))
    variances = (one.sd**2, two.sd**2)
    apart = variances[0] + variances[1] - 2.0 * shared
    share = float(np.clip((variances[1] - shared) / apart, 0.0, 1.0)) if apart > 0.0 else 0.5
    return Clock(
        share * one.value + (1.0 - share) * two.value,
        True,
        float(np.hypot(share * one.own, (1.0 - share) * two.own)),
        share * one.numbers + (1.0 - share) * two.numbers,
        share * one.variants + (1.0 - share) * two.variants,
        one.lasting,
    )
