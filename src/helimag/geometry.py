"""Geometry that every room shares: turns, quaternions, the wire of the helix, and where the magnet is (eqs 1-3).

Plain NumPy, of batches. SciPy's ``Rotation`` is the oracle of the tests (equal to rounding), and is used where speed
does not count; here it would cost 0.4 s of import before a run of one second, and takes 1.4 to 7 times as long on the
batches that orbits and arms are made of. The kernels have formulas of their own in
:mod:`helimag.physics.kinematics`; a test holds both against each other.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from helimag.scenario import Drive

Floats = NDArray[np.float64]

CHIRALITY = {"left": 1.0, "right": -1.0}  # sense of the wire in the body frame


def turn(axis: int, angle: ArrayLike) -> Floats:
    """Rotation matrices (..., 3, 3) about coordinate axis 0, 1 or 2 by angles (...,) in radians."""
    angle = np.asarray(angle, dtype=np.float64)
    cos, sin = np.cos(angle), np.sin(angle)
    result = np.zeros((*angle.shape, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result[..., axis, axis] = 1.0
    result[..., i, i] = result[..., j, j] = cos
    result[..., j, i], result[..., i, j] = sin, -sin
    return result


def body_rotations(quaternions: Floats) -> Floats:
    """Matrices (..., 3, 3) from body to lab of unit quaternions (..., 4), scalar first."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def long_axes(quaternions: Floats) -> Floats:
    """Unit vectors (..., 3) from helix to head in the lab frame: the first columns of :func:`body_rotations`."""
    return body_rotations(quaternions)[..., 0]


def quaternion_product(a: Floats, b: Floats) -> Floats:
    """Quaternions (..., 4), scalar first, that turn by ``b`` and then by ``a``."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def helix_line(along: Floats, *, radius: float, pitch: float, chirality: float, behind: float) -> Floats:
    """Points (n, 3) of the wire's centreline in the body frame (m), at lengths ``along`` (n,) of the helix' axis.

    The wire begins ``behind`` the head's centre: ``(-behind - u, R cos ku, chi R sin ku)`` with ``k = 2 pi / pitch``.
    """
    k = 2.0 * math.pi / pitch
    return np.stack([-behind - along, radius * np.cos(k * along), chirality * radius * np.sin(k * along)], axis=1)


@dataclass(frozen=True)
class Poses:
    """Timed poses of the magnet in the lab frame: (n,) seconds, (n, 3) m, (n, 3, 3), and the spin angle (n,) rad.

    The first column of ``rotation`` is the rotation axis; the moment is at ``rotation @ (0, cos spin, sin spin)``.
    """

    time: Floats
    position: Floats
    rotation: Floats
    spin: Floats

    @property
    def axis(self) -> Floats:
        """Rotation axis (n, 3)."""
        return self.rotation[..., :, 0]


def magnet_start(drive: "Drive") -> Floats:
    """The magnet's centre at t = 0 (3,) in m: the first of its path, or eq. (1) with either reading of pitch."""
    return np.array(magnet_place(drive))


def magnet_place(drive: "Drive") -> tuple[float, float, float]:
    """The same as plain numbers: runs of sweeps ask for few things more often."""
    if drive.path is not None:
        return drive.path.position[0]
    x, y, z = drive.start
    z += drive.distance
    if drive.pitch_about == "magnet":
        return x, y, z
    cos, sin = math.cos(drive.pitch), math.sin(drive.pitch)
    return cos * x - sin * z, y, sin * x + cos * z


def magnet_motion(drive: "Drive") -> Callable[[Floats], Poses]:
    """Where the magnet is at times (n,) in s: eqs (1)-(3), or splines through the samples of the drive's path.

    Position R_z(yaw) p0 + v t, rotation R_z(yaw) R_y(-pitch).
    """
    rate = 2.0 * math.pi * drive.frequency
    if drive.path is not None:
        spline = drive.path.spline(drive.pitch)

        def sampled(times: Floats) -> Poses:
            values = spline(times)
            turned = turn(2, values[:, 3]) @ turn(1, -values[:, 4])
            return Poses(times, values[:, :3], turned, rate * times + values[:, 5])

        return sampled
    start, pitched = magnet_start(drive), turn(1, -drive.pitch)

    def driven(times: Floats) -> Poses:
        yawing = turn(2, drive.yaw_rate * times)
        position = np.einsum("nij,j->ni", yawing, start) + times[:, None] * np.array(drive.velocity)
        return Poses(times, position, yawing @ pitched, rate * times)

    return driven
