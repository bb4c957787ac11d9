"""How noisy the detections of one view are: from frame to frame, as their neighbours tell."""

import numpy as np
from numpy.typing import NDArray

from helimag.runs.smoothing import POINTS, sharpened
from helimag.vision.tracking.detection import HALF, MIDDLE, RISE

Floats = NDArray[np.float64]

EXPECTED = np.array([0.03, 0.01, 0.04, 0.02])  # px, of a usual film: what is assumed before a film tells
WORTH = 4.0  # samples that the assumption is worth
ENOUGH = 5  # samples without a gap around from which the others, which a polynomial follows less well, do not count
LEFT = 0.1  # share of a sample's noise that a fit must leave to tell anything


def frame_noise(time: Floats, rows: Floats, interval: float) -> Floats:
    """Standard deviations (4,) in px of a view's detections, independent from frame to frame.

    Of the head's end along, the middle across, the other end along and the half length across, from what a local
    polynomial over time leaves.

    Parameters
    ----------
    time, rows
        (n,) in s and (n, 13), NaN where the device was not seen.
    interval
        Between frames (s).
    """
    seen = np.isfinite(rows[:, RISE])
    square, count = WORTH * EXPECTED**2, np.full(4, WORTH)
    if seen.sum() > 1:
        values = rows[seen][:, [0, 1, 2, 3]]
        smoothed, weights = sharpened(time[seen], values, interval)
        # what is left of independent noise: the sample less the weighted sum that it is part of
        left = 1.0 - 2.0 * weights[:, weights.shape[1] // 2] + np.sum(weights * weights, axis=1)
        rest = values - smoothed
        along = values[:, HALF] / np.linalg.norm(values[:, HALF], axis=1, keepdims=True)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        middle, half = rest[:, MIDDLE], rest[:, HALF]
        parts = [
            np.sum((middle + half) * along, axis=1),
            np.sum(middle * across, axis=1),
            np.sum((middle - half) * along, axis=1),
            np.sum(half * across, axis=1),
        ]
        told = left > LEFT
        whole = told & _whole(time[seen], interval)
        if whole.sum() >= ENOUGH:
            told = whole
        for number, part in enumerate(parts):
            clean = part[told] ** 2 / left[told]
            # a bubble or a lost corner is not noise: beyond three deviations a sample counts no more
            for _ in range(3):
                typical = (square[number] + clean.sum()) / (count[number] + clean.size)
                clean = clean[clean < 9.0 * typical]
            square[number] += clean.sum()
            count[number] += clean.size
    return np.asarray(np.sqrt(square / count))


def _whole(time: Floats, interval: float) -> NDArray[np.bool_]:
    """Whether all frames are there that a smoothed sample (n,) depends on."""
    reach = 2 * (POINTS // 2)
    whole = np.zeros(time.size, dtype=bool)
    if time.size > 2 * reach:
        span = time[2 * reach :] - time[: -2 * reach]
        whole[reach:-reach] = span < (2 * reach + 0.5) * interval
    return whole
