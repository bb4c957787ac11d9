"""The model's equations once more, as one function of numbers, arrays or symbols, for the codes beside helimag.

A dipole turned by an arm, a device with a mobility and a net weight: the pitch, yaw and spin of eqs (1) to (3), the
dipole's field and force, and the quasi-static balance, as docs/model.md has them. Plain arithmetic, so that numba, JAX
and heyoka make their own code of it. Lengths are in units of the helix' length: a scalar tolerance then means the same
for places and attitudes, as in helimag's own error control.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from helimag.geometry import magnet_start
from helimag.hydrodynamics import mobility, net_weight, resistance
from helimag.scenario import Scenario

Rates = Callable[..., tuple[Any, ...]]


def unit_of(scenario: Scenario) -> float:
    """What the equations call one length (m)."""
    return float(scenario.device.helix.length)


def rates_of(scenario: Scenario, *, sin: Any = math.sin, cos: Any = math.cos, sqrt: Any = math.sqrt) -> Rates:
    """Make ``rates(t, x, y, z, w, a, b, c)``: rates of the place (helix lengths / s) and of the quaternion (1 / s)."""
    drive, device = scenario.drive, scenario.device
    unit = unit_of(scenario)
    weight, weight_moment = net_weight(device, scenario.fluid)
    moment = float(device.magnetic_moment)
    sin_p, cos_p = math.sin(drive.pitch), math.cos(drive.pitch)
    yaw_rate, spin_rate = float(drive.yaw_rate), 2.0 * math.pi * float(drive.frequency)
    arm_x, arm_y, arm_z = (float(value) / unit for value in magnet_start(drive))
    strength = 1e-7 * scenario.magnet[0].moment * moment / unit**3  # mu0 m M / (4 pi), N m
    pull = 3.0 * strength / unit
    m = np.asarray(mobility(resistance(device, scenario.fluid)))
    per_force, per_torque = m[:, :3], m[:, 3:]
    u = tuple(tuple(row) for row in (np.hstack([per_force[:3], per_torque[:3]]) / unit).tolist())
    o = tuple(tuple(row) for row in np.hstack([per_force[3:], per_torque[3:]]).tolist())

    def rates(t: Any, x: Any, y: Any, z: Any, w: Any, a: Any, b: Any, c: Any) -> tuple[Any, ...]:
        # where the magnet is, and its moment's direction
        cos_y, sin_y = cos(yaw_rate * t), sin(yaw_rate * t)
        along, across = cos(spin_rate * t), sin(spin_rate * t)
        rx = x - (cos_y * arm_x - sin_y * arm_y)
        ry = y - (sin_y * arm_x + cos_y * arm_y)
        rz = z - arm_z
        ax = -cos_y * sin_p * across - sin_y * along
        ay = -sin_y * sin_p * across + cos_y * along
        az = cos_p * across
        # body axes in the lab: 1 along the helix, 2 along the device's moment
        x1, x2, x3 = 1.0 - 2.0 * (b * b + c * c), 2.0 * (a * b - w * c), 2.0 * (a * c + w * b)
        y1, y2, y3 = 2.0 * (a * b + w * c), 1.0 - 2.0 * (a * a + c * c), 2.0 * (b * c - w * a)
        z1, z2, z3 = 2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)
        # the dipole's field (times the device's moment) and force
        square = rx * rx + ry * ry + rz * rz
        inverse = 1.0 / sqrt(square)
        nx, ny, nz = rx * inverse, ry * inverse, rz * inverse
        n_axis = nx * ax + ny * ay + nz * az
        n_moment = nx * x2 + ny * y2 + nz * z2
        between = x2 * ax + y2 * ay + z2 * az
        field = strength * inverse / square
        bx, by, bz = (
            field * (3.0 * n_axis * nx - ax),
            field * (3.0 * n_axis * ny - ay),
            field * (3.0 * n_axis * nz - az),
        )
        force = pull / (square * square)
        rest = between - 5.0 * n_moment * n_axis
        fx = force * (n_moment * ax + n_axis * x2 + rest * nx)
        fy = force * (n_moment * ay + n_axis * y2 + rest * ny)
        fz = force * (n_moment * az + n_axis * z2 + rest * nz) - weight
        # load in the body's axes
        f1, f2, f3 = x1 * fx + y1 * fy + z1 * fz, x2 * fx + y2 * fy + z2 * fz, x3 * fx + y3 * fy + z3 * fz
        t1 = x3 * bx + y3 * by + z3 * bz
        t2 = weight_moment * z3
        t3 = -(x1 * bx + y1 * by + z1 * bz) - weight_moment * z2
        # motion in the body's axes
        v1 = u[0][0] * f1 + u[0][1] * f2 + u[0][2] * f3 + u[0][3] * t1 + u[0][4] * t2 + u[0][5] * t3
        v2 = u[1][0] * f1 + u[1][1] * f2 + u[1][2] * f3 + u[1][3] * t1 + u[1][4] * t2 + u[1][5] * t3
        v3 = u[2][0] * f1 + u[2][1] * f2 + u[2][2] * f3 + u[2][3] * t1 + u[2][4] * t2 + u[2][5] * t3
        p = 0.5 * (o[0][0] * f1 + o[0][1] * f2 + o[0][2] * f3 + o[0][3] * t1 + o[0][4] * t2 + o[0][5] * t3)
        q = 0.5 * (o[1][0] * f1 + o[1][1] * f2 + o[1][2] * f3 + o[1][3] * t1 + o[1][4] * t2 + o[1][5] * t3)
        r = 0.5 * (o[2][0] * f1 + o[2][1] * f2 + o[2][2] * f3 + o[2][3] * t1 + o[2][4] * t2 + o[2][5] * t3)
        return (
            x1 * v1 + x2 * v2 + x3 * v3,
            y1 * v1 + y2 * v2 + y3 * v3,
            z1 * v1 + z2 * v2 + z3 * v3,
            -a * p - b * q - c * r,
            w * p + b * r - c * q,
            w * q + c * p - a * r,
            w * r + a * q - b * p,
        )

    return rates
