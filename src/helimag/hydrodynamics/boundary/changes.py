"""What walls take from a device's mobility, from what they add to its resistance."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.tables import WallTable, padded
from helimag.hydrodynamics.inversion import mobility

Floats = NDArray[np.float64]


def mobility_changes(table: WallTable, free: Floats, viscosity: float) -> Floats:
    """What a wall adds to the mobility times the middle's distance, at the nodes of a table and one row beyond.

    The mobility in open water is averaged over the roll angle for the difference, as the table is.

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
    (2, gaps + 2, tilts + 2, 6, 6)
        m times m/(N s), and so on; level frame.
    """
    level = _averaged_over_roll(free)
    open_water = mobility(level)
    changes = np.empty((2, table.gaps.size, table.tilts.shape[1], 6, 6))
    for side, row, column in np.ndindex(changes.shape[:3]):
        tilt = table.tilts[side, column]
        distance = table.gaps[row] + table.reach[side, column + 1] + table.middle * math.sin(tilt)
        added = viscosity * table.values[side, row + 1, column + 1] / distance
        changes[side, row, column] = distance * (mobility(level + added) - open_water)
    return padded(padded(changes, 1), 2)


def _averaged_over_roll(matrix: Floats) -> Floats:
    """Mean of a 6x6 over turns about the x axis (three suffice: second harmonics are the highest)."""
    total = np.zeros((6, 6))
    for roll in 2.0 * np.pi * np.arange(3) / 3.0:
        cos, sin = np.cos(roll), np.sin(roll)
        turn = np.kron(np.eye(2), [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])
        total += turn @ matrix @ turn.T
    return total / 3.0
