"""Finer and finer surfaces, until two of them and what they extrapolate to agree within a tolerance."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.hydrodynamics.boundary.solve import MOST, Plane, surface_resistance

Floats = NDArray[np.float64]

ORDER = 1.5  # of the error in the size of the triangles; measured: 3 on smooth bodies, 2 on wires, 1 at sharp edges
CAUTION = 1.5  # the estimated error over the extrapolation's last step; covers true orders from 0.8 upwards
SMALL = 0.05  # couplings below this share of their diagonal entries are judged against that share


@dataclass(frozen=True)
class Solution:
    """The resistance of a body from two or more surfaces.

    Attributes
    ----------
    resistance
        6x6 per viscosity, translation first, about the body's origin (m, m^2, m^3): extrapolated from the two finest.
    error_estimate
        Relative: what the largest error of an entry should not exceed, see `relative_difference`.
    triangles
        How many each surface has, coarsest first.
    levels
        The resistance that each surface has by itself.
    """

    resistance: Floats
    error_estimate: float
    triangles: tuple[int, ...]
    levels: tuple[Floats, ...]


def refined(surfaces: Iterator[Mesh], tolerance: float, plane: Plane | None = None) -> Solution:
    """Solve on finer and finer surfaces of one body until the estimated error is below a tolerance.

    Parameters
    ----------
    surfaces
        Of the same body, each finer than the one before.
    tolerance
        Relative.
    plane
        A floor or surface beside the body.

    Raises
    ------
    InputError
        Where the tolerance is not reached on the finest surface that fits the solver.
    """
    triangles: list[int] = []
    levels: list[Floats] = []
    best = np.inf
    for mesh in chain(_two_that_fit(surfaces), surfaces):
        if len(mesh) > MOST:
            break
        triangles.append(len(mesh))
        levels.append(surface_resistance(mesh, plane))
        if len(levels) < 2:
            continue
        found = extrapolated(levels[-2], levels[-1], float(np.sqrt(triangles[-1] / triangles[-2])))
        best = CAUTION * relative_difference(levels[-1], found)
        if best <= tolerance:
            return Solution(found, best, tuple(triangles), tuple(levels))
    raise InputError(
        f"device.hydrodynamics.tolerance of {tolerance:g} is not reached with {MOST} surface triangles, the most there "
        f"may be; the estimated error is {best:.2g}"
    )


def _two_that_fit(surfaces: Iterator[Mesh]) -> list[Mesh]:
    """The two coarsest surfaces; refused before either is solved for where they are too fine."""
    two = list(islice(surfaces, 2))
    for number, mesh in enumerate(two, start=1):
        if len(mesh) > MOST:
            raise InputError(
                f"the body needs {len(mesh)} surface triangles for resolution {number} of at least 2; "
                f"there may be {MOST}: give a mesh with fewer triangles, a shorter wire or a thicker one"
            )
    return two


def extrapolated(coarse: Floats, fine: Floats, ratio: float) -> Floats:
    """What two resistances lead to as their triangles, ``ratio`` times larger in the first, shrink to nothing.

    Richardson's extrapolation of the logarithm of the one in terms of the other, so that the result is symmetric
    positive definite as they are.
    """
    from scipy.linalg import eigh

    share = 1.0 / (ratio**ORDER - 1.0)
    values, vectors = eigh(coarse, fine)  # vectors' fine vectors = 1
    inverse = fine @ vectors
    result: Floats = (inverse * values**-share) @ inverse.T
    return (result + result.T) / 2.0


def relative_difference(one: Floats, other: Floats) -> float:
    """Largest difference of an entry of two resistances (6, 6), relative to the entry of the first.

    Couplings smaller than 5 % of the geometric mean of their diagonal entries are compared with that instead.
    """
    size = np.sqrt(np.diag(one))
    return float(np.max(np.abs(one - other) / np.maximum(np.abs(one), SMALL * np.outer(size, size))))
