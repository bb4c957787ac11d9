"""How noisy the detections of one view are: from frame to frame, as their neighbours tell."""

import numpy as np
from numpy.typing import NDArray

from helimag.vision.tracking.detection import HALF, RISE, along_and_across
from helimag.vision.tracking.drawings import phases

Floats = NDArray[np.float64]

EXPECTED = np.array([0.03, 0.01, 0.04, 0.02])  # px, of a usual film: what is assumed before a film tells
WORTH = 4.0  # samples that the assumption is worth
WINDOW = 11  # sightings in a row to which a motion is fitted
WIDEST = 1.4  # times as long as without lost frames that these may last
ALIKE = 1e-6  # of the largest singular value: smaller ones are none, as of a device that does not turn
OUTLYING = 9.0  # times the typical variance from which a window does not count: a bubble is not noise


def frame_noise(time: Floats, rows: Floats, interval: float) -> Floats:
    """Standard deviations (4,) in px of a view's detections, independent from frame to frame.

    Of the head's end along, the middle across, the other end along and the half length across: what a parabola over
    time, and swings once and twice in the device's turn, leave of eleven sightings in a row. A device that wobbles does
    so with its turn, which its coil's phase tells; a polynomial alone would leave of a wide swing more than the noise.

    Parameters
    ----------
    time, rows
        (n,) in s and (n, 13), NaN where the device was not seen; phases counted from the nose.
    interval
        Between frames (s).
    """
    seen = np.isfinite(rows[:, RISE])
    time, rows = time[seen], rows[seen]
    square, count = WORTH * EXPECTED**2, np.full(4, WORTH)
    rate = turning(time, rows, interval)
    found = []
    for begin in range(time.size - WINDOW + 1):
        here = slice(begin, begin + WINDOW)
        if time[here][-1] - time[here][0] < WIDEST * (WINDOW - 1) * interval:
            found.append(_left(time[here], rows[here], rate))
    if found:
        variances, worth = (np.array(values) for values in zip(*found, strict=True))
        for number, values in enumerate(variances.T):
            clean = np.ones(values.size, dtype=bool)
            for _ in range(3):
                typical = (square[number] + worth[clean] @ values[clean]) / (count[number] + worth[clean].sum())
                clean = values < OUTLYING * typical
            square[number] += worth[clean] @ values[clean]
            count[number] += worth[clean].sum()
    return np.asarray(np.sqrt(square / count))


def turning(time: Floats, rows: Floats, interval: float) -> float:
    """Rate (rad/s) at which the coil's phase advances; what is a whole turn a frame is not seen."""
    phase, step = phases(rows), np.diff(time)
    ahead = np.exp(1j * np.diff(phase))[np.abs(step / interval - 1.0) < 0.5]
    if not ahead.size:
        return 0.0
    rate = float(np.angle(ahead.mean())) / interval
    off = np.exp(1j * (phase - rate * time))  # a wobble's own swing ends anywhere: the slope of all sees less of it
    rest = np.angle(off / off.mean())
    return rate + float(np.polyfit(time - time.mean(), rest, 1)[0])


def _left(time: Floats, rows: Floats, rate: float) -> tuple[Floats, float]:
    """Variances (4,) in px^2 that a motion leaves of a few sightings, and how many independent samples they are worth,
    as every sighting is in as many windows as a window has sightings."""
    place = (time - time.mean()) / (time[-1] - time[0])
    angle = rate * (time - time.mean())
    waves = [np.cos(angle), np.sin(angle), np.cos(2.0 * angle), np.sin(2.0 * angle)]
    motions = np.stack([np.ones_like(place), place, place**2, *waves], axis=1)
    left, strengths, _ = np.linalg.svd(motions, full_matrices=False)
    fitted = left[:, strengths > ALIKE * strengths[0]]
    free = time.size - fitted.shape[1]
    values = rows[:, :4]
    rest = values - fitted @ (fitted.T @ values)
    parts = along_and_across(rest, values[:, HALF])
    return np.sum(parts**2, axis=0) / free, free / time.size
