"""Cubic splines over evenly spaced nodes, by the coefficients of their B-splines."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# uniform cubic B-splines between the second and third of four: their polynomials, lowest power first
PIECES = np.array([[1.0, -3.0, 3.0, -1.0], [4.0, 0.0, -6.0, 3.0], [1.0, 3.0, 3.0, -3.0], [0.0, 0.0, 0.0, 1.0]]) / 6.0


def spline_coefficients(values: Floats, axis: int) -> Floats:
    """Coefficients of the cubic spline through values at evenly spaced nodes, with no third derivative at its ends.

    Its second derivative is continuous, so that what is looked up changes smoothly from cell to cell. Between two nodes
    it is the sum of four coefficients, from that of the node before, times the uniform B-splines there.
    SciPy's splines have other knots at the ends, or mirror there; its own are what a test holds these against.

    Parameters
    ----------
    values
        At four nodes or more along ``axis``.

    Returns
    -------
    ndarray
        The same shape with two more along the axis: one before the first node, one behind the last.

    Source: C. de Boor, A Practical Guide to Splines, 2001, ch. IX and IV (parabolic run-out).
    """
    count = values.shape[axis] + 2
    system = np.zeros((count, count))
    for node in range(1, count - 1):
        system[node, node - 1 : node + 2] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    system[0, :4] = system[-1, -4:] = 1.0, -3.0, 3.0, -1.0
    along = np.moveaxis(values, axis, 0)
    right = np.zeros((count, *along.shape[1:]))
    right[1:-1] = along
    found = np.linalg.solve(system, right.reshape(count, -1)).reshape(right.shape)
    return np.ascontiguousarray(np.moveaxis(found, 0, axis))


def spline_cubics(values: Floats, axis: int) -> Floats:
    """The same spline by its polynomials.

    Parameters
    ----------
    values
        At ``n`` nodes, four or more, along ``axis``.

    Returns
    -------
    ndarray
        The same shape but for ``n - 1`` along the axis, and one axis more at the end: four coefficients over the place
        between two nodes, 0 to 1, lowest power first.
    """
    coefficients = spline_coefficients(values, axis)
    cells = np.lib.stride_tricks.sliding_window_view(coefficients, 4, axis)
    found: Floats = np.einsum("...i,ij->...j", cells, PIECES)
    return found


def resampled(values: Floats, axis: int, places: Floats) -> Floats:
    """Values of the same spline elsewhere.

    Parameters
    ----------
    values
        At four nodes or more along ``axis``.
    places
        Where, counted in nodes from the first (m,).

    Returns
    -------
    ndarray
        The same shape with ``m`` along the axis.
    """
    cubics = np.moveaxis(spline_cubics(values, axis), axis, 0)
    cells = np.clip(places.astype(int), 0, cubics.shape[0] - 1)
    powers = (places - cells)[:, None] ** np.arange(4)
    return np.moveaxis(np.einsum("c...p,cp->c...", cubics[cells], powers), 0, axis)
