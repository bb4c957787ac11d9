"""A rigorous upper bound on the drag of a body: the drag of a body that encloses it.

Of all flows that move with a rigid body's surface, the Stokes flow dissipates least. The flow around an enclosing body,
filled up with the body's own rigid motion, is one of them; so in every rigid motion the enclosed body dissipates less:
R. Hill and G. Power, Q. J. Mech. Appl. Math. 9 (1956) 313. A resistance that exceeds the bound cannot be right.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.heads import spheroid
from helimag.scenario import CylinderHead, Device, Fluid

Floats = NDArray[np.float64]

CORNERS = 64  # of the polygon around a round profile; its corners lie 0.03 % outside
STRETCHES = 1.0 + np.geomspace(1e-3, 3.0, 200)  # half lengths tried, in half lengths of the device


def enclosing_resistance(device: Device, fluid: Fluid) -> Floats:
    """6x6 resistance of a spheroid that holds the whole device (SI), translation first, about the device's origin.

    The true resistance R of the device in open water is less in every motion: ``bound - R`` is positive definite. Of
    spheroids about the device's axis the one with the least total drag is taken.

    Parameters
    ----------
    device, fluid
        Of the scenario.

    Returns
    -------
    (6, 6)
        Symmetric positive definite.
    """
    center, axial, radial = enclosing_spheroid(device)
    return moved(spheroid(axial, radial, fluid.viscosity), np.array([center, 0.0, 0.0]))


def drag_ratio(matrix: Floats, bound: Floats) -> float:
    """Dissipation of a resistance (6, 6) over that of a bound about the same point, in the motion where it is most."""
    root = np.linalg.inv(np.linalg.cholesky(bound))
    return float(np.linalg.eigvalsh(root @ matrix @ root.T)[-1])


def most_drag_ratio(error: float | None) -> float:
    """What `drag_ratio` may be: one, and more only by the relative error of the resistance, where one is known."""
    return 1.0 if error is None else 1.0 + error


def violates(matrix: Floats, bound: Floats, error: float | None = None) -> bool:
    """Whether a resistance (6, 6) exceeds a bound about the same point in any motion, by more than its own error."""
    return drag_ratio(matrix, bound) > most_drag_ratio(error)


def moved(matrix: Floats, place: Floats) -> Floats:
    """Resistance (6, 6) about the origin of a body whose resistance about ``place`` (3,), seen from there, is known."""
    x, y, z = place
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    shift = np.block([[np.eye(3), -cross], [np.zeros((3, 3)), np.eye(3)]])
    about: Floats = shift.T @ matrix @ shift
    return about


@lru_cache(maxsize=64)  # sweeps change drives more often than devices
def enclosing_spheroid(device: Device) -> tuple[float, float, float]:
    """Centre along x, semi-axis along x and semi-axis across (m) of a spheroid that holds helix and head."""
    x, r = _profile(device)
    center, half = (x.min() + x.max()) / 2.0, (x.max() - x.min()) / 2.0
    axial = half * STRETCHES
    radial = np.max(r / np.sqrt(1.0 - ((x - center) / axial[:, None]) ** 2), axis=1)
    drags = [np.trace(spheroid(a, b, 1.0)[:3, :3]) for a, b in zip(axial, radial, strict=True)]
    best = int(np.argmin(drags))
    return float(center), float(axial[best]), float(radial[best])


def _profile(device: Device) -> tuple[Floats, Floats]:
    """Places along x and radii (m) of corners; turned about the axis, their convex hull holds the device."""
    if device.body is not None:
        corners = device.body.corners.reshape(-1, 3)
        return corners[:, 0], np.hypot(corners[:, 1], corners[:, 2])
    parts = [np.empty((2, 0))]
    if device.helix is not None:
        start, wire = -device.helix_start, device.helix.wire_radius
        ends = [start - device.helix.length - wire, start + wire]  # of the wire, which has a radius there
        parts.append(np.array([ends, [device.helix.outer_diameter / 2.0] * 2]))
    if isinstance(device.head, CylinderHead):
        parts.append(np.array([[-device.head.reach, device.head.reach], [device.head.radius] * 2]))
    elif device.head is not None:
        angle = math.pi / CORNERS * (2.0 * np.arange(CORNERS // 2) + 1.0)
        outside = 1.0 / math.cos(math.pi / CORNERS)
        parts.append(np.array([device.head.reach * np.cos(angle), device.head.radius * np.sin(angle)]) * outside)
    x, r = np.concatenate(parts, axis=1)
    return x, r
