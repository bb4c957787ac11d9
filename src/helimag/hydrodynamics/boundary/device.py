"""The surface of a whole device."""

import math
from collections.abc import Iterator

from helimag.hydrodynamics.boundary.mesh import Mesh, joined
from helimag.hydrodynamics.boundary.surfaces import head_surface, wire_surface
from helimag.scenario import Device

FINENESS = (5, 7, 10, 14, 20)  # facets around the wire, each step halving the triangles' area


def device_surfaces(device: Device) -> Iterator[Mesh]:
    """Surfaces of wire and head in the body frame, finer and finer.

    The wire begins where the head ends, so they meet or overlap by less than the wire's radius, and move as one. Both keep
    their whole surfaces: forces inside the body do no harm.
    """
    for fineness in FINENESS:
        yield device_surface(device, fineness)


def device_surface(device: Device, fineness: int) -> Mesh:
    """Triangles on wire and head, body frame; ``fineness`` facets around the wire, and as long ones on the head."""
    helix, head = device.helix, device.head
    divisions = math.ceil(fineness * head.radius / (5.0 * helix.wire_radius))
    wire = wire_surface(helix, head.reach, fineness)
    return joined([wire, head_surface(head, min(max(2, divisions), fineness))])
