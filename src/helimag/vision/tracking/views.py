"""One view's detections made ready to be joined: pointing to the head, less the detector's errors, with their noise."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.cameras import Camera
from helimag.vision.shape import Shape
from helimag.vision.tracking.detection import RISE, SDS
from helimag.vision.tracking.drawings import corrected, detector_errors, from_nose, tilts, turned
from helimag.vision.tracking.noise import frame_noise
from helimag.vision.tracking.pose import DevicePoses
from helimag.vision.tracking.search import Sighting

Floats = NDArray[np.float64]

# of the noise that is fresh in every frame, what a film whose frames are predicted from one another adds all along, to
# the head's end, the middle across, the tail's end and the half length across: what is left out of a frame depends on
# how the device lies, so it returns with every turn; measured by benchmarks/film_errors.py
RETURNING = np.array([0.6, 1.3, 1.1, 0.4])


class PreparedView(NamedTuple):
    """A sighting whose rows point to the head and are corrected; its fresh and lasting standard deviations (4,) in px;
    and where the device's roll is seen, its times (s), rolls and by how much they may be off all along (rad)."""

    sighting: Sighting
    fresh: Floats
    lasting: Floats
    roll: tuple[Floats, Floats, float] | None


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
    near = np.clip(np.searchsorted(time, sighting.time - ahead), 0, time.size - 1)
    head, axis = poses.head[near], poses.axis[near]
    forward = camera.project(head + shape.nose * axis) - camera.project(head + shape.tail * axis)
    rows = from_nose(turned(sighting.rows, forward), forward, shape.turns)
    slender = seen & np.isfinite(rows[:, RISE])
    if not slender.any():
        return PreparedView(sighting._replace(rows=rows), np.zeros(4), np.zeros(4), None)
    errors = detector_errors(camera, poses.head, poses.axis, shape, float(np.median(rows[slender, RISE])))
    fresh = frame_noise(sighting.time, rows, interval)
    if errors is None:
        lasting = np.median(rows[slender, SDS], axis=0)
    else:
        tilt = tilts(camera, head, axis)
        rows = corrected(rows, errors, tilt)
        fresh = frame_noise(sighting.time, rows, interval)
        lasting = errors.left
    if sighting.predicted:
        lasting = np.hypot(lasting, RETURNING * fresh)
    roll = None
    if errors is not None:  # phases count from the nose, whose error turns them all along
        pitch = float(np.median(np.linalg.norm(forward[slender], axis=1))) / shape.turns
        roll_sd = float(np.hypot(errors.roll_sd, 2.0 * np.pi / pitch * lasting[0]))
        roll = (sighting.time[slender], errors.rolls(rows[slender], tilt[slender]), roll_sd)
    rows[slender, SDS] = np.hypot(fresh, lasting)
    return PreparedView(sighting._replace(rows=rows), fresh, lasting, roll)


def parted(rows: Floats, view: PreparedView) -> tuple[Floats, Floats]:
    """Fresh and lasting standard deviations (n, 4) of rows; what is not slender is uncertain for long."""
    slender = np.isfinite(rows[:, RISE])[:, None]
    return np.where(slender, view.fresh, 0.0), np.where(slender, view.lasting, rows[:, SDS])
