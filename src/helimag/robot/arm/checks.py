"""What stops an arm on its way: reach, singularities, joint limits and speeds, collisions."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.cell import Arm, Cell
from helimag.robot.arm.collision import capsules, clearances
from helimag.robot.arm.kinematics import TURN, Solutions

Floats = NDArray[np.float64]

SINGULARITIES = ("A1, wrist over the first axis", "A3, arm stretched or folded", "A5, axes 4 and 6 in line")


@dataclass(frozen=True)
class Offence:
    """The first thing that a path does which the cell does not allow; value and limit in SI units or radians.

    ``time`` is when the limit is passed, ``value`` that of the first checked pose beyond it.
    """

    time: float
    kind: str  # reach, singularity, limit, speed or collision
    joint: str
    value: float
    limit: float

    def __str__(self) -> str:
        at = f"at {self.time:.2f} s"
        match self.kind:
            case "reach":
                return f"{at} the pose is out of reach of {self.joint}"
            case "singularity":
                return (
                    f"{at} the arm is {_degrees(self.value)} from a singularity of {self.joint}; "
                    f"the cell's margin is {_degrees(self.limit)}"
                )
            case "limit":
                return f"{at} {self.joint} would pass its limit of {_degrees(self.limit)}, to {_degrees(self.value)}"
            case "speed":
                return (
                    f"{at} {self.joint} would turn at {_degrees(self.value)}/s; its limit is {_degrees(self.limit)}/s"
                )
            case _:
                return (
                    f"{at} the {self.joint} would be {1e3 * self.value:.1f} mm away; the cell's clearance is "
                    f"{1e3 * self.limit:.1f} mm"
                )


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.2f} deg"


def joint_rates(times: Floats, joints: Floats) -> Floats:
    """Joint speeds (n, 6) in rad/s by differences."""
    return np.gradient(joints, times, axis=0)


def first_offence(cell: Cell, times: Floats, joints: Floats, singular: Floats, rates: Floats) -> Offence | None:
    """The first offence, apart from collisions, of joints (n, 6) that turn at ``rates`` (n, 6).

    ``singular`` (n, 3) is as in :class:`Solutions`.
    """
    found = [offence for offence in _offences(cell, times, joints, singular, rates) if offence is not None]
    return min(found, key=lambda offence: offence.time, default=None)


def _offences(cell: Cell, times: Floats, joints: Floats, singular: Floats, rates: Floats) -> Iterator[Offence | None]:
    arm = cell.arm
    lost = ~np.isfinite(joints).all(axis=1)
    if lost.any():
        yield Offence(float(times[np.argmax(lost)]), "reach", "the arm", math.nan, math.nan)
    for i, what in enumerate(SINGULARITIES):
        yield _first(
            times,
            singular[:, i],
            singular[:, i] < cell.singularity_margin,
            "singularity",
            what,
            cell.singularity_margin,
        )
    low, high = arm.limits
    speeds = np.abs(rates)
    for i in range(6):
        name, angle = f"A{i + 1}", joints[:, i]
        yield _first(times, angle, angle < low[i], "limit", name, low[i])
        yield _first(times, angle, angle > high[i], "limit", name, high[i])
        allowed = cell.speed_share * arm.joint_speed[i]
        yield _first(times, speeds[:, i], speeds[:, i] > allowed, "speed", name, allowed)


def _first(
    times: Floats, values: Floats, bad: NDArray[np.bool_], kind: str, joint: str, limit: float
) -> Offence | None:
    if not bad.any():
        return None
    at = int(np.argmax(bad))
    return Offence(_crossing(times, values, at, limit), kind, joint, float(values[at]), float(limit))


def _crossing(times: Floats, values: Floats, at: int, limit: float) -> float:
    """When the values pass the limit on their way to the sample ``at`` (s), by a straight line from the one before."""
    if at == 0 or not np.isfinite(values[at - 1]) or values[at] == values[at - 1]:
        return float(times[at])
    share = (limit - values[at - 1]) / (values[at] - values[at - 1])
    return float(times[at - 1] + np.clip(share, 0.0, 1.0) * (times[at] - times[at - 1]))


def first_collision(cell: Cell, times: Floats, joints: Floats, magnet_reach: float) -> Offence | None:
    """The first time that a part of the arm, the motor or the magnet comes closer to an obstacle than the clearance."""
    parts = capsules(cell, joints, magnet_reach)
    found = []
    for obstacle in cell.obstacle:
        distances = clearances(parts, obstacle)
        for i, name in enumerate(parts.names):
            where = f"{name} from the {obstacle.name}"
            offence = _first(
                times, distances[:, i], distances[:, i] < cell.clearance, "collision", where, cell.clearance
            )
            if offence is not None:
                found.append(offence)
    return min(found, key=lambda offence: offence.time, default=None)


def continuous(arm: Arm, solutions: Solutions, branch: int) -> Floats:
    """One branch along a path as continuous joint angles (n, 6), shifted by whole turns to stay legal longest."""
    joints = np.unwrap(solutions.joints[:, branch, :], axis=0)
    if not np.isfinite(joints[0]).all():
        return np.full_like(joints, np.nan)
    low, high = arm.limits
    for i in range(6):
        first = np.ceil((low[i] - joints[0, i]) / TURN - 1e-12)
        last = np.floor((high[i] - joints[0, i]) / TURN + 1e-12)
        choices = TURN * np.arange(first, last + 1)
        if choices.size:
            joints[:, i] += max(choices, key=lambda shift: _legal_span(joints[:, i] + shift, low[i], high[i]))
    return joints


def _legal_span(angle: Floats, low: float, high: float) -> tuple[int, float]:
    """For how many samples an angle stays within its limits, and then its least margin: the larger, the better."""
    bad = (angle < low) | (angle > high)
    legal = int(np.argmax(bad)) if bad.any() else angle.size
    return legal, float(np.minimum(angle - low, high - angle)[: max(legal, 1)].min())
