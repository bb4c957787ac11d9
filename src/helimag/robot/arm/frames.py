"""Frames as NumPy arrays, in KUKA's angles: A about z, then B about the new y, then C about the new x."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def rotation(abc: ArrayLike) -> Floats:
    """Rotation matrices (..., 3, 3) of angles A, B, C (..., 3) in radians: Rz(A) Ry(B) Rx(C)."""
    from scipy.spatial.transform import Rotation

    abc = np.asarray(abc, dtype=np.float64)
    return np.asarray(Rotation.from_euler("ZYX", abc.reshape(-1, 3)).as_matrix()).reshape(*abc.shape[:-1], 3, 3)


def angles(matrix: Floats) -> Floats:
    """Angles A, B, C (..., 3) in radians of rotation matrices (..., 3, 3); C is zero where B is upright.

    Not SciPy's ``as_euler``: it warns there, is 6 to 14 times slower, and takes 1e-7 rad from upright as upright.
    """
    level = np.hypot(matrix[..., 0, 0], matrix[..., 1, 0])
    upright = level < 1e-9
    a = np.where(
        upright,
        np.arctan2(-matrix[..., 0, 1], matrix[..., 1, 1]),
        np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0]),
    )
    b = np.arctan2(-matrix[..., 2, 0], level)
    c = np.where(upright, 0.0, np.arctan2(matrix[..., 2, 1], matrix[..., 2, 2]))
    return np.stack([a, b, c], axis=-1)


def frame(position: Sequence[float] | Floats, abc: ArrayLike) -> Floats:
    """Homogeneous frame (4, 4) from a position (m) and angles A, B, C (rad)."""
    result = np.eye(4)
    result[:3, :3] = rotation(abc)
    result[:3, 3] = position
    return result


def frames(positions: Floats, rotations: Floats) -> Floats:
    """Homogeneous frames (..., 4, 4) from positions (..., 3) and rotations (..., 3, 3)."""
    result = np.zeros((*positions.shape[:-1], 4, 4))
    result[..., :3, :3] = rotations
    result[..., :3, 3] = positions
    result[..., 3, 3] = 1.0
    return result


def inverse(matrix: Floats) -> Floats:
    """Inverse of homogeneous frames (..., 4, 4)."""
    back = np.swapaxes(matrix[..., :3, :3], -1, -2)
    return frames(-np.einsum("...ij,...j->...i", back, matrix[..., :3, 3]), back)


def tool_rotation(axis: Floats) -> Floats:
    """Rotation (3, 3) of the tool in the flange frame: x along the motor's axis, z as far back as can be.

    With the motor across the flange, the tool's z then points up when the flange points down. A motor in line with the
    flange has no such direction; its z is the flange's x.
    """
    x = axis / np.linalg.norm(axis)
    back = np.array([0.0, 0.0, -1.0])
    across = back - (back @ x) * x
    if np.linalg.norm(across) < 1e-6:
        across = np.array([1.0, 0.0, 0.0])
    z = across / np.linalg.norm(across)
    return np.stack([x, np.cross(z, x), z], axis=1)


def turn_vector(vector: Floats) -> Floats:
    """Rotations (..., 3, 3) about vectors (..., 3) by their lengths in radians."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vector.reshape(-1, 3)).as_matrix()).reshape(*vector.shape[:-1], 3, 3)


def vector_turn(matrix: Floats) -> Floats:
    """The vector (3,) about which a rotation (3, 3) turns, its length the angle in radians, at most half a turn."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrix).as_rotvec())
