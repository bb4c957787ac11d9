"""Whether what a file says can be two cameras and a tank: a changed number, by hand or by a bad disk, is told."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]

FARTHEST = 100.0  # m, of anything from the tank
TURNED = 1e-6  # by how much the rows of a rotation may fail to be unit vectors at right angles
LARGEST_PICTURE = 100_000  # px
STRONGEST_LENS = 1e3  # of a coefficient of distortion
DENSEST, THICKEST = 3.0, 1.0  # index of refraction; m of a wall
LARGEST_ERROR = 1.0  # m


def check_tank(tank: Floats, accuracy: float) -> None:
    """Raise InputError, naming what and its value, where corners (2, 3) and an error (m) cannot be those of a tank."""
    _bounded("tank_m", tank, FARTHEST)
    if not bool(np.all(tank[0] < tank[1])):
        raise InputError(f"tank_m must be its lowest and its highest corner; got {tank.tolist()}")
    if not 0.0 <= accuracy <= LARGEST_ERROR:
        raise InputError(f"accuracy_m must be between 0 and {LARGEST_ERROR:g} m; got {accuracy}")


def check_lens(name: str, size: tuple[int, int], matrix: Floats, distortion: Floats) -> None:
    """Raise InputError where a picture's size (px), a matrix (3, 3) and a distortion (5,) cannot be a camera's."""
    if not all(1 <= side <= LARGEST_PICTURE for side in size):
        raise InputError(f"{name}: size_px must be between 1 and {LARGEST_PICTURE}; got {list(size)}")
    _bounded(f"{name}: matrix_px", matrix, LARGEST_PICTURE)
    focal = matrix[[0, 1], [0, 1]]
    rest = matrix[[0, 1, 2, 2, 2], [1, 0, 0, 1, 2]]
    if focal.min() < 1.0 or not np.array_equal(rest, [0.0, 0.0, 0.0, 0.0, 1.0]):
        raise InputError(f"{name}: matrix_px must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; got {matrix.tolist()}")
    _bounded(f"{name}: distortion", distortion, STRONGEST_LENS)


def check_pose(name: str, rotation: Floats, translation: Floats) -> None:
    """Raise InputError where a matrix (3, 3) is no turn, or a translation (3,) in m is out of any laboratory."""
    _bounded(f"{name}: translation_m", translation, FARTHEST)
    _bounded(f"{name}: rotation", rotation, 2.0)
    off = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if off > TURNED or np.linalg.det(rotation) < 0.0:
        raise InputError(f"{name}: rotation must be a turn; its rows are off by {off:.2g}, or it is a mirror")


def check_wall(name: str, wall: Wall) -> None:
    """Raise InputError where a wall has no place, no thickness or no indices that walls have."""
    _bounded(f"{name}: wall.point_m", wall.point, FARTHEST)
    for index in wall.indices:
        if not 1.0 <= index <= DENSEST:
            raise InputError(f"{name}: wall.indices must be between 1 and {DENSEST:g}; got {index}")
    if not 0.0 <= wall.thickness <= THICKEST:
        raise InputError(f"{name}: wall.thickness_m must be up to {THICKEST:g} m; got {wall.thickness}")


def _bounded(what: str, values: Floats, most: float) -> None:
    largest = float(np.abs(values).max(initial=0.0))
    if not math.isfinite(largest) or largest > most:
        raise InputError(f"{what} must hold finite numbers of at most {most:g}; got {values.tolist()}")
