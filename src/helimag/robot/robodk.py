"""The same programme as a Python script for RoboDK."""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.planning import ArmPlan
from helimag.robot.krl.instructions import Order
from helimag.robot.krl.sequence import (
    AtStart,
    Awaited,
    Going,
    JointSpeed,
    Output,
    PathSpeed,
    Rest,
    Step,
    sequence,
)
from helimag.robot.krl.writer import checked_name, comment, frame_pose, number

_SCRIPT = '''\
{comments}
# Run it in RoboDK with the arm loaded, to see the run or to make a programme with another post processor.
# An override is neither set nor asked for here: at half an override the arm takes twice as long, the magnet does not.
# What is switched off on a stop is switched off where this script is stopped; a programme that a post processor makes
# of it does not do so by itself. What was read back is the KRL programme of the same steps.
import json

from robodk.robolink import ITEM_TYPE_ROBOT, Robolink
from robodk.robomath import KUKA_2_Pose

# mm and degrees, KUKA's angles; speeds in mm/s and deg/s; waits in s; a rounding of -1 stops
PROGRAMME = json.loads(r"""
{data}
""")

link = Robolink()
arm = link.ItemUserPick("Select the arm", ITEM_TYPE_ROBOT)


def run():
    arm.setPoseFrame(KUKA_2_Pose(PROGRAMME["base"]))
    arm.setPoseTool(KUKA_2_Pose(PROGRAMME["tool"]))
    arm.setAcceleration(PROGRAMME["acceleration"])
    rounding = None
    for step in PROGRAMME["steps"]:
        order = step["order"]
        if order == "speed":
            arm.setSpeed(step["speed"])
        elif order == "joint speed":
            arm.setSpeedJoints(step["speed"])
        elif order == "output":
            arm.setDO(step["number"], int(step["on"]))
        elif order == "input":
            arm.waitDI(step["number"], int(step["on"]))
        elif order == "wait":
            arm.Pause(1e3 * step["seconds"])
        else:
            if step["rounding"] != rounding:
                rounding = step["rounding"]
                arm.setRounding(rounding)
            if order == "joints":
                arm.MoveJ(step["target"])
            elif order == "arc":
                arm.MoveC(KUKA_2_Pose(step["via"]), KUKA_2_Pose(step["target"]))
            else:
                arm.MoveL(KUKA_2_Pose(step["target"]))


try:
    run()
except BaseException:
    for number in PROGRAMME["off_on_a_stop"]:
        arm.setDO(number, 0)
    raise
'''


def write_robodk(plan: ArmPlan, name: str, header: Sequence[str] = ()) -> str:
    """The text of a RoboDK script of the same steps.

    RoboDK has one joint speed for all axes: of those that turn, the slowest in the KRL programme sets it. A turn on
    the spot, for which it has no speed, gets a joint speed too.

    Raises
    ------
    InputError
        Where the name or a number does not fit.
    """
    checked_name(name)
    base, tool = (_shown(frame_pose(matrix)) for matrix in (plan.cell.lab_in_base, plan.cell.tool_in_flange))
    data = {
        "name": name,
        "base": base,
        "tool": tool,
        "acceleration": float(number(1e3 * plan.cell.acceleration, 6)),
        "off_on_a_stop": [] if plan.cell.motor is None else [plan.cell.motor.run_output],
        "steps": [entry for step in sequence(plan) for entry in _entries(plan, step)],
    }
    comments = "\n".join("#" + comment(line)[1:] for line in header)
    return _SCRIPT.format(comments=comments, data=json.dumps(data, indent=1, allow_nan=False))


def _entries(plan: ArmPlan, step: Step) -> list[dict[str, Any]]:
    """A step as plain data."""
    match step:
        case PathSpeed():
            return [{"order": "speed", "speed": float(number(1e3 * step.speed, 7))}]
        case Output():
            return [{"order": "output", "number": step.number, "on": step.on}]
        case Awaited():
            return [{"order": "input", "number": step.number, "on": step.on}]
        case Rest():
            return [{"order": "wait", "seconds": float(number(step.seconds, 6))}]
        case AtStart() | JointSpeed():  # no override here, and one speed for all joints, which a motion carries
            return []
    return _motion(plan, step)


def _motion(plan: ArmPlan, step: Going) -> list[dict[str, Any]]:
    rounding = float(number(1e3 * plan.cell.approximation, 6)) if step.rounded else -1.0
    joints = [float(number(angle, 8)) for angle in np.degrees(step.target)]
    target = joints if step.order is Order.JOINTS else _shown(step.target)
    entry: dict[str, Any] = {"order": str(step.order), "target": target, "rounding": rounding}
    if step.via is not None:
        entry["via"] = _shown(step.via)
    speed = float(number(float(np.degrees(step.rate)), 7))
    return [{"order": "joint speed", "speed": speed}, entry] if step.rate > 0.0 else [entry]


def _shown(pose: NDArray[np.float64]) -> list[float]:
    """A pose (6,) in mm and degrees, with as many decimals as KRL has."""
    return [float(number(v, 6)) for v in 1e3 * pose[:3]] + [float(number(v, 8)) for v in np.degrees(pose[3:])]
