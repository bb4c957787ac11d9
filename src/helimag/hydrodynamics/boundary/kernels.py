"""Flow of a point force in Stokes flow, in open water and beside a plane: 8 pi mu times velocity per force.

Each takes differences of places as separate components, which broadcast, and returns a 3x3 list of arrays (1/m).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Tensor = list[list[Floats]]
ImageKernel = Callable[[Floats, Floats, Floats, Floats], Tensor]


def stokeslet(x: Floats, y: Floats, z: Floats) -> Tensor:
    """``1/R + r r'/R^3`` in open water (Oseen); zero where the points coincide."""
    square = x * x
    square += y * y
    square += z * z
    square[square == 0.0] = np.inf
    inverse = 1.0 / np.sqrt(square)
    cube = inverse / square
    cx, cy = x * cube, y * cube
    xy, xz, yz = cx * y, cx * z, cy * z
    return [[inverse + cx * x, xy, xz], [xy, inverse + cy * y, yz], [xz, yz, inverse + z * cube * z]]


def surface_image(x: Floats, y: Floats, above: Floats, below: Floats) -> Tensor:
    """What a flat stress-free surface at z = 0 adds: the mirrored force's own flow.

    Parameters
    ----------
    x, y
        From the force to the point, along the surface (m).
    above, below
        Heights of the point and of the force, as distances from the plane (m).
    """
    plain = stokeslet(x, y, above + below)
    return [[row[0], row[1], -row[2]] for row in plain]


def floor_image(x: Floats, y: Floats, above: Floats, below: Floats) -> Tensor:
    """What a flat no-slip wall at z = 0 adds: J. R. Blake, Proc. Camb. Phil. Soc. 70 (1971) 303.

    Parameters as for `surface_image`. A force at height h has an image of opposite force, a source doublet of strength
    2 h^2 and a Stokes doublet of strength 2 h, both with the sign of their component along z turned.
    """
    z, height = above + below, below
    square = x * x + y * y + z * z
    inverse = 1.0 / np.sqrt(square)
    cube = inverse / square
    fifth = 3.0 * cube / square
    r = x, y, z
    tensor: Tensor = []
    for i in range(3):
        row = []
        for k in range(3):
            sign = -1.0 if k == 2 else 1.0
            doublet = height * ((i == k) * cube - r[i] * r[k] * fifth)
            stress = -(i == 2) * r[k] * cube + ((i == k) * z + (k == 2) * r[i]) * cube - r[i] * z * r[k] * fifth
            row.append(-((i == k) * inverse + r[i] * r[k] * cube) + 2.0 * height * sign * (doublet - stress))
        tensor.append(row)
    return tensor
