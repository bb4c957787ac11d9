"""Light through a flat wall: from air through plexiglass into oil, and back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError

Floats = NDArray[np.float64]

SWEEPS = 12  # of Newton's method; it needs 4 to 6 for 1e-14


@dataclass(frozen=True)
class Wall:
    """A flat wall of the tank, with the camera on its outer side.

    Parameters
    ----------
    point
        (3,): any point on the outer face (m).
    normal
        (3,): unit vector from the camera's side into the tank.
    thickness
        Of the wall (m).
    indices
        Refractive indices of what is before the wall, of the wall, and of what is behind it.
    """

    point: Floats
    normal: Floats
    thickness: float
    indices: tuple[float, float, float] = (1.0, 1.49, 1.40)

    def __post_init__(self) -> None:
        if not (np.abs(self.normal).max() < 2.0 and abs(float(np.linalg.norm(self.normal)) - 1.0) < 1e-9):
            raise InputError("wall.normal must be a unit vector")
        if not self.thickness >= 0.0:
            raise InputError(f"wall.thickness must not be negative; got {self.thickness} m")
        if not min(self.indices) >= 1.0:
            raise InputError(f"wall.indices must be at least 1; got {self.indices}")


def bend(direction: Floats, normal: Floats, before: float, behind: float) -> Floats:
    """Snell's law for unit vectors: direction behind a flat face. (..., 3) and (3,), along the ray; NaN where none
    passes.

    The part along the face scales with the ratio of the indices; the part along the normal keeps the length one.
    """
    along = (direction @ normal)[..., None] * normal
    across = (before / behind) * (direction - along)
    rest = 1.0 - np.sum(across * across, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.asarray(across + np.sqrt(rest) * normal)


def through(origin: Floats, direction: Floats, wall: Wall) -> tuple[Floats, Floats]:
    """Follow rays from a camera through the wall.

    Parameters
    ----------
    origin
        (3,): the camera's centre (m).
    direction
        (..., 3): unit vectors in air, towards the tank.

    Returns
    -------
    tuple
        Where each ray leaves the inner face (m) and its unit direction there, each (..., 3).
    """
    at_wall = origin + direction * (((wall.point - origin) @ wall.normal) / (direction @ wall.normal))[..., None]
    inside = bend(direction, wall.normal, wall.indices[0], wall.indices[1])
    leaving = at_wall + inside * (wall.thickness / (inside @ wall.normal))[..., None]
    return leaving, bend(inside, wall.normal, wall.indices[1], wall.indices[2])


def sight(camera: Floats, points: Floats, wall: Wall) -> Floats:
    """Direction in which a camera sees points behind a wall.

    Ray, normal and point lie in one plane, so one unknown is left: the sine s of the angle in air, for which the
    lateral
    ways through the three layers, sum_i d_i s / sqrt((n_i / n_0)^2 - s^2), add up to the point's distance from the
    normal
    through the camera. The sum is convex and rises in s; Newton's method from the straight line converges.

    Parameters
    ----------
    camera
        (3,): the camera's centre (m).
    points
        (..., 3): points in the tank (m).

    Returns
    -------
    ndarray
        (..., 3): unit vectors from the camera, in air. NaN for points that are not behind the wall.
    """
    offset = points - camera
    depth = offset @ wall.normal
    lateral = offset - depth[..., None] * wall.normal
    reach = np.linalg.norm(lateral, axis=-1)
    before = float((wall.point - camera) @ wall.normal)
    behind = depth - before - wall.thickness
    behind = np.where(behind >= 0.0, behind, np.nan)
    ratios = np.square([n / wall.indices[0] for n in wall.indices])
    sine = reach / np.hypot(reach, before + wall.thickness + behind)
    for _ in range(SWEEPS):
        roots = [np.sqrt(ratio - sine * sine) for ratio in ratios]
        ways = before / roots[0] + wall.thickness / roots[1] + behind / roots[2]
        slopes = (
            before * ratios[0] / roots[0] ** 3
            + wall.thickness * ratios[1] / roots[1] ** 3
            + behind * ratios[2] / roots[2] ** 3
        )
        change = (sine * ways - reach) / slopes
        sine = np.clip(sine - change, 0.0, 1.0 - 1e-12)
        if not np.any(np.abs(change) > 1e-14):
            break
    with np.errstate(invalid="ignore", divide="ignore"):
        sideways = np.where(reach[..., None] > 0.0, lateral / reach[..., None], 0.0)
    return np.asarray(np.sqrt(1.0 - sine * sine)[..., None] * wall.normal + sine[..., None] * sideways)


def nearest(origins: tuple[Floats, Floats], directions: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Point halfway between two rays where they pass each other, and how far apart they pass: (..., 3) and (...)."""
    between = origins[1] - origins[0]
    cosine = np.sum(directions[0] * directions[1], axis=-1)
    first = np.sum(directions[0] * between, axis=-1)
    second = np.sum(directions[1] * between, axis=-1)
    scale = 1.0 - cosine * cosine
    with np.errstate(invalid="ignore", divide="ignore"):
        on_first = origins[0] + ((first - cosine * second) / scale)[..., None] * directions[0]
        on_second = origins[1] + ((cosine * first - second) / scale)[..., None] * directions[1]
    return (on_first + on_second) / 2.0, np.asarray(np.linalg.norm(on_first - on_second, axis=-1))
