"""Distance of arm, motor and magnet, as capsules, from boxes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.cell import Cell, Obstacle
from helimag.robot.arm.frames import inverse
from helimag.robot.arm.kinematics import forward, joint_frames

Floats = NDArray[np.float64]

_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
_CUTS = 40  # of the golden section: 4e-9 of a link's length


@dataclass(frozen=True)
class Capsules:
    """Named parts of the arm as capsules in the lab frame: ends (n, k, 3) in m, radii (k,)."""

    names: tuple[str, ...]
    begin: Floats
    end: Floats
    radius: Floats


def capsules(cell: Cell, joints: Floats, magnet_reach: float) -> Capsules:
    """Arm, motor and magnet at joint angles (n, 6); the magnet is a ball of radius ``magnet_reach`` (m)."""
    points = joint_frames(cell.arm, joints)
    foot, shoulder, elbow, knee, wrist, flange = np.moveaxis(points, -2, 0)
    tool = tool_frames_in_base(cell, joints)
    magnet, axis = tool[..., :3, 3], tool[..., :3, 0]
    near = magnet - magnet_reach * axis
    far = near - cell.tool.motor_length * axis
    radius = cell.arm.radius
    parts = [
        ("column", foot, shoulder, radius.column),
        ("upper arm", shoulder, elbow, radius.upper_arm),
        ("forearm", knee, wrist, radius.forearm),
        ("wrist", wrist, flange, radius.wrist),
        ("bracket", flange, (near + far) / 2.0, cell.tool.motor_radius),
        ("motor", near, far, cell.tool.motor_radius),
        ("magnet", magnet, magnet, magnet_reach),
    ]
    to_lab = inverse(cell.lab_in_base)
    names, begin, end, radii = zip(*parts, strict=True)
    ends = [np.stack(side, axis=-2) @ to_lab[:3, :3].T + to_lab[:3, 3] for side in (begin, end)]
    return Capsules(names, ends[0], ends[1], np.array(radii))


def tool_frames_in_base(cell: Cell, joints: Floats) -> Floats:
    """Tool frames (..., 4, 4) in the arm's base frame at joint angles (..., 6)."""
    return forward(cell.arm, joints) @ cell.tool_in_flange


def clearances(parts: Capsules, obstacle: Obstacle) -> Floats:
    """Distance (n, k) in m of each part's surface from a box; negative where they overlap."""
    return segment_box_distance(parts.begin, parts.end, np.array(obstacle.low), np.array(obstacle.high)) - parts.radius


def segment_box_distance(begin: Floats, end: Floats, low: Floats, high: Floats) -> Floats:
    """Distance (...,) of segments, ends (..., 3), from the box between two corners; zero where they meet.

    The distance from a convex body is convex along a line, so a golden section finds its minimum.
    """

    def distance(share: Floats) -> Floats:
        point = begin + share[..., None] * (end - begin)
        return np.asarray(np.linalg.norm(point - np.clip(point, low, high), axis=-1))

    left, right = np.zeros(begin.shape[:-1]), np.ones(begin.shape[:-1])
    for _ in range(_CUTS):
        first, second = right - _GOLDEN * (right - left), left + _GOLDEN * (right - left)
        nearer = distance(first) <= distance(second)
        left, right = np.where(nearer, left, first), np.where(nearer, second, right)
    ends = np.minimum(distance(np.zeros_like(left)), distance(np.ones_like(left)))
    return np.minimum(ends, distance((left + right) / 2.0))
