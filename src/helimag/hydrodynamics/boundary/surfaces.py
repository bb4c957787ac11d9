"""Surfaces of the parts of a device, made of triangles at a stated fineness.

Fineness is the number of facets around the wire. A polyhedron with its corners on a round body is smaller than the
body; each surface here is scaled to the body's own volume instead, which takes most of the error of flat facets away.
"""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.scenario import CylinderHead, Helix, SphereHead, SpheroidHead

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

COARSEST = 5  # facets around the wire
MANY = 90  # facets along it, of the coarsest surface


def sphere(divisions: int) -> Mesh:
    """20 divisions^2 triangles with the volume of the unit ball: an icosahedron's faces, divided and blown up."""
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    signs = [(a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    vertices = np.array([v for a, b in signs for v in ((a, b, 0.0), (0.0, a, b), (b, 0.0, a))])
    far = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    touching = (far > 0.0) & (far < 2.1)
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if touching[i, j] and touching[j, k] and touching[i, k]
    ]
    pieces = np.concatenate([_divided(vertices[list(face)], divisions) for face in faces])
    pieces /= np.linalg.norm(pieces, axis=2, keepdims=True)
    outward = np.einsum("ni,ni->n", pieces[:, 0], np.cross(pieces[:, 1], pieces[:, 2])) > 0.0
    pieces[~outward] = pieces[~outward][:, ::-1]
    return _with_volume(Mesh(pieces, np.zeros(len(pieces), dtype=np.intp)), 4.0 / 3.0 * math.pi)


def _divided(triangle: Floats, divisions: int) -> Floats:
    """Similar triangles (divisions^2, 3, 3) that fill a triangle (3, 3)."""
    a, b, c = triangle
    right, up = (b - a) / divisions, (c - a) / divisions
    low = [(i, j) for i in range(divisions) for j in range(divisions - i)]
    pieces = [[a + i * right + j * up, a + (i + 1) * right + j * up, a + i * right + (j + 1) * up] for i, j in low]
    high = [(i, j) for i, j in low if i + j < divisions - 1]
    pieces += [
        [a + (i + 1) * right + j * up, a + (i + 1) * right + (j + 1) * up, a + i * right + (j + 1) * up]
        for i, j in high
    ]
    return np.array(pieces)


def _with_volume(mesh: Mesh, volume: float) -> Mesh:
    return Mesh(mesh.corners * (volume / mesh.volume) ** (1.0 / 3.0), mesh.part)


def head_surface(head: SphereHead | SpheroidHead | CylinderHead, divisions: int) -> Mesh:
    """Surface of the head about its centre, about 20 divisions^2 triangles for a ball."""
    if isinstance(head, CylinderHead):
        return _cylinder(head, divisions)
    ball = sphere(divisions)
    return Mesh(ball.corners * np.array([head.reach, head.radius, head.radius]), ball.part)


def _cylinder(head: CylinderHead, divisions: int) -> Mesh:
    """Mantle of rings of 6 divisions corners, end faces of hexagonal rings, all edges of about one length."""
    around = 6 * divisions
    rows = max(2, round(head.length / head.radius * divisions))
    rings = [
        np.column_stack([np.full(around, x), head.radius * _circle(around, offset=0.5 * (i % 2))])
        for i, x in enumerate(np.linspace(-head.reach, head.reach, rows + 1))
    ]
    faces = [_band(i, around) for i in range(rows)]
    mantle = np.concatenate(rings)[np.concatenate(faces)]
    ends = [
        _disc(end, head.radius, divisions, offset=0.5 * (i % 2))[:, ::sense]
        for i, end, sense in ((0, -head.reach, -1), (rows, head.reach, 1))
    ]
    corners = np.concatenate([mantle, *ends])
    mesh = Mesh(corners, np.zeros(len(corners), dtype=np.intp))
    across = math.sqrt(head.volume / mesh.volume)
    return Mesh(corners * np.array([1.0, across, across]), mesh.part)


def _circle(around: int, *, offset: float) -> Floats:
    angle = 2.0 * np.pi * (np.arange(around) + offset) / around
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _band(ring: int, around: int) -> Integers:
    """Triangles between ring number ``ring`` and the next, of which every second is turned by half a facet (n, 3).

    Counter-clockwise from outside where the rings follow each other along the axis about which their angle turns.
    """
    j = np.arange(around)
    low, low_next = ring * around + j, ring * around + (j + 1) % around
    high, high_next = low + around, low_next + around
    if ring % 2 == 0:
        two = (low, low_next, high), (low_next, high_next, high)
    else:
        two = (low, low_next, high_next), (low, high_next, high)
    return np.concatenate([np.stack(corners, axis=1) for corners in two])


def _disc(x: float, radius: float, divisions: int, *, offset: float) -> Floats:
    """Flat disc across x, counter-clockwise about +x: 6 divisions^2 triangles (n, 3, 3).

    Its rim is a polygon of 6 divisions corners, the first at ``offset`` of a facet.
    """
    turn = 2.0 * np.pi * offset / (6 * divisions)
    triangles = []
    for sector in range(6):
        for piece in _divided(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), divisions):
            ring = piece.sum(axis=1)
            angle = turn + np.pi / 3.0 * (sector + np.divide(piece[:, 1], ring, out=np.zeros(3), where=ring > 0.0))
            triangles.append(
                np.stack([np.full(3, x), radius * ring * np.cos(angle), radius * ring * np.sin(angle)], axis=1)
            )
    return np.array(triangles)


def wire_surface(helix: Helix, start: float, around: int) -> Mesh:
    """Surface of the coiled wire with flat ends, the first ``start`` (m) behind the origin.

    Parameters
    ----------
    around
        Facets around the wire. They are half as long again as wide; on a long wire up to 3.5 times, so that there are
        not too many of them.
    """
    contour = helix.length * helix.contour_per_length
    bend = 2.0 * math.pi * helix.length / helix.pitch
    steps = max(2, _facets_along(contour, helix.wire_radius, around), math.ceil(bend / 0.8 * around / COARSEST))
    volume = math.pi * helix.wire_radius**2 * contour
    thickness = helix.wire_radius
    for _ in range(3):  # facets of a bent wire lose or gain a little more than a polygon's area
        mesh = _tube(helix, start, around, steps, thickness)
        thickness *= math.sqrt(volume / mesh.volume)
    return _tube(helix, start, around, steps, thickness)


def _facets_along(length: float, radius: float, around: int) -> int:
    """How many facets a wire takes along its length, with ``around`` of them around it."""
    girths = length / (2.0 * math.pi * radius)
    aspect = min(max(1.5, girths * COARSEST / MANY), 3.5)
    return round(girths * around / aspect)


def rod_surface(head: CylinderHead, around: int) -> Mesh:
    """Surface of a long cylinder, made like that of a wire: ``around`` facets around it, longer than wide."""
    rows = _facets_along(head.length, head.radius, around)
    middles = np.linspace([-head.reach, 0.0, 0.0], [head.reach, 0.0, 0.0], rows + 1)
    rings = [
        middle + head.radius * np.column_stack([np.zeros(around), _circle(around, offset=0.5 * (i % 2))])
        for i, middle in enumerate(middles)
    ]
    mesh = _skin(rings, middles[0], middles[-1])
    across = math.sqrt(head.volume / mesh.volume)
    return Mesh(mesh.corners * np.array([1.0, across, across]), mesh.part)


def _tube(helix: Helix, start: float, around: int, steps: int, thickness: float) -> Mesh:
    """Rings of ``around`` corners across the wire and triangles between them, end faces included."""
    u = np.linspace(0.0, helix.length, steps + 1)
    wave = 2.0 * math.pi / helix.pitch
    chi = 1.0 if helix.handedness == "left" else -1.0
    bend = wave * helix.length / steps  # chords of a circle enclose less than the circle: their corners go outward
    radius = helix.radius * math.sqrt(bend / math.sin(bend)) if bend < 1.0 else helix.radius
    cos, sin = np.cos(wave * u), chi * np.sin(wave * u)
    middle = np.stack([-start - u, radius * cos, radius * sin], axis=1)
    slope = np.stack([-np.ones_like(u), -wave * chi * radius * sin, wave * chi * radius * cos], axis=1)
    tangent = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    inward = np.stack([np.zeros_like(u), -cos, -sin], axis=1)
    third = np.cross(tangent, inward)
    rings = []
    for i in range(steps + 1):
        circle = thickness * _circle(around, offset=0.5 * (i % 2))
        rings.append(middle[i] + circle[:, :1] * inward[i] + circle[:, 1:] * third[i])
    return _skin(rings, middle[0], middle[-1])


def _skin(rings: list[Floats], first: Floats, last: Floats) -> Mesh:
    """Triangles between rings of corners that follow each other along a wire, and faces at its ends."""
    around = len(rings[0])
    mantle = np.concatenate(rings)[np.concatenate([_band(i, around) for i in range(len(rings) - 1)])]
    ends = _end_face(rings[0], first)[:, ::-1], _end_face(rings[-1], last)
    corners = np.concatenate([mantle, *ends])
    return Mesh(corners, np.zeros(len(corners), dtype=np.intp))


def _end_face(ring: Floats, middle: Floats) -> Floats:
    """A flat face from the middle (3,) to a ring (k, 3) of corners, in rings of about square facets."""
    inner = max(1, len(ring) // 6)
    rings = [middle + share * (ring - middle) for share in np.linspace(1.0, 0.0, inner + 1)[:-1]]
    triangles = []
    for outer, within in pairwise(rings):
        beside, within_beside = np.roll(outer, -1, axis=0), np.roll(within, -1, axis=0)
        triangles += [np.stack([outer, beside, within], axis=1), np.stack([beside, within_beside, within], axis=1)]
    last = rings[-1]
    triangles.append(np.stack([last, np.roll(last, -1, axis=0), np.broadcast_to(middle, last.shape)], axis=1))
    return np.concatenate(triangles)
