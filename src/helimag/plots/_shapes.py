"""Shapes of magnet and device as points, in their own frames (m)."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import CHIRALITY
from helimag.geometry import helix_line as centreline
from helimag.scenario import CylinderHead, Device, Magnet

Floats = NDArray[np.float64]

AROUND = 24  # facets of a cylinder


def cylinder_faces(magnet: Magnet) -> tuple[list[Floats], list[bool]]:
    """A magnet as polygons (k, 3) about the origin, its moment along z, and which belong to its upper, north half."""
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    rim = magnet.radius * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    lift = np.array([0.0, 0.0, magnet.height / 2.0])
    faces: list[Floats] = []
    north: list[bool] = []
    for upper in (False, True):
        foot, head = (rim, rim + lift) if upper else (rim - lift, rim)
        faces += [np.stack([foot[i], foot[i + 1], head[i + 1], head[i]]) for i in range(AROUND)]
        faces.append((rim + lift if upper else rim - lift)[:-1])
        north += [upper] * (AROUND + 1)
    return faces, north


def helix_line(device: Device) -> Floats:
    """Centreline of the helix in the body frame (n, 3), of none (0, 3); conventions as in the model."""
    helix = device.helix
    if helix is None:
        return np.empty((0, 3))
    along = np.linspace(0.0, helix.length, int(16 * helix.length / helix.pitch) + 2)
    return centreline(
        along,
        radius=helix.radius,
        pitch=helix.pitch,
        chirality=CHIRALITY[helix.handedness],
        behind=device.helix_start,
    )


def axis_rotation(direction: Floats) -> Floats:
    """A rotation (3, 3) that takes z to a unit vector (3,)."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across = np.cross(helper, direction)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(direction, across), direction], axis=1)


def head_faces(device: Device) -> list[Floats]:
    """Surface of head or body in the body frame: of a head polygons (4, 3) of a surface of revolution about x."""
    head = device.head
    if head is None:
        return [] if device.body is None else list(device.body.corners)
    if isinstance(head, CylinderHead):
        profile = head.reach * np.array([-1.0, -1.0, 1.0, 1.0]), head.radius * np.array([0.0, 1.0, 1.0, 0.0])
    else:
        polar = np.linspace(0.0, np.pi, 9)
        profile = -head.reach * np.cos(polar), head.radius * np.sin(polar)
    angle = np.linspace(0.0, 2.0 * np.pi, 13)
    rings = [
        np.stack([np.full(13, x), r * np.cos(angle), r * np.sin(angle)], axis=1) for x, r in zip(*profile, strict=True)
    ]
    return [
        np.stack([rear[i], rear[i + 1], front[i + 1], front[i]])
        for rear, front in pairwise(rings)
        for i in range(angle.size - 1)
    ]


def arrow_line(tail: Floats, vector: Floats, view: Floats) -> Floats:
    """An arrow as one line with two barbs (5, 3) that lie across the direction of view (3,)."""
    tip = tail + vector
    across = np.cross(vector, view)
    length = np.linalg.norm(across)
    if length > 0.0:
        across *= 0.09 * np.linalg.norm(vector) / length
    neck = tail + 0.8 * vector
    return np.stack([tail, tip, neck + across, tip, neck - across])
