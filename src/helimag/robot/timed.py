"""A plan as a table over programme time: magnet, tool, joints, motor. What the CSV and JSON files hold."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError
from helimag.robot.arm.collision import tool_frames_in_base
from helimag.robot.arm.frames import angles, inverse
from helimag.robot.arm.kinematics import inverse_kinematics, principal
from helimag.robot.arm.path import motor_angle, tool_frames
from helimag.robot.arm.planning import ArmPlan, Unwinding
from helimag.runs import read_table

Floats = NDArray[np.float64]

UNWINDING_ROWS = 37
JOINTS = tuple(f"a{i + 1}" for i in range(6))


@dataclass(frozen=True)
class Table:
    """Rows over programme time (n,) in s.

    Tool pose in the lab frame (n, 4, 4) in m; rotation axis (n, 3); joints (n, 6) in rad; motor angle
    (n,) rad about the tool's x axis from its y axis; and whether the arm is unwinding.
    """

    time: Floats
    tool: Floats
    axis: Floats
    joints: Floats
    motor: Floats
    unwinding: NDArray[np.bool_]

    def columns(self) -> dict[str, Floats]:
        """Columns by name and unit, as they are written."""
        position, abc = 1e3 * self.tool[:, :3, 3], np.degrees(angles(self.tool[:, :3, :3]))
        joints = np.degrees(self.joints)
        return {
            "time [s]": self.time,
            **{f"{name} [mm]": position[:, i] for i, name in enumerate("xyz")},
            **{f"{name} [deg]": abc[:, i] for i, name in enumerate("abc")},
            **{f"axis_{name} [1]": self.axis[:, i] for i, name in enumerate("xyz")},
            **{f"a{i + 1} [deg]": joints[:, i] for i in range(6)},
            "motor [deg]": np.degrees(self.motor),
        }


@dataclass(frozen=True)
class TimedPath:
    """Of a written table what a figure needs: time (n,) in s, joints (n, 6) in rad."""

    time: Floats
    joints: Floats


def read_timed(path: str | Path) -> TimedPath:
    """Read the timed path (.csv) that goes with a programme.

    Returns
    -------
    TimedPath
        SI, angles in rad.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where a column or a unit is missing, a value is no number, or time does not rise.
    """
    kinds = {"time": q.TIME, **dict.fromkeys(JOINTS, q.ANGLE)}
    try:
        table = read_table(path, kinds, needed=["time", *JOINTS])
        table.check_rises("time")
    except InputError as error:
        raise InputError(f"{path}: {error}; a robot's path is the NAME_path.csv of helimag robot program") from None
    return TimedPath(table.values["time"], np.stack([table.values[name] for name in JOINTS], axis=1))


def timed_table(plan: ArmPlan) -> Table:
    """The checked poses of a plan over programme time, with rows inside every unwinding; the motor turns on."""
    to_lab = inverse(plan.cell.lab_in_base)
    path_times, joints = _with_rows_about_stops(plan)
    tools = to_lab @ tool_frames_in_base(plan.cell, joints)
    time = plan.programme_time(path_times)
    unwinding = np.zeros(time.size, dtype=bool)
    for stop in plan.unwindings:
        rows, swept = _swept(plan, stop)
        time = np.concatenate([time, rows])
        joints = np.concatenate([joints, swept])
        tools = np.concatenate([tools, to_lab @ tool_frames_in_base(plan.cell, swept)])
        unwinding = np.concatenate([unwinding, np.ones(rows.size, dtype=bool)])
    order = np.argsort(time, kind="stable")
    axis = (-1.0 if plan.reversed_axis else 1.0) * tools[:, :3, 0]
    motor = motor_angle(2.0 * math.pi * plan.path.frequency * time, plan.roll, plan.reversed_axis)
    return Table(time[order], tools[order], axis[order], joints[order], motor[order], unwinding[order])


def _with_rows_about_stops(plan: ArmPlan) -> tuple[Floats, Floats]:
    """Path times and joints with rows close together about each unwinding, so that splines bend there only."""
    steps = [
        stop.duration / UNWINDING_ROWS * sign * k
        for stop in plan.unwindings[:1]
        for sign in (-1, 1)
        for k in range(1, 13)
    ]
    wanted = np.array([stop.time + step for stop in plan.unwindings for step in steps])
    extra = wanted[(wanted > 0.0) & (wanted < plan.path.duration)]
    if not extra.size:
        return plan.times, plan.joints
    flange = plan.cell.lab_in_base @ tool_frames(plan.path.at(extra), plan.roll, plan.reversed_axis)
    found = inverse_kinematics(plan.cell.arm, flange @ inverse(plan.cell.tool_in_flange)).joints[:, plan.branch]
    before = plan.joints[np.searchsorted(plan.times, extra, side="right") - 1]
    times, joints = np.append(plan.times, extra), np.concatenate([plan.joints, before + principal(found - before)])
    order = np.argsort(times, kind="stable")
    return times[order], joints[order]


def _swept(plan: ArmPlan, stop: Unwinding) -> tuple[Floats, Floats]:
    """Programme times and joints inside an unwinding but for its end, which is a row already."""
    at = int(np.searchsorted(plan.times, stop.time - 1e-9))
    share = np.arange(UNWINDING_ROWS) / UNWINDING_ROWS
    joints = np.repeat(plan.joints[at : at + 1], share.size, axis=0)
    joints[:, stop.joint] -= 2.0 * math.pi * stop.turns * (1.0 - share)
    end = float(plan.programme_time(np.array([plan.times[at]]))[0])
    return end - stop.duration * (1.0 - share), joints


def motor_rows(plan: ArmPlan) -> list[dict[str, float]]:
    """Set-points of the motor: from each time on, its speed about the tool's x axis, and the moment's angle.

    The moment's angle is counted about the tool's x axis from its y axis.
    """
    table = timed_table(plan)
    rate = plan.path.frequency * (-1.0 if plan.reversed_axis else 1.0)
    rows = []
    for at, speed in ((0, rate), (-1, 0.0)):
        rows.append(
            {
                "time [s]": float(table.time[at]),
                "frequency [Hz]": speed,
                "speed [rpm]": 60.0 * speed,
                "angle [deg]": math.degrees(float(table.motor[at])) % 360.0,
            }
        )
    return rows
