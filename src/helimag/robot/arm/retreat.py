"""The way up from the end of the path, so that the magnet lets go of the device and the tank can be reached."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.checks import Offence, first_collision, first_offence, joint_rates
from helimag.robot.arm.frames import inverse
from helimag.robot.arm.kinematics import inverse_kinematics, principal
from helimag.robot.arm.path import tool_frames

if TYPE_CHECKING:
    from helimag.robot.arm.planning import ArmPlan

Floats = NDArray[np.float64]

APPROACH_SPEED = 0.1  # m/s; off the path: on the way to its first point, and up from its last
STEP = 2e-3  # m; between checked poses


def retreat_frames(plan: "ArmPlan", heights: Floats) -> Floats:
    """Tool frames (n, 4, 4) in the lab frame at heights (n,) in m above the path's end, attitude unchanged."""
    end = tool_frames(plan.path.at(np.array([plan.path.duration])), plan.roll, plan.reversed_axis)
    result = np.repeat(end, heights.size, axis=0)
    result[:, 2, 3] += heights
    return result


def retreat_offence(plan: "ArmPlan", reach: float) -> Offence | None:
    """What the cell does not allow on the way up; None where it allows all of it, or none is wanted."""
    cell = plan.cell
    if cell.retreat is None:
        return None
    heights = np.linspace(0.0, cell.retreat, max(2, int(cell.retreat / STEP) + 1))
    flange = cell.lab_in_base @ retreat_frames(plan, heights) @ inverse(cell.tool_in_flange)
    solutions = inverse_kinematics(cell.arm, flange)
    first = plan.joints[-1]
    steps = np.diff(solutions.joints[:, plan.branch], axis=0, prepend=first[None])
    joints = first + np.cumsum(principal(steps), axis=0)
    times = plan.path.duration + heights / APPROACH_SPEED
    rates = joint_rates(times, joints)
    offence = first_offence(cell, times, joints, solutions.singular[:, plan.branch], rates)
    if offence is not None and offence.kind == "reach":
        return offence
    collision = first_collision(cell, times, joints, reach)
    return min((found for found in (offence, collision) if found), key=lambda found: found.time, default=None)
