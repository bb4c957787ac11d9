"""The surface of a whole device: wire and head, without what lies inside the other."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.mesh import Mesh, joined
from helimag.hydrodynamics.boundary.surfaces import head_surface, wire_surface
from helimag.scenario import CylinderHead, Device, Helix, SphereHead, SpheroidHead

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Head = SphereHead | SpheroidHead | CylinderHead


def device_surface(device: Device, fineness: int) -> Mesh:
    """Triangles on wire and head, body frame; ``fineness`` facets around the wire.

    Where wire and head run into each other, triangles that lie wholly inside the other part are left out. Those that
    cross over stay whole: forces inside the body do no harm, and these triangles shrink with the fineness.
    """
    helix, head = device.helix, device.head
    wire = wire_surface(helix, head.reach, fineness)
    ball = head_surface(head, min(max(2, math.ceil(fineness * head.radius / (5.0 * helix.wire_radius))), fineness))
    hidden_wire = _whole(_inside_head(wire.corners.reshape(-1, 3), head))
    hidden_head = _whole(_inside_wire(ball.corners.reshape(-1, 3), helix, head.reach))
    return joined([wire.without(hidden_wire), ball.without(hidden_head)])


def _whole(inside: Flags) -> Flags:
    """Triangles (n,) all whose corners are inside, from the flags of the corners in turn (3 n,)."""
    whole: Flags = inside.reshape(-1, 3).all(axis=1)
    return whole


def _inside_head(points: Floats, head: Head) -> Flags:
    """Whether points (n, 3) lie in the head."""
    along, across = points[:, 0] / head.reach, np.hypot(points[:, 1], points[:, 2]) / head.radius
    within: Flags = np.hypot(along, across) < 1.0
    if isinstance(head, CylinderHead):
        within = (np.abs(along) < 1.0) & (across < 1.0)
    return within


def _inside_wire(points: Floats, helix: Helix, start: float) -> Flags:
    """Whether points (n, 3) lie in the coiled wire, by the nearest of closely set places on its centreline."""
    from scipy.spatial import cKDTree

    count = 2 + math.ceil(20.0 * helix.length * helix.contour_per_length / helix.wire_radius)
    u = np.linspace(0.0, helix.length, count)
    wave = 2.0 * math.pi / helix.pitch
    chi = 1.0 if helix.handedness == "left" else -1.0
    line = np.stack([-start - u, helix.radius * np.cos(wave * u), chi * helix.radius * np.sin(wave * u)], axis=1)
    gap, nearest = cKDTree(line).query(points)
    within = (nearest > 0) & (nearest < count - 1)  # not beyond an end
    inside: Flags = (gap < helix.wire_radius) & within
    return inside
