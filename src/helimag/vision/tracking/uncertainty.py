"""Covariance of a tracked device: noise that smoothing averages, errors that it does not, clock and calibration."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.cameras import Rig
from helimag.vision.shape import Shape
from helimag.vision.tracking.clock import Clock
from helimag.vision.tracking.pose import DevicePoses

Floats = NDArray[np.float64]

AROUND = 5  # samples over which it is judged whether noise explains what smoothing takes away
BEYOND_NOISE = 4.0  # times the variance that noise would have; noise alone exceeds that once in a thousand


class Deviations(NamedTuple):
    """Of the eight measured numbers of each frame (n, 8) in px: what is fresh in every frame, what stays as long as a
    smoothing window, and by how much the numbers move with the clock offset (px/s)."""

    fresh: Floats
    lasting: Floats
    clock: Floats


class Covariances(NamedTuple):
    """Of head (n, 3, 3) in m^2 and long axis (n, 3, 3), and of the head what differs from frame to frame."""

    head: Floats
    axis: Floats
    head_noise: Floats


def covariances(
    rig: Rig, shape: Shape, poses: DevicePoses, spread: Deviations, clock: Clock, calm: Floats
) -> Covariances:
    """Add up what is uncertain about each pose.

    What the numbers and the rig are off by all along moves a pose itself, and once more by way of the clock.

    Parameters
    ----------
    clock
        With which the second view was brought to the first one's instants.
    calm
        (n,): share of the fresh noise's variance that smoothing leaves.
    """
    moved = rig.shifts(poses.head)
    swung = (moved - rig.shifts(poses.head + shape.tail * poses.axis)) / -shape.tail
    result = []
    for gain, shifts in ((poses.head_gain, moved), (poses.axis_gain, swung)):
        late = np.einsum("nik,nk->ni", gain, spread.clock)
        noise = _carried(gain, spread.fresh * np.sqrt(calm)[:, None])
        lasting = _carried(gain + late[:, :, None] * clock.numbers, spread.lasting)
        shared = late * clock.variants[:, None, None] - shifts  # a rig that puts points ahead finds them behind
        own = clock.own**2 * np.einsum("ni,nj->nij", late, late)
        result.append((noise + lasting + own + np.einsum("kni,knj->nij", shared, shared), noise + lasting))
    (head, head_noise), (axis, _) = result
    return Covariances(head, axis, head_noise)


def noise_variances(poses: DevicePoses, fresh: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Variances (n, 3) of head (m^2) and axis by a share (n,) of the fresh noise's variance."""
    spread = fresh * np.sqrt(np.maximum(share, 0.0))[:, None]
    head, axis = (np.einsum("nii->ni", _carried(gain, spread)) for gain in (poses.head_gain, poses.axis_gain))
    return np.asarray(head), np.asarray(axis)


def taken_away(rest: Floats, expected: Floats) -> Floats:
    """Variance (n, k) of the motion that smoothing takes away with the noise, 0 where noise explains what it takes.

    A swing at 3.5 Hz next to lost frames is not a polynomial: there smoothing is off by more than it gains.

    Parameters
    ----------
    rest
        (n, k): samples less what smoothing makes of them.
    expected
        (n, k): variance of that by noise alone.
    """
    size = min(AROUND, rest.shape[0])
    ones = np.ones(size) / size
    mean, due = (np.apply_along_axis(np.convolve, 0, values, ones, "same") for values in (rest**2, expected))
    return np.where(mean > BEYOND_NOISE * due, np.maximum(rest**2, mean), 0.0)


def _carried(gain: Floats, spread: Floats) -> Floats:
    """Covariance (n, 3, 3) of what moves by ``gain`` (n, 3, 8) with independent numbers."""
    scaled = gain * spread[:, None, :]
    return np.asarray(scaled @ scaled.transpose(0, 2, 1))
