"""The device's 6x6 resistance enclosed: resistive-force theory and the head, once more in balls.

Formulas and sources are those of ``hydrodynamics``; the integrals along the wire are done by Arb's own rigorous
quadrature (F. Johansson, Numerical integration in arbitrary-precision ball arithmetic, ICMS 2018).
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from helimag.proof.balls import exact, flint
from helimag.scenario import CylinderHead, SphereHead, SpheroidHead

if TYPE_CHECKING:
    from flint import arb, arb_mat

Head = SphereHead | SpheroidHead | CylinderHead
Read = Callable[[str], "arb"]  # the exact value of an input, by its path

CHIRALITY = {"left": 1, "right": -1}
ALMOST_ROUND = 0.02  # eccentricity below which the drag of a spheroid is taken to first order, as in ``hydrodynamics``


def wire_resistance(read: Read, model: str, handedness: str, start: "arb") -> "arb_mat":
    """6x6 resistance of the helix about the body's origin: the integral of M ds in eq. (7)."""
    library = flint()
    length, pitch, wire = (read(f"device.helix.{name}") for name in ("length", "pitch", "wire_radius"))
    radius = read("device.helix.outer_diameter") / 2 - wire
    k = 2 * library.arb.pi() / pitch
    stretch = (1 + (k * radius) ** 2).sqrt()
    along, across = _coefficients(model, pitch, wire, stretch, read("fluid.viscosity"))
    chi = CHIRALITY[handedness]

    def integrand(i: int, j: int) -> Callable[[Any, Any], Any]:
        def at(u: Any, _: Any) -> Any:
            cosine, sine = (k * u).cos(), (k * u).sin()
            point = [-start - u, radius * cosine, chi * radius * sine]
            tangent = [-1 / stretch, -k * radius * sine / stretch, chi * k * radius * cosine / stretch]
            left, right = _motion(point, i), _motion(point, j)
            direct = sum(a * b for a, b in zip(left, right, strict=True))
            slid = sum(a * b for a, b in zip(left, tangent, strict=True))
            return across * direct + (along - across) * slid * sum(a * b for a, b in zip(right, tangent, strict=True))

        return at

    matrix = library.arb_mat(6, 6)
    for i in range(6):
        for j in range(i, 6):
            value = library.acb.integral(integrand(i, j), library.acb(0), library.acb(length)).real * stretch
            matrix[i, j] = matrix[j, i] = value
    return matrix


def _motion(point: Sequence[Any], i: int) -> list[Any]:
    """Velocity at a point of a body that moves along (0 to 2) or turns about (3 to 5) an axis at unit rate."""
    x, y, z = point
    zero, one = 0 * x, 1 + 0 * x
    columns = [
        [one, zero, zero], [zero, one, zero], [zero, zero, one], [zero, -z, y], [z, zero, -x], [-y, x, zero],
    ]  # fmt: skip
    return columns[i]


def _coefficients(model: str, pitch: "arb", wire: "arb", stretch: "arb", viscosity: "arb") -> tuple["arb", "arb"]:
    """Drag per length along and across the wire: Lighthill's, or Gray and Hancock's."""
    library = flint()
    turn, half = 2 * library.arb.pi() * viscosity, exact(0.5)
    if model == "lighthill":
        slender = (exact(18) / 100 * pitch * stretch / wire).log()
        return turn / slender, 2 * turn / (slender + half)
    slender = (2 * pitch / wire).log()
    return turn / (slender - half), 2 * turn / (slender + half)


def head_resistance(head: Head, read: Read) -> "list[arb]":
    """Diagonal of the head's 6x6 resistance about its centre."""
    viscosity = read("fluid.viscosity")
    if isinstance(head, SphereHead):
        return _ball(read("device.head.radius"), viscosity)
    axial, radial = read("device.head.length") / 2, read("device.head.diameter") / 2
    if isinstance(head, CylinderHead):
        grow = (exact(3) / 2).root(3)
        axial, radial = grow * axial, grow * radial
    return _spheroid(head, axial, radial, viscosity)


def _ball(radius: "arb", viscosity: "arb") -> "list[arb]":
    unit = flint().arb.pi() * viscosity * radius
    return [6 * unit] * 3 + [8 * unit * radius * radius] * 3


def _spheroid(head: SpheroidHead | CylinderHead, axial: "arb", radial: "arb", viscosity: "arb") -> "list[arb]":
    """Kim and Karrila, Microhydrodynamics, tables 3.4 and 3.6; a ball stretched to first order where almost round."""
    long = head.length > head.diameter
    size, least = (axial, radial) if long else (radial, axial)
    if 1.0 - (min(head.length, head.diameter) / max(head.length, head.diameter)) ** 2 < ALMOST_ROUND**2:
        stretch = axial / radial - 1
        factors = [exact(f) / 10 for f in (2, 4, 4, 6, 12, 12)]
        return [d * (1 + stretch * f) for d, f in zip(_ball(radial, viscosity), factors, strict=True)]
    square = 1 - (least / size) ** 2
    e = square.sqrt()
    cube = e * square
    if long:
        log = ((1 + e) / (1 - e)).log()
        x_a = exact(8) / 3 * cube / (-2 * e + (1 + square) * log)
        y_a = exact(16) / 3 * cube / (2 * e + (3 * square - 1) * log)
        x_c = exact(4) / 3 * cube * (1 - square) / (2 * e - (1 - square) * log)
        y_c = exact(4) / 3 * cube * (2 - square) / (-2 * e + (1 + square) * log)
    else:
        root = least / size
        angle = flint().arb.atan2(e, root)
        x_a = exact(4) / 3 * cube / ((2 * square - 1) * angle + e * root)
        y_a = exact(8) / 3 * cube / ((2 * square + 1) * angle - e * root)
        x_c = exact(2) / 3 * cube / (angle - e * root)
        y_c = exact(2) / 3 * cube * (2 - square) / (e * root - (1 - 2 * square) * angle)
    ball = _ball(size, viscosity)
    return [d * f for d, f in zip(ball, (x_a, y_a, y_a, x_c, y_c, y_c), strict=True)]
