"""Kinematics of a six-axis arm with a spherical wrist: joints to flange, and back in closed form with all branches.

Joint angles are the arm's own, radians; frames are in the arm's base frame, flange z outwards.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import turn
from helimag.robot.arm.cell import Arm
from helimag.robot.arm.frames import frames

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

BRANCHES = 8  # front or back, elbow up or down, wrist as it is or flipped: 4 * back + 2 * down + flipped
TURN = 2.0 * np.pi
STRETCHED = 1e-9  # of the reach: how far beyond it still counts as rounding
_FLANGE = turn(1, np.pi / 2.0)  # wrist axes at rest to flange axes


@dataclass(frozen=True)
class Solutions:
    """All ways to hold flange frames.

    ``joints`` is (..., 8, 6), each angle within half a turn of zero, not a number where a branch cannot reach.
    ``reachable`` is (..., 8). ``singular`` (..., 8, 3) holds the distance of each branch from the three singularities
    (rad): wrist centre over the first axis (seen from there by the upper arm's length), arm stretched or folded, axes
    4 and 6 in line.
    """

    joints: Floats
    reachable: Flags
    singular: Floats


def joint_frames(arm: Arm, joints: Floats) -> Floats:
    """Positions (..., 6, 3) in m of base, shoulder, elbow, knee (the forearm's corner), wrist and flange."""
    link = arm.link
    base, upper, fore = _turns(arm, joints)
    shoulder = np.array([0.0, 0.0, link.d1]) + link.a1 * base[..., :, 0]
    elbow = shoulder + link.a2 * upper[..., :, 0]
    knee = elbow + link.a3 * fore[..., :, 2]
    wrist = knee + link.d4 * fore[..., :, 0]
    flange = forward(arm, joints)[..., :3, 3]
    foot = np.zeros_like(wrist)
    return np.stack([foot, shoulder, elbow, knee, wrist, flange], axis=-2)


def forward(arm: Arm, joints: Floats) -> Floats:
    """Flange frames (..., 4, 4) of joint angles (..., 6)."""
    link = arm.link
    base, upper, fore = _turns(arm, joints)
    signed = joints * np.array(arm.joint_sign)
    hand = fore @ turn(0, signed[..., 3]) @ turn(1, signed[..., 4]) @ turn(0, signed[..., 5])
    position = (
        np.array([0.0, 0.0, link.d1])
        + link.a1 * base[..., :, 0]
        + link.a2 * upper[..., :, 0]
        + link.a3 * fore[..., :, 2]
        + link.d4 * fore[..., :, 0]
        + link.d6 * hand[..., :, 0]
    )
    return frames(position, hand @ _FLANGE)


def _turns(arm: Arm, joints: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotations of column, upper arm and forearm."""
    signed = joints * np.array(arm.joint_sign)
    base = turn(2, signed[..., 0])
    return base, base @ turn(1, signed[..., 1]), base @ turn(1, signed[..., 1] + signed[..., 2])


def inverse_kinematics(arm: Arm, flange: Floats) -> Solutions:
    """All joint angles that put the flange into frames (..., 4, 4).

    The wrist's centre sets the first axis and, as a planar arm, the next two; what is left of the turn is the wrist's.
    In a wrist singularity only the sum of axes 4 and 6 is set; the solution given has axis 4 at zero.
    """
    link = arm.link
    hand = flange[..., :3, :3] @ _FLANGE.T
    wrist = flange[..., :3, 3] - link.d6 * hand[..., :, 0]
    joints = np.full((*flange.shape[:-2], BRANCHES, 6), np.nan)
    singular = np.full((*flange.shape[:-2], BRANCHES, 3), np.nan)
    reach = np.hypot(link.d4, link.a3)
    lift = np.arctan2(link.a3, link.d4)
    across, height = np.hypot(wrist[..., 0], wrist[..., 1]), wrist[..., 2] - link.d1
    for back in (0, 1):
        first = np.arctan2(wrist[..., 1], wrist[..., 0]) + back * np.pi
        out = (-across if back else across) - link.a1
        distance2 = out**2 + height**2
        cosine = (distance2 - link.a2**2 - reach**2) / (2.0 * link.a2 * reach)
        within = np.abs(cosine) <= 1.0 + STRETCHED
        bend = np.arccos(np.where(within, np.clip(cosine, -1.0, 1.0), np.nan))
        for down in (0, 1):
            inner = bend if down else -bend  # elevation of the line elbow-wrist above the upper arm's
            upper = np.arctan2(height, out) - np.arctan2(reach * np.sin(inner), link.a2 + reach * np.cos(inner))
            second, third = -upper, lift - inner
            fore = turn(2, first) @ turn(1, second + third)
            wrist_angles = _wrist_angles(np.swapaxes(fore, -1, -2) @ hand)
            for flipped, (fourth, fifth, sixth) in enumerate(wrist_angles):
                branch = 4 * back + 2 * down + flipped
                values = np.stack([first, second, third, fourth, fifth, sixth], axis=-1)
                joints[..., branch, :] = np.where(within[..., None], principal(values), np.nan)
                singular[..., branch, 0] = np.arctan2(across, link.a2)
                singular[..., branch, 1] = np.minimum(bend, np.pi - bend)
                singular[..., branch, 2] = np.arcsin(np.clip(np.abs(np.sin(fifth)), 0.0, 1.0))
    joints *= np.array(arm.joint_sign)
    return Solutions(joints, np.asarray(np.isfinite(joints).all(axis=-1)), singular)


def _wrist_angles(turned: Floats) -> tuple[tuple[Floats, Floats, Floats], tuple[Floats, Floats, Floats]]:
    """Both ways to write rotations (..., 3, 3) as Rx Ry Rx, the middle angle positive, then negative."""
    sine = np.hypot(turned[..., 0, 1], turned[..., 0, 2])
    in_line = sine < 1e-12
    fifth = np.arctan2(sine, turned[..., 0, 0])
    fourth = np.where(in_line, 0.0, np.arctan2(turned[..., 1, 0], -turned[..., 2, 0]))
    free = np.arctan2(-turned[..., 1, 2], turned[..., 1, 1])
    sixth = np.where(in_line, free, np.arctan2(turned[..., 0, 1], turned[..., 0, 2]))
    half = np.where(in_line, 0.0, np.pi)
    return (fourth, fifth, sixth), (fourth + half, -fifth, sixth + half)


def principal(angle: Floats) -> Floats:
    """The same angles within half a turn of zero."""
    return np.asarray(angle - TURN * np.round(angle / TURN))


def within_limits(arm: Arm, joints: Floats) -> Floats:
    """All joint angles (m, 6) within the limits that equal the branches (8, 6) of one pose up to whole turns."""
    found: list[Floats] = []
    low, high = arm.limits
    for solution in joints[np.isfinite(joints).all(axis=-1)]:
        choices = []
        for i in range(6):
            turns = np.arange(
                np.ceil((low[i] - solution[i]) / TURN - 1e-12), np.floor((high[i] - solution[i]) / TURN + 1e-12) + 1
            )
            choices.append(solution[i] + TURN * turns)
        found.extend(np.stack(np.meshgrid(*choices, indexing="ij"), axis=-1).reshape(-1, 6))
    return np.array(found).reshape(-1, 6)
