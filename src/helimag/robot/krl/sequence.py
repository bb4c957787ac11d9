"""All that a programme does, step by step and before any language, so that KRL and RoboDK cannot differ."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.frames import angles
from helimag.robot.arm.path import motor_angle
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.arm.retreat import APPROACH_SPEED, retreat_frames
from helimag.robot.krl.instructions import Instruction, Order, instructions, tool_poses

Floats = NDArray[np.float64]

DECIMALS = 10  # of a speed in m/s, as programmes are written
APPROACH = 10  # % of the joint speeds, on the way to the first point


@dataclass(frozen=True)
class PathSpeed:
    """From here on, the speed along the path (m/s); ``time`` (s) is when the first motion with it begins."""

    speed: float
    time: float = 0.0


@dataclass(frozen=True)
class JointSpeed:
    """From here on, the speed of all joints, in percent of what each can do."""

    percent: int


@dataclass(frozen=True)
class Going:
    """A motion to a named point: joint angles (6,) in rad, or a tool pose (6,) in m and rad in the lab frame.

    ``via`` is the named middle of an arc; ``rate`` (rad/s) the speed of a turn on the spot, or of the slowest joint
    that turns.
    """

    order: Order
    name: str
    target: Floats
    via_name: str = ""
    via: Floats | None = None
    rounded: bool = False
    rate: float = 0.0


@dataclass(frozen=True)
class AtStart:
    """The arm stands where the path begins: from here on nothing may slow it."""


@dataclass(frozen=True)
class Output:
    """A digital output is switched."""

    number: int
    on: bool


@dataclass(frozen=True)
class Awaited:
    """The arm waits until a digital input is on, or off."""

    number: int
    on: bool


@dataclass(frozen=True)
class Rest:
    """The arm stands still (s)."""

    seconds: float


Step = PathSpeed | JointSpeed | Going | AtStart | Output | Awaited | Rest


def sequence(plan: ArmPlan) -> list[Step]:
    """The steps of a programme: to the start, handshake with the motor, path with its unwindings, motor off, up."""
    return [*_to_start(plan), *handshake(plan), *_along(plan), *_off(plan), *_up(plan)]


def _to_start(plan: ArmPlan) -> Iterator[Step]:
    yield PathSpeed(APPROACH_SPEED)
    yield JointSpeed(APPROACH)
    slowest = APPROACH / 100.0 * min(plan.cell.arm.joint_speed)
    yield Going(Order.JOINTS, "XSTART", plan.joints[0], rate=slowest)
    # joint angles in single precision are off by some 50 nm; a pose in the lab frame is not
    yield Going(Order.LINE, "XBEGIN", tool_poses(plan, plan.times[:1])[0])
    yield AtStart()


def handshake(plan: ArmPlan) -> Iterator[Step]:
    """Motor on, at speed, past its phase reference, and on until the moment is where the path begins."""
    motor, start = plan.cell.motor, plan.cell.start_output
    if motor is not None:
        yield Output(motor.run_output, True)
        if motor.speed_input is not None:
            yield Awaited(motor.speed_input, True)
        if motor.phase_input is not None:
            yield Awaited(motor.phase_input, False)
            yield Awaited(motor.phase_input, True)
            yield Rest(lead_time(plan))
    if start is not None:
        yield Output(start, True)


def lead_time(plan: ArmPlan) -> float:
    """Time (s) from the rise of the motor's phase input to the beginning of the path, less than a turn of the motor."""
    motor = plan.cell.motor
    if motor is None or motor.phase_input is None:
        return 0.0
    drive = plan.scenario.drive
    phase = drive.path.phase[0] if drive.path is not None and drive.path.phase else 0.0
    wanted = float(motor_angle(np.array(phase), plan.roll, plan.reversed_axis))
    rate = 2.0 * math.pi * plan.path.frequency * (-1.0 if plan.reversed_axis else 1.0)
    return (wanted - motor.phase_angle) / rate % (2.0 * math.pi / abs(rate))


def _along(plan: ArmPlan) -> Iterator[Step]:
    speed, percent = -1.0, APPROACH
    before: Going | None = None
    for i, order in enumerate(instructions(plan), start=1):
        if order.order is Order.WAIT:
            yield Rest(order.end - order.begin)
            continue
        if order.order in {Order.LINE, Order.ARC} and round(order.speed, DECIMALS) != speed:
            speed = round(order.speed, DECIMALS)
            yield PathSpeed(order.speed, order.begin)
        if order.order is Order.JOINTS and round(100.0 * order.speed) != percent:
            percent = round(100.0 * order.speed)
            yield JointSpeed(percent)
        going = _going(plan, order, i)
        yield going
        if order.order is Order.JOINTS and before is not None:  # the pose that it has turned back to
            yield Going(Order.LINE, before.name, before.target)
        before = going


def _going(plan: ArmPlan, order: Instruction, i: int) -> Going:
    via = "" if order.via is None else f"XV{i}"
    unwinding = order.speed * plan.cell.arm.joint_speed[5]
    rate = {Order.TURN: order.speed, Order.JOINTS: unwinding}.get(order.order, 0.0)
    return Going(order.order, f"XP{i}", order.target, via, order.via, order.rounded, rate)


def _off(plan: ArmPlan) -> Iterator[Step]:
    motor, start = plan.cell.motor, plan.cell.start_output
    if start is not None:
        yield Output(start, False)
    if motor is not None:
        yield Output(motor.run_output, False)


def _up(plan: ArmPlan) -> Iterator[Step]:
    if plan.cell.retreat is None:
        return
    matrix = retreat_frames(plan, np.array([plan.cell.retreat]))[0]
    yield PathSpeed(APPROACH_SPEED)
    yield Going(Order.LINE, "XUP", np.concatenate([matrix[:3, 3], angles(matrix[:3, :3])]))
