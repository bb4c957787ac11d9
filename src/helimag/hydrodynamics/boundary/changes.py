"""What walls take from a device's mobility, from what they add to its resistance."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.tables import WallTable
from helimag.hydrodynamics.inversion import mobility

Floats = NDArray[np.float64]


def mobility_changes(table: WallTable, free: Floats, viscosity: float) -> tuple[Floats, Floats]:
    """What a wall adds to the mobility times the middle's distance, at a table's nodes.

    The mobility in open water is averaged over the roll angle for the difference, as the table is. The change is taken
    apart into what is the same however the device rolls and what leans towards the wall, for which see
    :func:`leaning_over_cosines`.

    Parameters
    ----------
    table
        What the wall adds to the resistance.
    free
        Resistance (6, 6) in open water, SI, body frame.
    viscosity
        Pa s.

    Returns
    -------
    even, leaning : (2, gaps, tilts, 6, 6)
        m times m/(N s), and so on; level frame.
    """
    level = even_part(free)
    open_water = mobility(level)
    changes = np.empty((2, table.gaps.size, table.tilts.shape[1], 6, 6))
    for side, row, column in np.ndindex(changes.shape[:3]):
        tilt = table.tilts[side, column]
        distance = table.gaps[row] + table.reach[side, column + 1] + table.middle * math.sin(tilt)
        added = viscosity * table.values[side, row + 1, column + 1] / distance
        changes[side, row, column] = distance * (mobility(level + added) - open_water)
    even = even_part(changes)
    return even, leaning_over_cosines(changes - even, table.tilts)


def even_part(matrix: Floats) -> Floats:
    """What of 6x6 matrices (..., 6, 6) stays the same under turns about the x axis: their mean over those."""
    even = np.zeros_like(matrix)
    for i in (0, 3):
        for j in (0, 3):
            even[..., i, j] = matrix[..., i, j]
            y, z = i + 1, j + 1
            even[..., y, z] = even[..., y + 1, z + 1] = 0.5 * (matrix[..., y, z] + matrix[..., y + 1, z + 1])
            even[..., y, z + 1] = 0.5 * (matrix[..., y, z + 1] - matrix[..., y + 1, z])
            even[..., y + 1, z] = -even[..., y, z + 1]
    return even


def leaning_over_cosines(matrix: Floats, tilts: Floats) -> Floats:
    """What leans towards a wall, over the tilt's cosine once for each of its axes (y, z) across the long one.

    It is smooth as the long axis turns upright, where the matrix fades with the cosines; there it follows from the
    parabola through the three tilts before.

    Parameters
    ----------
    matrix
        (2, n, m, 6, 6), level frame, without its even part.
    tilts
        (2, m), rad: the first is upright on the first side, the last on the second.
    """
    across = np.array([0, 1, 1, 0, 1, 1])
    powers = across[:, None] + across
    result: Floats = matrix / np.cos(tilts)[:, None, :, None, None] ** powers
    result[0, :, 0] = 3.0 * result[0, :, 1] - 3.0 * result[0, :, 2] + result[0, :, 3]
    result[1, :, -1] = 3.0 * result[1, :, -2] - 3.0 * result[1, :, -3] + result[1, :, -4]
    return result
