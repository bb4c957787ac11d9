"""The same programme as a Python script for RoboDK."""

import json
from collections.abc import Sequence

import numpy as np

from helimag.robot.arm.planning import ArmPlan
from helimag.robot.krl.instructions import Instruction, Order, instructions
from helimag.robot.krl.writer import checked_name, comment, frame_pose, number

_SCRIPT = '''\
{comments}
# Run it in RoboDK with the arm loaded, to see the run or to make a programme with another post processor.
import json

from robodk.robolink import ITEM_TYPE_ROBOT, Robolink
from robodk.robomath import KUKA_2_Pose

# mm and degrees, KUKA's angles; speeds in mm/s and deg/s; waits in s
PROGRAMME = json.loads(r"""
{data}
""")

link = Robolink()
arm = link.ItemUserPick("Select the arm", ITEM_TYPE_ROBOT)
arm.setPoseFrame(KUKA_2_Pose(PROGRAMME["base"]))
arm.setPoseTool(KUKA_2_Pose(PROGRAMME["tool"]))
arm.setAcceleration(PROGRAMME["acceleration"])
arm.setRounding(PROGRAMME["rounding"])
arm.MoveJ(PROGRAMME["start"])
for step in PROGRAMME["steps"]:
    if step["order"] == "wait":
        arm.Pause(1e3 * step["seconds"])
    elif step["order"] == "joints":
        arm.setSpeedJoints(step["speed"])
        arm.MoveJ(step["target"])
    elif step["order"] == "turn":
        arm.setSpeedJoints(step["speed"])
        arm.MoveL(KUKA_2_Pose(step["target"]))
    else:
        arm.setSpeed(step["speed"])
        if step["order"] == "arc":
            arm.MoveC(KUKA_2_Pose(step["via"]), KUKA_2_Pose(step["target"]))
        else:
            arm.MoveL(KUKA_2_Pose(step["target"]))
'''


def write_robodk(plan: ArmPlan, name: str, header: Sequence[str] = ()) -> str:
    """The text of a RoboDK script of the same instructions.

    RoboDK has no speed for a turn on the spot: that gets a joint speed.

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
        "rounding": float(number(1e3 * plan.cell.approximation, 6)),
        "start": [float(number(angle, 8)) for angle in np.degrees(plan.joints[0])],
        "steps": [_step(plan, order) for order in instructions(plan)],
    }
    comments = "\n".join("#" + comment(line)[1:] for line in header)
    return _SCRIPT.format(comments=comments, data=json.dumps(data, indent=1, allow_nan=False))


def _step(plan: ArmPlan, order: Instruction) -> dict[str, object]:
    match order.order:
        case Order.WAIT:
            return {"order": "wait", "seconds": order.end - order.begin}
        case Order.JOINTS:
            speed = order.speed * float(np.degrees(plan.cell.arm.joint_speed[5]))
            target = [float(number(angle, 8)) for angle in np.degrees(order.target)]
            return {"order": "joints", "speed": speed, "target": target}
        case Order.TURN:
            return {"order": "turn", "speed": float(np.degrees(order.speed)), "target": _shown(order.target)}
    step: dict[str, object] = {"order": str(order.order), "speed": 1e3 * order.speed, "target": _shown(order.target)}
    if order.via is not None:
        step["via"] = _shown(order.via)
    return step


def _shown(pose: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> list[float]:
    """A pose (6,) in mm and degrees."""
    return [float(number(v, 8)) for v in (*(1e3 * pose[:3]), *np.degrees(pose[3:]))]
