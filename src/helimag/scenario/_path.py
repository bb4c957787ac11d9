"""A magnet path given by samples, in place of the closed form of eqs (1)-(3)."""

import math
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._device import Part
from helimag.scenario._fields import Angle, Instant, Length, Speed

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]


class Path(Part):
    """Where the magnet's centre is over time, and where its rotation axis points; cubic splines join the samples.

    The rotation axis is R_z(yaw) R_y(-pitch) x, as in eq. (3). Without ``yaw`` it does not yaw; without ``pitch`` it
    keeps the drive's. ``phase`` is what the moment is ahead of an even spin at the drive's frequency. In place of
    ``time`` there may be ``speed``: that of each straight way from one waypoint to the next.
    """

    position: tuple[tuple[Length, Length, Length], ...]
    """Places of the magnet's centre in the lab frame, joined by a smooth curve."""
    time: tuple[Instant, ...] = ()
    """When it is there, from 0 on; or ``speed`` in its place."""
    speed: tuple[Speed, ...] = ()
    """Speed on each straight way from one place to the next, one fewer than places."""
    yaw: tuple[Angle, ...] = ()
    """Yaw of the axis of rotation at each place, as ``drive.yaw_rate`` counts it; 0 if left out."""
    pitch: tuple[Angle, ...] = ()
    """Pitch of the axis of rotation at each place; ``drive.pitch`` if left out."""
    phase: tuple[Angle, ...] = ()
    """Angle that the moment is ahead of an even spin at ``drive.frequency``, at each place; 0 if left out."""

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        count = len(self.position)
        if count < 2:
            raise InputError(f".position must have two samples or more; got {count}")
        if bool(self.time) == bool(self.speed):
            raise InputError("must have either time or speed, one and not both")
        wanted = {"time": count, "speed": count - 1, "yaw": count, "pitch": count, "phase": count}
        for name, number in wanted.items():
            got = len(getattr(self, name))
            if got not in {0, number}:
                raise InputError(f".{name} must have {number} values for {count} positions; got {got}")
        if not (self.times[0] == 0.0 and np.all(np.diff(self.times) > 0.0)):
            raise InputError(
                ".time must begin at 0 s and rise from sample to sample; with speed, no waypoint may repeat"
            )
        if not all(abs(pitch) < math.pi / 2.0 for pitch in self.pitch):
            raise InputError(
                f".pitch must be between -90 deg and 90 deg; got '{q.show(max(self.pitch, key=abs), q.ANGLE)}'"
            )
        return self

    @property
    def times(self) -> Floats:
        """Times of the samples (n,) in s."""
        if self.time:
            return np.array(self.time)
        ways = np.linalg.norm(np.diff(np.array(self.position), axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(ways / np.array(self.speed))])

    @property
    def duration(self) -> float:
        """Time of the last sample (s)."""
        return float(self.times[-1])

    def spline(self, pitch: float) -> "CubicSpline":
        """Cubic spline of x, y, z (m), yaw, pitch, phase (rad), (n, 6); ``pitch`` where the path has none."""
        from scipy.interpolate import CubicSpline

        count = len(self.position)
        angles = [self.yaw or [0.0] * count, self.pitch or [pitch] * count, self.phase or [0.0] * count]
        return CubicSpline(self.times, np.column_stack([np.array(self.position), *angles]))
