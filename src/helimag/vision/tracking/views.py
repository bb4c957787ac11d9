"""One view's detections made ready to be joined: pointing to the head, less the detector's errors, with their noise."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.cameras import Camera
from helimag.vision.shape import Shape
from helimag.vision.tracking.detection import HALF, MIDDLE, RISE, SDS
from helimag.vision.tracking.drawings import corrected, detector_errors, from_nose, tilts, turned
from helimag.vision.tracking.noise import frame_noise
from helimag.vision.tracking.pose import DevicePoses
from helimag.vision.tracking.search import Sighting

Floats = NDArray[np.float64]

# of the noise that is fresh in every frame, what a film whose frames are predicted from one another adds all along, to
# the head's end, the middle across, the tail's end and the half length across: what is left out of a frame depends on
# how the device lies, so it returns with every turn; measured by benchmarks/film_errors.py on devices that go straight
RETURNING = np.array([0.55, 1.45, 1.05, 0.6])
GRID = 1.0  # px by which a device may swing across before each frame finds it elsewhere on the grid of pixels
AROUND = 11  # sightings whose mean a swing is counted from


class Roll(NamedTuple):
    """The device's roll in one view: times (n,) in s, rolls (n,) in rad, by how much they may be off all along (rad),
    and by how much more a pixel that the head's end is off (rad/px), since the coil's phase is counted from it."""

    time: Floats
    angle: Floats
    sd: float
    by_end: float


class PreparedView(NamedTuple):
    """A sighting whose rows point to the head and are corrected; its fresh and lasting standard deviations (4,) in px;
    and where the device's roll is seen, the roll."""

    sighting: Sighting
    fresh: Floats
    lasting: Floats
    roll: Roll | None


def prepared(
    sighting: Sighting, camera: Camera, shape: Shape, time: Floats, poses: DevicePoses, ahead: float, interval: float
) -> PreparedView:
    """Make a view's detections ready, with poses that a first fit found.

    Parameters
    ----------
    time
        (n,): of the poses, on the first camera's clock (s).
    ahead
        How far this view's clock is ahead (s).
    """
    seen = np.isfinite(sighting.rows[:, 0])
    head, axis = (_between(sighting.time - ahead, time, values) for values in (poses.head, poses.axis))
    forward = camera.project(head + shape.nose * axis) - camera.project(head + shape.tail * axis)
    rows = from_nose(turned(sighting.rows, forward), forward, shape.turns)
    slender = seen & np.isfinite(rows[:, RISE])
    if not slender.any():
        return PreparedView(sighting._replace(rows=rows), np.zeros(4), np.zeros(4), None)
    errors = detector_errors(camera, poses.head, poses.axis, shape, float(np.median(rows[slender, RISE])))
    fresh = frame_noise(sighting.time, rows, interval)
    lasting, roll = np.median(rows[slender, SDS], axis=0), None
    if errors is not None:
        tilt = tilts(camera, head, axis)
        rows = corrected(rows, errors, tilt)
        fresh = frame_noise(sighting.time, rows, interval)
        lasting = errors.left
        pitch = float(np.median(np.linalg.norm(forward[slender], axis=1))) / shape.turns
        by_end = errors.sense * 2.0 * np.pi / pitch
        roll = Roll(sighting.time[slender], errors.rolls(rows[slender], tilt[slender]), errors.roll_sd, by_end)
    if sighting.predicted:
        lasting = np.hypot(lasting, returning(rows[slender], fresh))
    rows[slender, SDS] = np.hypot(fresh, lasting)
    return PreparedView(sighting._replace(rows=rows), fresh, lasting, roll)


def _between(now: Floats, time: Floats, values: Floats) -> Floats:
    """Values (m, 3) at instants ``now`` on straight lines through those (n, 3) at ``time``; at the ends as there."""
    return np.stack([np.interp(now, time, column) for column in values.T], axis=1)


def returning(rows: Floats, fresh: Floats) -> Floats:
    """Standard deviations (4,) in px of what prediction leaves out of frames as often as the device comes back.

    A device that swings across comes to lie elsewhere on the grid of pixels, so its errors across are fresh each time.
    """
    middle = rows[:, MIDDLE]
    swing = 0.0
    if middle.shape[0] >= AROUND:
        mean = np.stack([np.convolve(column, np.ones(AROUND) / AROUND, "valid") for column in middle.T], axis=1)
        inner = slice(AROUND // 2, AROUND // 2 + mean.shape[0])
        away, half = middle[inner] - mean, rows[inner, HALF]
        across = away[:, 1] * half[:, 0] - away[:, 0] * half[:, 1]
        swing = float(np.sqrt(np.mean((across / np.linalg.norm(half, axis=1)) ** 2)))
    share = 1.0 / np.hypot(1.0, swing / GRID)
    return np.asarray(RETURNING * np.array([1.0, share, 1.0, share]) * fresh)


def parted(rows: Floats, view: PreparedView) -> tuple[Floats, Floats]:
    """Fresh and lasting standard deviations (n, 4) of rows; what is not slender is uncertain for long."""
    slender = np.isfinite(rows[:, RISE])[:, None]
    return np.where(slender, view.fresh, 0.0), np.where(slender, view.lasting, rows[:, SDS])
