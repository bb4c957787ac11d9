"""The equations of motion once more, for any arithmetic: of a device beside a curve, in the frame of the drive.

A turn of the magnet takes one unit of time and a centimetre one unit of length. The state is six deviations from a
closed curve: of the head's place, and of the attitude in body axes as four times the modified Rodrigues parameters,
which to first order are a rotation vector (H. Schaub and J. L. Junkins, Analytical Mechanics of Space Systems, sec.
3.5). In these coordinates the right-hand side has one root and one division and is polynomial otherwise. The formulas
are those of ``physics``, eqs (1) to (4), (7) to (9); tests hold the one against the other.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from helimag.proof.jets import Jet

Number = Any  # a jet, or a value that depends on no variable
Vector = Sequence[Number]

LENGTH = Fraction(1, 100)  # m, of a unit of length
TURN_PER_LENGTH = math.radians(0.1) / 1e-4  # rad/m: a ball of starts of 0.1 mm is one of 0.1 degrees


@dataclass(frozen=True)
class Source:
    """A magnet: where it is and how it points, in units of length, in the frame of the drive."""

    place: Vector  # of its centre
    strength: Number  # of the field: mu0 / (4 pi) times moment over a unit of length cubed (T)
    cos_phase: Number
    sin_phase: Number


@dataclass(frozen=True)
class Constants:
    """What does not change during a turn; times in turns, lengths in units of length, loads in N and N m."""

    sources: tuple[Source, ...]
    spin_sign: int  # of the frequency
    cos_pitch: Number
    sin_pitch: Number
    yaw: Number  # of the drive, rad in a turn
    drift: Vector  # of the drive, lengths in a turn
    moment: Number  # of the device, A m^2
    pull: Number  # 3 m / unit of length: what turns a field over the fourth power of a distance into a force
    weight: Number
    weight_moment: Number
    mobility: Sequence[Vector]  # (6, 6): loads to lengths and radians in a turn


def dot(a: Vector, b: Vector) -> Number:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> list[Number]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def product(a: Vector, b: Vector) -> list[Number]:
    """Quaternion that turns by ``b`` and then by ``a``, scalar first, of any lengths."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]


def rotation(q: Vector, inverse_square: Number) -> list[list[Number]]:
    """Matrix from body to frame of a quaternion of any length, whose squared length is one over ``inverse_square``."""
    w, x, y, z = q
    ww, xx, yy, zz = w * w, x * x, y * y, z * z
    wx, wy, wz, xy, xz, yz = w * x, w * y, w * z, x * y, x * z, y * z
    rows = [
        [ww + xx - yy - zz, 2 * (xy - wz), 2 * (xz + wy)],
        [2 * (xy + wz), ww - xx + yy - zz, 2 * (yz - wx)],
        [2 * (xz - wy), 2 * (yz + wx), ww - xx - yy + zz],
    ]
    return [[inverse_square * entry for entry in row] for row in rows]


def moment_axes(constants: Constants, cosine: Number, sine: Number) -> list[list[Number]]:
    """Directions of the magnets' moments, eqs (2) and (3), where the spin has this cosine and sine."""
    spin = constants.spin_sign * sine
    axes = []
    for source in constants.sources:
        across = source.cos_phase * cosine - source.sin_phase * spin
        up = source.cos_phase * spin + source.sin_phase * cosine
        axes.append([-constants.sin_pitch * up, across, constants.cos_pitch * up])
    return axes


def dipole_load(source: Source, pull: Number, place: Vector, frame: Sequence[Vector], axis: Vector) -> Any:
    """Field (T) and force (N) on the device, body axes: eq. (9) and the gradient of m . B."""
    away = [a - b for a, b in zip(place, source.place, strict=True)]
    inverse = dot(away, away).inverse_root()
    square = inverse * inverse
    unit = [component * inverse for component in away]
    along = dot(unit, axis)
    r = [dot([row[i] for row in frame], unit) for i in range(3)]
    m = [dot([row[i] for row in frame], axis) for i in range(3)]
    scale = (inverse * square).scaled(source.strength)
    field = [scale * (3 * (along * r[i]) - m[i]) for i in range(3)]
    steep = (scale * inverse).scaled(pull)
    direct = m[1] - 5 * (r[1] * along)
    force = [r[1] * m[i] + direct * r[i] for i in range(3)]
    force[1] = force[1] + along
    return field, [steep * component for component in force]


def velocities(constants: Constants, place: Vector, frame: Sequence[Vector], axes: Sequence[Vector]) -> Any:
    """Velocity (body axes, lengths in a turn) and angular velocity (rad in a turn) that balance all loads: eq. (4)."""
    field, force = dipole_load(constants.sources[0], constants.pull, place, frame, axes[0])
    for source, axis in zip(constants.sources[1:], axes[1:], strict=True):
        more = dipole_load(source, constants.pull, place, frame, axis)
        field = [a + b for a, b in zip(field, more[0], strict=True)]
        force = [a + b for a, b in zip(force, more[1], strict=True)]
    up = frame[2]
    load = [
        *(f - u * constants.weight for f, u in zip(force, up, strict=True)),
        field[2] * constants.moment,
        up[2] * constants.weight_moment,
        -(field[0] * constants.moment) - up[1] * constants.weight_moment,
    ]
    motion = [_weighted(row, load) for row in constants.mobility]
    return motion[:3], motion[3:]


def _weighted(row: Vector, load: Vector) -> Number:
    total = load[0] * row[0]
    for weight, part in zip(row[1:], load[1:], strict=True):
        total = total + part * weight
    return total


@dataclass(frozen=True)
class Swimming:
    """The rates of the six deviations from a curve of seven components: place (3) and quaternion (4) of any length."""

    constants: Constants
    components: int = 7
    plain: bool = True  # whether the constants are numbers, not jets in the inputs

    def rates(self, clock: tuple[Number, Number], curve: Vector, slope: Vector, deviation: Sequence[Jet]) -> list[Jet]:
        """Rates of the deviations, in a turn.

        Parameters
        ----------
        clock
            Cosine and sine of the angle of which the magnet has turned, taken positive.
        curve, slope
            The curve (7,) and its rate in a turn.
        deviation
            (6,): of the place in units of length, of the attitude as four times the modified Rodrigues parameters.
        """
        k = self.constants
        place, frame = self.pose(curve, deviation)
        velocity, spin = velocities(k, place, frame, moment_axes(k, *clock))
        moved = [dot(row, velocity) for row in frame]
        moved[0] = moved[0] + k.yaw * place[1]
        moved[1] = moved[1] - k.yaw * place[0]
        first = [m - d - s for m, d, s in zip(moved, k.drift, slope[:3], strict=True)]
        own = [w - k.yaw * u for w, u in zip(spin, frame[2], strict=True)]
        return [*first, *_attitude_rates(deviation[3:], own, _curve_spin(curve[3:], slope[3:]))]

    def still_rates(self, clock: tuple[Number, Number], curve: Any, slope: Any) -> list[Jet]:
        """The same on the curve itself, which may depend on other variables than the deviations."""
        return self.rates(clock, list(curve), list(slope), [Jet(0.0)] * 6)

    def plain_rates(self, turns: float, state: Sequence[float]) -> list[float]:
        """Rates (7,) of place and unit quaternion themselves, in floats."""
        k, q = self.constants, state[3:]
        frame = rotation([Jet(c) for c in q], Jet(1.0 / sum(c * c for c in q)))
        angle = 2.0 * math.pi * turns
        axes = moment_axes(k, math.cos(angle), math.sin(angle))
        velocity, spin = velocities(k, [Jet(c) for c in state[:3]], frame, axes)
        moved = [dot(row, velocity).v for row in frame]
        moved[0] += k.yaw * state[1]
        moved[1] -= k.yaw * state[0]
        own = [w.v - k.yaw * u.v for w, u in zip(spin, frame[2], strict=True)]
        return [*(m - d for m, d in zip(moved, k.drift, strict=True)), *(0.5 * c for c in product(q, [0.0, *own]))]

    def pose(self, curve: Vector, deviation: Sequence[Jet]) -> tuple[list[Jet], list[list[Jet]]]:
        """Place of the head and matrix from body to frame beside the curve."""
        place = [d + c for c, d in zip(curve[:3], deviation[:3], strict=True)]
        small = [d / 4 for d in deviation[3:]]
        square = dot(small, small)
        turned = product(curve[3:], [1 - square, *(2 * s for s in small)])
        length = (1 + square) * (1 + square)
        own = sum((c * c for c in curve[4:]), curve[3] * curve[3])
        return place, rotation(turned, (length * own).inverse())


def _curve_spin(q: Vector, slope: Vector) -> list[Number]:
    """Angular velocity (body axes) of a quaternion of any length that has this rate."""
    conjugate = [q[0], -q[1], -q[2], -q[3]]
    square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]
    inverse = 2 / square
    return [part * inverse for part in product(conjugate, slope)[1:]]


def _attitude_rates(theta: Sequence[Jet], own: Sequence[Jet], curve: Sequence[Number]) -> list[Jet]:
    """Rates of four times the Rodrigues parameters of a body beside another, from both angular velocities.

    Each turns in its own axes; Schaub and Junkins, eq. (3.158), once for the body and once, from the left, for the
    curve.
    """
    sigma = [t / 4 for t in theta]
    square = dot(sigma, sigma)
    apart = [a - b for a, b in zip(own, curve, strict=True)]
    both = [a + b for a, b in zip(own, curve, strict=True)]
    along = 2 * dot(sigma, apart)
    across = cross(sigma, both)
    return [(1 - square) * apart[i] + 2 * across[i] + along * sigma[i] for i in range(3)]
