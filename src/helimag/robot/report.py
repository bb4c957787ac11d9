"""What a plan amounts to: feasible or not and why, margins, laps, and what to do."""

import math
from typing import Any

import numpy as np

from helimag.robot.arm.checks import Offence
from helimag.robot.arm.collision import capsules, clearances
from helimag.robot.arm.planning import ArmPlan, plan


def margins(plan: ArmPlan) -> dict[str, Any]:
    """Least distances (degrees, mm) of a plan from joint limits, singularities and obstacles, up to its offence."""
    until = plan.times.size if plan.offence is None else max(1, int(np.searchsorted(plan.times, plan.offence.time)))
    joints, times = plan.joints[:until], plan.times[:until]
    low, high = plan.cell.arm.limits
    stops = [stop.time for stop in plan.unwindings]
    smooth = np.array([not any(a <= stop <= b for stop in stops) for a, b in zip(times[:-2], times[2:], strict=True)])
    rates = (
        np.abs((joints[2:] - joints[:-2]) / (times[2:] - times[:-2])[:, None])[smooth]
        if until > 2
        else np.zeros((1, 6))
    )
    share = (rates / np.array(plan.cell.arm.joint_speed)).max() if rates.size else 0.0
    reach = max(math.hypot(*magnet.offset) + magnet.reach for magnet in plan.scenario.magnet)
    parts = capsules(plan.cell, joints, reach)
    return {
        "joint_limits_deg": {
            f"A{i + 1}": math.degrees(float(np.minimum(joints[:, i] - low[i], high[i] - joints[:, i]).min()))
            for i in range(6)
        },
        "singularity_deg": math.degrees(float(plan.singular[:until].min())),
        "largest_share_of_joint_speed": float(share),
        "obstacles_mm": {
            obstacle.name: 1e3 * float(clearances(parts, obstacle).min()) for obstacle in plan.cell.obstacle
        },
    }


def remedies(plan: ArmPlan) -> list[str]:
    """What can be done about a plan that is not feasible."""
    offence = plan.offence
    if offence is None:
        return []
    if offence.joint in {"A4", "A6"} and offence.kind == "limit" and plan.laps > 0.0:
        found = [
            f"the wrist allows {plan.laps_allowed:.2f} of {plan.laps:.2f} laps, {math.floor(offence.time)} s; "
            "a run.duration that short can leave open whether the device stays"
        ]
        if plan.unwindings == () and math.hypot(*plan.cell.tool.magnet[:2]) < 1e-4:
            found.append("let the wrist unwind in place between laps (--unwind)")
        for other in plan.alternatives[:2]:
            way = "against" if other.reversed_axis else "along"
            found.append(
                f"with the motor's axis {way} the rotation axis and turned by {math.degrees(other.roll):.0f} deg "
                f"(branch {other.branch}) it would get to {other.until:.0f} s"
            )
        return found
    if offence.time > plan.path.duration:
        return ["lower retreat in the cell, or leave it out"]
    return {
        "reach": ["move base.position so that the path is within reach"],
        "singularity": ["move base.position, or lower singularity_margin in the cell"],
        "speed": ["lower the drive's yaw rate or velocity, or raise speed_share in the cell"],
        "collision": ["move the obstacle or base.position, or lower clearance in the cell"],
        "limit": ["move base.position or mount the motor another way (tool.axis)"],
    }[offence.kind]


def with_unwinding(tried: ArmPlan) -> dict[str, Any] | None:
    """What letting axis 6 turn back would make of a plan that stops at its limit; None where it stops elsewhere."""
    if tried.offence is None or tried.offence.joint != "A6" or tried.unwindings:
        return None
    other = plan(tried.scenario, tried.cell, unwind=True)
    return {"feasible": other.feasible, "unwindings": len(other.unwindings), "duration_s": other.duration}


def report(plan: ArmPlan) -> dict[str, Any]:
    """The feasibility report as plain data."""
    return {
        "scenario": plan.scenario.title,
        "scenario_hash": plan.scenario.hash,
        "arm": plan.cell.arm.name,
        "cell": plan.cell.name,
        "feasible": plan.feasible,
        "offence": None if plan.offence is None else offence_data(plan.offence),
        "remedies": remedies(plan),
        "duration_s": plan.duration,
        "laps": plan.laps,
        "laps_allowed": plan.laps_allowed,
        "unwindings": [
            {"time_s": stop.time, "joint": f"A{stop.joint + 1}", "turns": stop.turns, "duration_s": stop.duration}
            for stop in plan.unwindings
        ],
        "tool": {
            "roll_deg": math.degrees(plan.roll),
            "motor_axis": "against" if plan.reversed_axis else "along",
            "branch": plan.branch,
        },
        "start_joints_deg": np.degrees(plan.joints[0]).tolist() if np.isfinite(plan.joints[0]).all() else None,
        "margins": margins(plan) if np.isfinite(plan.joints[0]).all() else None,
    }


def offence_data(offence: Offence) -> dict[str, Any]:
    """An offence as plain data; angles in degrees, distances in mm."""
    scale = 1e3 if offence.kind == "collision" else 180.0 / math.pi
    unit = {"collision": "mm", "speed": "deg/s"}.get(offence.kind, "deg")
    known = offence.kind != "reach"
    return {
        "time_s": offence.time,
        "kind": offence.kind,
        "joint": offence.joint,
        "value": scale * offence.value if known else None,
        "limit": scale * offence.limit if known else None,
        "unit": unit if known else None,
        "text": str(offence),
    }
