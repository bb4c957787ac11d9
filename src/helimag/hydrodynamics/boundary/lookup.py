"""A table near a plane over quantities that cost a kernel neither a logarithm nor an arc.

The tilt by the tangent of its half; the gap *stretched*, the sum of g / (g + l) for two lengths l, which rises much as
its logarithm does from the smaller to the larger.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.splines import resampled, spline_coefficients, spline_cubics
from helimag.hydrodynamics.boundary.tables import WallTable

Floats = NDArray[np.float64]

ROWS, COLUMNS = 21, 12  # nodes over the gap, cells over the tilt of either side: as fine as tables are
NEAR, FAR = 3.0, 1.0 / 3.5  # the two lengths, of a table's least gap and of its largest


@dataclass(frozen=True)
class LookUp:
    """Where a table is looked up.

    Attributes
    ----------
    table
        Whose it is.
    near, far
        The two lengths by which gaps are stretched (m).
    rows
        Gaps of the rows, stretched and evenly spaced (ROWS,).
    halves
        Tangents of half the tilt at the columns' edges, evenly spaced (2, COLUMNS + 1).
    """

    table: WallTable
    near: float
    far: float
    rows: Floats
    halves: Floats

    def cubics(self, values: Floats) -> Floats:
        """Values over a table's tilts as cubics of the columns.

        Parameters
        ----------
        values
            (2, m, ...), at the table's tilts.

        Returns
        -------
        ndarray
            (2, COLUMNS, ..., 4), see :func:`spline_cubics`.
        """
        places = [
            _counted(2.0 * np.arctan(half), tilts) for half, tilts in zip(self.halves, self.table.tilts, strict=True)
        ]
        sides = [spline_cubics(resampled(side, 0, at), 0) for side, at in zip(values, places, strict=True)]
        return np.stack(sides)

    def surface(self, values: Floats) -> Floats:
        """Values over a table's gaps and tilts as splines from row to row of cubics of the columns.

        Parameters
        ----------
        values
            (2, n, m, ...), at the table's gaps and tilts.

        Returns
        -------
        ndarray
            (2, COLUMNS, ROWS + 2, 4, ...), see :func:`spline_coefficients`.
        """
        at = _counted(np.log(unstretched(self.rows, self.near, self.far)), np.log(self.table.gaps))
        over_rows = spline_coefficients(resampled(values, 1, at), 1)
        return np.moveaxis(self.cubics(np.moveaxis(over_rows, 2, 1)), -1, 3)


def look_up(table: WallTable) -> LookUp:
    """Where the kernels look a table up."""
    near, far = NEAR * table.gaps[0], FAR * table.gaps[-1]
    low, high = stretched(table.gaps[[0, -1]], near, far)
    first, last = np.tan(0.5 * table.tilts[:, [0, -1]]).T
    return LookUp(table, near, far, np.linspace(low, high, ROWS), np.linspace(first, last, COLUMNS + 1, axis=1))


def stretched(gaps: Floats, near: float, far: float) -> Floats:
    """Gaps stretched by two lengths."""
    found: Floats = gaps / (gaps + near) + gaps / (gaps + far)
    return found


def unstretched(rows: Floats, near: float, far: float) -> Floats:
    """Gaps from stretched ones: the positive root of a quadratic."""
    linear = (rows - 1.0) * (near + far)
    root = np.sqrt(linear**2 + 4.0 * (2.0 - rows) * rows * near * far)
    found: Floats = (linear + root) / (2.0 * (2.0 - rows))
    return found


def _counted(places: Floats, nodes: Floats) -> Floats:
    """Places in nodes from the first, of evenly spaced ones."""
    counted: Floats = (places - nodes[0]) / (nodes[-1] - nodes[0]) * (nodes.size - 1)
    return counted
