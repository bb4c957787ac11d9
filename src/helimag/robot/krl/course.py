"""Whether a controller can but follow the chords of a spline block: how it joins points is its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.frames import vector_turn

Floats = NDArray[np.float64]

OFF = 1e-6  # m and rad; how far a smooth course may leave the chords
CORNER = 1e-2  # rad; at a larger one between lines and arcs the arm slows down
SHORTEST = 2e-7  # m; a shorter way has no direction in single precision
_AT_END = np.array([3.0, -16.0, 36.0, -48.0, 25.0]) / 12.0  # derivative at the last of five even samples


@dataclass(frozen=True)
class Piece:
    """A motion of a spline block: its kind and duration (s), and tool frames (n, 4, 4) at even times of it."""

    order: str
    duration: float
    poses: Floats

    @property
    def length(self) -> float:
        """Length of the way (m), or of its chords."""
        return float(np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=1).sum())

    @property
    def directions(self) -> tuple[Floats, Floats]:
        """Unit vectors (3,) along the way at its two ends."""
        positions = self.poses[:, :3, 3]
        ends = (-_AT_END @ positions[4::-1], _AT_END @ positions[-5:])
        first, last = (np.asarray(end / np.linalg.norm(end)) for end in ends)
        return first, last

    @property
    def turning(self) -> Floats:
        """Angular velocity (3,) in rad/s, steady."""
        return np.asarray(vector_turn(self.poses[-1, :3, :3] @ self.poses[0, :3, :3].T) / self.duration)


def check_course(pieces: Sequence[Piece]) -> None:
    """Raise InputError where the course of a spline block depends on the controller, or the arm slows down in it.

    A smooth curve through points leaves a chord of length L by no more than L/4 times the angle between the chords
    that meet at its ends: a cubic whose slope is that angle at both. The same holds for the turn of the tool, with
    its rate in place of the slope.
    """
    for one, other in pairwise(pieces):
        if min(one.length, other.length) < SHORTEST or min(one.duration, other.duration) <= 0.0:
            raise InputError("a spline block in which a motion has no length is not followed")
        angle = float(np.linalg.norm(one.directions[1] - other.directions[0]))
        free = [piece for piece in (one, other) if piece.order == "spl"]
        if not free and angle > CORNER:
            raise InputError(f"a spline block slows down at a corner, here of {np.degrees(angle):.2g} deg")
        change = float(np.linalg.norm(one.turning - other.turning))
        off = max((piece.length * angle / 4.0 for piece in free), default=0.0)
        turned = max((piece.duration * change / 4.0 for piece in free), default=0.0)
        if off > OFF or turned > OFF:
            raise InputError(
                "the course of a spline block between its points is the controller's own; it is followed where points "
                f"are so close that it cannot leave the chords by more than 1 um and 1e-6 rad; here it may by "
                f"{1e6 * off:.3g} um and {turned:.2g} rad"
            )
