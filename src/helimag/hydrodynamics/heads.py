"""Resistance of the head: ball, ellipsoid of revolution, cylinder (the matrices A and D of the paper's eq. 7)."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.scenario import CylinderHead, SphereHead, SpheroidHead


def head_resistance(head: SphereHead | SpheroidHead | CylinderHead, viscosity: float) -> NDArray[np.float64]:
    """6x6 resistance about the head's centre (SI), translation first, the axis along x."""
    match head:
        case SphereHead():
            return ball(head.radius, viscosity)
        case SpheroidHead():
            return spheroid(head.length / 2.0, head.diameter / 2.0, viscosity)
        case CylinderHead():
            # Same proportions and volume. Against a computation over the cylinder's surface, for lengths of one half to
            # two diameters: drag and spin about the axis within 6 %, but turning end over end 7 to 20 % too small.
            grow = (3.0 / 2.0) ** (1.0 / 3.0)
            return spheroid(grow * head.length / 2.0, grow * head.diameter / 2.0, viscosity)


def ball(radius: float, viscosity: float) -> NDArray[np.float64]:
    """6 pi mu r for translation and 8 pi mu r^3 for rotation (Stokes)."""
    drag = 6.0 * math.pi * viscosity * radius
    spin = 8.0 * math.pi * viscosity * radius**3
    return np.diag([drag, drag, drag, spin, spin, spin])


def spheroid(axial: float, radial: float, viscosity: float) -> NDArray[np.float64]:
    """Ellipsoid of revolution with semi-axes ``axial`` along x and ``radial`` across (m).

    S. Kim and S. J. Karrila, Microhydrodynamics, 1991, table 3.4 (prolate) and 3.6 (oblate); a ball in the limit.
    """
    size = max(axial, radial)
    e = math.sqrt(max(0.0, 1.0 - (min(axial, radial) / size) ** 2))
    if e < 0.02:  # the closed forms cancel; first order in the deformation is exact to 1e-7 here
        stretch = axial / radial - 1.0
        return ball(radial, viscosity) * (1.0 + stretch * np.diag([0.2, 0.4, 0.4, 0.6, 1.2, 1.2]))
    factors = _prolate(e) if axial > radial else _oblate(e)
    drag = 6.0 * math.pi * viscosity * size
    spin = 8.0 * math.pi * viscosity * size**3
    x_a, y_a, x_c, y_c = factors
    return np.diag([drag * x_a, drag * y_a, drag * y_a, spin * x_c, spin * y_c, spin * y_c])


def _prolate(e: float) -> tuple[float, float, float, float]:
    log = math.log((1.0 + e) / (1.0 - e))
    square = e * e
    return (
        8.0 / 3.0 * e**3 / (-2.0 * e + (1.0 + square) * log),
        16.0 / 3.0 * e**3 / (2.0 * e + (3.0 * square - 1.0) * log),
        4.0 / 3.0 * e**3 * (1.0 - square) / (2.0 * e - (1.0 - square) * log),
        4.0 / 3.0 * e**3 * (2.0 - square) / (-2.0 * e + (1.0 + square) * log),
    )


def _oblate(e: float) -> tuple[float, float, float, float]:
    square = e * e
    root = math.sqrt(1.0 - square)
    angle = math.atan2(e, root)  # arccot(root / e)
    return (
        4.0 / 3.0 * e**3 / ((2.0 * square - 1.0) * angle + e * root),
        8.0 / 3.0 * e**3 / ((2.0 * square + 1.0) * angle - e * root),
        2.0 / 3.0 * e**3 / (angle - e * root),
        2.0 / 3.0 * e**3 * (2.0 - square) / (e * root - (1.0 - 2.0 * square) * angle),
    )
