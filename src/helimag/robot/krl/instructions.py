"""A plan as the instructions of a robot programme, before any language: where to, how fast, rounded or not."""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.frames import angles
from helimag.robot.arm.path import Motion, MotionKind, tool_frames
from helimag.robot.arm.planning import ArmPlan

Floats = NDArray[np.float64]


class Order(StrEnum):
    """What an instruction does."""

    JOINTS = "joints"  # to joint angles, each axis on its own
    LINE = "line"
    ARC = "arc"
    TURN = "turn"  # about the magnet's centre, which stays
    WAIT = "wait"


@dataclass(frozen=True)
class Instruction:
    """One instruction. ``begin`` and ``end`` are programme times (s).

    ``target`` is joint angles (6,) in rad, or a tool pose (6,): position in m and angles A, B, C in rad, in the lab
    frame; ``via`` the same for the middle of an arc. ``speed`` is in m/s, in rad/s for a turn, and a share of the
    joint speeds for joints. ``rounded`` allows the arm to pass the target without a stop.
    """

    order: Order
    begin: float
    end: float
    target: Floats
    via: Floats | None = None
    speed: float = 0.0
    rounded: bool = False


_ORDERS = {
    MotionKind.LINE: Order.LINE,
    MotionKind.ARC: Order.ARC,
    MotionKind.TURN: Order.TURN,
    MotionKind.HOLD: Order.WAIT,
}


def instructions(plan: ArmPlan) -> list[Instruction]:
    """The instructions of a plan, after the arm has gone to its first joint angles."""
    result = []
    unwindings = {round(unwinding.time, 9): unwinding for unwinding in plan.unwindings}
    delay = 0.0
    for i, motion in enumerate(plan.motions):
        unwinding = unwindings.get(round(motion.end, 9))
        last = i == len(plan.motions) - 1
        result.append(_instruction(plan, motion, delay, rounded=not last and unwinding is None))
        if unwinding is not None:
            at = int(np.searchsorted(plan.times, unwinding.time - 1e-9))
            begin = motion.end + delay
            delay += unwinding.duration
            result.append(
                Instruction(
                    Order.JOINTS,
                    begin,
                    begin + unwinding.duration,
                    plan.joints[at],
                    None,
                    plan.cell.joint_percent / 100.0,
                )
            )
    return result


def _instruction(plan: ArmPlan, motion: Motion, delay: float, *, rounded: bool) -> Instruction:
    """One motion of the path. The speed is constant in it, so that its duration is the path's own."""
    times = np.array([motion.begin, (motion.begin + motion.end) / 2.0, motion.end])
    start, via, target = tool_poses(plan, times)
    duration = motion.end - motion.begin
    order = _ORDERS[motion.kind]
    match order:
        case Order.LINE:
            speed = float(np.linalg.norm(target[:3] - start[:3])) / duration
        case Order.ARC:
            speed = arc_length(start[:3], via[:3], target[:3]) / duration
        case Order.TURN:
            speed = abs(plan.path.yaw_rate)
        case _:
            speed = 0.0
    middle = via if order is Order.ARC else None
    return Instruction(order, motion.begin + delay, motion.end + delay, target, middle, speed, rounded)


def tool_poses(plan: ArmPlan, times: Floats) -> Floats:
    """Tool poses (n, 6) in the lab frame at path times (n,): position in m, angles A, B, C in rad."""
    matrix = tool_frames(plan.path.at(times), plan.roll, plan.reversed_axis)
    return np.concatenate([matrix[:, :3, 3], angles(matrix[:, :3, :3])], axis=1)


def arc_centre(start: Floats, via: Floats, end: Floats) -> Floats:
    """Centre (3,) of the circle through three points (3,) in m.

    Raises
    ------
    ValueError
        Where they lie on a line.
    """
    a, b = via - start, end - start
    normal = np.cross(a, b)
    square = float(normal @ normal)
    if square <= 1e-24 * float(a @ a) * float(b @ b):
        raise ValueError("the three points of an arc lie on a line")
    return np.asarray(start + np.cross(float(a @ a) * b - float(b @ b) * a, normal) / (2.0 * square))


def arc_angle(start: Floats, via: Floats, end: Floats) -> float:
    """Angle (rad) of the arc from ``start`` through ``via`` to ``end``, up to a full turn."""
    centre = arc_centre(start, via, end)
    normal = np.cross(via - start, end - start)
    first, last = start - centre, end - centre
    angle = math.atan2(float(np.cross(first, last) @ normal) / float(np.linalg.norm(normal)), float(first @ last))
    return angle if angle > 0.0 else angle + 2.0 * math.pi


def arc_length(start: Floats, via: Floats, end: Floats) -> float:
    """Length (m) of the arc from ``start`` through ``via`` to ``end``."""
    return arc_angle(start, via, end) * float(np.linalg.norm(start - arc_centre(start, via, end)))
