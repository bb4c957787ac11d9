"""The surface of a whole device, finer and finer."""

import math
from collections.abc import Iterator

import numpy as np

from helimag.hydrodynamics.boundary.closed import checked
from helimag.hydrodynamics.boundary.mesh import Mesh, bisected, halved, joined, quartered
from helimag.hydrodynamics.boundary.solve import MOST
from helimag.hydrodynamics.boundary.surfaces import head_surface, rod_surface, wire_surface
from helimag.scenario import CylinderHead, Device

FINENESS = (5, 7, 10, 14, 20)  # facets around the wire, each step halving the triangles' area
ROD = 11.47  # lengths per diameter of a cylinder alone, from where facets as long as wide are too many to solve for
FEWEST = 150  # triangles of a given body, about


def device_surfaces(device: Device) -> Iterator[Mesh]:
    """Surfaces of the device in the body frame, each finer than the one before.

    Raises
    ------
    InputError
        Where a given body is no closed surface.
    """
    if device.body is not None:
        yield from _finer(checked(device.body.corners, device.body.file))
        return
    for fineness in FINENESS:
        yield joined(_parts(device, fineness))


def _parts(device: Device, fineness: int) -> list[Mesh]:
    """Surfaces of wire and head, with ``fineness`` facets around the wire, and as long ones on the head.

    The wire begins where the head ends, so they meet or overlap by less than the wire's radius, and move as one. Both
    keep their whole surfaces: forces inside the body do no harm.
    """
    parts, divisions = [], round(0.6 * fineness)
    if device.helix is not None:
        parts.append(wire_surface(device.helix, device.helix_start, fineness))
        share = 0.0 if device.head is None else device.head.radius / (5.0 * device.helix.wire_radius)
        divisions = min(max(2, math.ceil(fineness * share)), fineness)
    if device.helix is None and isinstance(device.head, CylinderHead) and device.head.reach > ROD * device.head.radius:
        parts.append(rod_surface(device.head, fineness))
    elif device.head is not None:
        parts.append(head_surface(device.head, divisions))
    return parts


def _finer(mesh: Mesh) -> Iterator[Mesh]:
    """A given surface without long edges, then with every triangle cut in four, in two where four are too many.

    Long thin facets, of which CAD programs make a cylinder, stay as long as it takes for a finer surface to fit.
    """
    area = float(np.linalg.norm(mesh.area_vectors, axis=1).sum())
    longest = 2.5 * math.sqrt(area / FEWEST)
    fine = bisected(mesh, longest)
    while len(fine) > max(MOST // 4, len(mesh)):
        longest *= math.sqrt(2.0)
        fine = bisected(mesh, longest)
    while True:
        yield fine
        fine = quartered(fine) if 4 * len(fine) <= MOST else halved(fine)
