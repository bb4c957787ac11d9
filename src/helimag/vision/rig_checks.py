"""Whether what a file says can be two cameras and a tank: a changed number, by hand or by a bad disk, is told."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.vision.cameras import Camera, Rig

Floats = NDArray[np.float64]

FARTHEST = 100.0  # m, of anything from the tank
TURNED = 1e-6  # by how much the rows of a rotation may fail to be unit vectors at right angles
LARGEST_PICTURE = 100_000  # px
STRONGEST_LENS = 1e3  # of a coefficient of distortion
DENSEST, THICKEST = 3.0, 1.0  # index of refraction; m of a wall
LARGEST_ERROR = 1.0  # m


def check_rig(rig: "Rig") -> None:
    """Raise InputError, naming what and its value, where a rig cannot be one."""
    for camera in [*rig.cameras, *(camera for pair in rig.variants for camera in pair)]:
        _check_camera(camera)
    _bounded("tank_m", rig.tank, FARTHEST)
    if not bool(np.all(rig.tank[0] < rig.tank[1])):
        raise InputError(f"tank_m must be its lowest and its highest corner; got {rig.tank.tolist()}")
    if not 0.0 <= rig.accuracy <= LARGEST_ERROR:
        raise InputError(f"accuracy_m must be between 0 and {LARGEST_ERROR:g} m; got {rig.accuracy}")


def _check_camera(camera: "Camera") -> None:
    name = f"camera '{camera.name}'"
    if not all(1 <= side <= LARGEST_PICTURE for side in camera.size):
        raise InputError(f"{name}: size_px must be between 1 and {LARGEST_PICTURE}; got {list(camera.size)}")
    _bounded(f"{name}: matrix_px", camera.matrix, LARGEST_PICTURE)
    focal = camera.matrix[[0, 1], [0, 1]]
    rest = camera.matrix[[0, 1, 2, 2, 2], [1, 0, 0, 1, 2]]
    if focal.min() < 1.0 or not np.array_equal(rest, [0.0, 0.0, 0.0, 0.0, 1.0]):
        raise InputError(
            f"{name}: matrix_px must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; got {camera.matrix.tolist()}"
        )
    _bounded(f"{name}: distortion", camera.distortion, STRONGEST_LENS)
    _bounded(f"{name}: translation_m", camera.translation, FARTHEST)
    _bounded(f"{name}: rotation", camera.rotation, 2.0)
    off = float(np.abs(camera.rotation @ camera.rotation.T - np.eye(3)).max())
    if off > TURNED or np.linalg.det(camera.rotation) < 0.0:
        raise InputError(f"{name}: rotation must be a turn; its rows are off by {off:.2g}, or it is a mirror")
    if camera.wall is not None:
        _bounded(f"{name}: wall.point_m", camera.wall.point, FARTHEST)
        for index in camera.wall.indices:
            if not 1.0 <= index <= DENSEST:
                raise InputError(f"{name}: wall.indices must be between 1 and {DENSEST:g}; got {index}")
        if not 0.0 <= camera.wall.thickness <= THICKEST:
            raise InputError(f"{name}: wall.thickness_m must be up to {THICKEST:g} m; got {camera.wall.thickness}")


def _bounded(what: str, values: Floats, most: float) -> None:
    largest = float(np.abs(values).max(initial=0.0))
    if not math.isfinite(largest) or largest > most:
        raise InputError(f"{what} must hold finite numbers of at most {most:g}; got {values.tolist()}")
