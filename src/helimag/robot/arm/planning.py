"""From a scenario and a cell to joint angles over time, checked; or the reason why there are none."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.cell import Cell, check_tank
from helimag.robot.arm.checks import Offence, continuous, first_collision, first_offence, joint_rates
from helimag.robot.arm.frames import inverse
from helimag.robot.arm.kinematics import BRANCHES, TURN, inverse_kinematics
from helimag.robot.arm.path import MagnetPath, Motion, magnet_path, tool_frames
from helimag.robot.arm.retreat import retreat_offence
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

ROLLS = 24  # angles about the motor's axis that are tried
STEP_ANGLE = math.radians(2.0)  # between checked poses
STEP_LENGTH = 2e-3  # m
IN_PLACE = 1e-4  # m; how far the magnet's centre may be off the sixth axis
FEWEST, MOST = 50, 20_000  # checked poses
AMPLE = math.radians(20.0)  # a margin beyond which more is no better
SAME = 5e-10  # s; times closer than this are one
TRIES = 12  # candidates that are checked for collisions before the best of them is taken


@dataclass(frozen=True)
class Unwinding:
    """A stop at path time ``time`` (s) in which a joint turns back by whole turns, the magnet staying in place."""

    time: float
    joint: int
    turns: int
    duration: float


@dataclass(frozen=True)
class Alternative:
    """Another way to hold the tool: turn about the motor's axis (rad), its direction, and how far it gets (s)."""

    roll: float
    reversed_axis: bool
    branch: int
    until: float


@dataclass(frozen=True)
class ArmPlan:
    """How the arm takes the magnet along a scenario's path.

    ``times`` (n,) in s and ``joints`` (n, 6) in rad are the checked poses; the tool is turned by ``roll`` about the
    motor's axis, which points against the rotation axis where ``reversed_axis``. Where ``offence`` is not None the
    arm cannot do it, and the joints are those of the attempt that got furthest. At an unwinding the joints are those
    after it.
    """

    scenario: Scenario
    cell: Cell
    path: MagnetPath
    motions: tuple[Motion, ...]
    times: Floats
    joints: Floats
    singular: Floats
    roll: float
    reversed_axis: bool
    branch: int
    offence: Offence | None
    alternatives: tuple[Alternative, ...] = ()
    unwindings: tuple[Unwinding, ...] = ()

    @property
    def feasible(self) -> bool:
        """Whether the arm can do it."""
        return self.offence is None

    @property
    def laps(self) -> float:
        """Turns about the vertical that the path asks for."""
        return abs(self.path.yaw_rate) * self.path.duration / TURN

    @property
    def laps_allowed(self) -> float:
        """Turns about the vertical until the first offence, or all of them."""
        return self.laps if self.offence is None else abs(self.path.yaw_rate) * self.offence.time / TURN

    @property
    def duration(self) -> float:
        """Expected time from the first motion to the last (s), with its unwindings."""
        return self.path.duration + math.fsum(unwinding.duration for unwinding in self.unwindings)

    def programme_time(self, times: Floats) -> Floats:
        """When the programme is at these path times (s); an unwinding comes before the path goes on.

        Returns
        -------
        ndarray
            As many, s.
        """
        return np.asarray(times + sum((times >= u.time) * u.duration for u in self.unwindings))


@dataclass(frozen=True)
class _Candidate:
    joints: Floats
    singular: Floats
    roll: float
    reversed_axis: bool
    branch: int
    offence: Offence | None
    margin: float

    @property
    def merit(self) -> tuple[float, float, float]:
        """How far it gets; distance from limits and singularities up to ``AMPLE``; then how upright the tool is."""
        until = math.inf if self.offence is None else self.offence.time
        return until, min(self.margin, AMPLE), -abs(self.roll) - self.reversed_axis


def plan(scenario: Scenario, cell: Cell, *, unwind: bool = False) -> ArmPlan:
    """Find joint angles along the magnet's path.

    All eight branches are tried with the motor either way round and with 24 angles about its axis (the arm's turn
    about that axis is free, since the motor turns the magnet about it anyway). Of those that pass every check the one
    furthest from limits and singularities is taken; if none passes, the one that gets furthest in time.

    Parameters
    ----------
    unwind
        Where a wrist axis runs into its limit, stop there and turn it back by whole turns.

    Returns
    -------
    ArmPlan
        Feasible or not; where not, with the first offence.

    Raises
    ------
    InputError
        Where the device starts outside the cell's tank, or the scenario's walls lie outside it.
    """
    check_tank(cell, scenario)
    path = magnet_path(scenario)
    times = _sample_times(path)
    reach = max(math.hypot(*magnet.offset) + magnet.reach for magnet in scenario.magnet)
    candidates = sorted(_candidates(path, cell, times), key=lambda candidate: candidate.merit, reverse=True)
    tried = []
    for candidate in candidates[:TRIES]:
        tried.append(_with_collisions(candidate, cell, times, reach))
        if tried[-1].offence == candidate.offence:
            break
    best = max(tried, key=lambda candidate: candidate.merit)
    found = ArmPlan(
        scenario,
        cell,
        path,
        path.motions,
        times,
        best.joints,
        best.singular,
        best.roll,
        best.reversed_axis,
        best.branch,
        best.offence,
        _alternatives(candidates, best, path.duration),
    )
    found = unwound(found, reach) if unwind else found
    return found if found.offence is not None else replace(found, offence=retreat_offence(found, reach))


def _alternatives(candidates: list[_Candidate], best: _Candidate, duration: float) -> tuple[Alternative, ...]:
    """The best of each other branch and direction of the motor; collisions are not looked at."""
    seen = {(best.reversed_axis, best.branch)}
    found = []
    for candidate in candidates:
        way = (candidate.reversed_axis, candidate.branch)
        until = duration if candidate.offence is None else candidate.offence.time
        if way not in seen and until > 0.0:
            seen.add(way)
            found.append(Alternative(candidate.roll, candidate.reversed_axis, candidate.branch, until))
    return tuple(found)


def unwound(plan: ArmPlan, reach: float) -> ArmPlan:
    """The plan with stops between its motions in which axis 6 turns back whole turns, as often as its limits demand.

    Raises
    ------
    InputError
        Where the magnet's centre is off the sixth axis, so that unwinding would move it.
    """
    cell = plan.cell
    low, high = cell.arm.limits[:, 5]
    rates = joint_rates(plan.times, plan.joints)
    speed = cell.joint_percent / 100.0 * cell.arm.joint_speed[5]
    while plan.offence is not None and plan.offence.kind == "limit" and plan.offence.joint == "A6":
        if math.hypot(*cell.tool.magnet[:2]) > IN_PLACE:
            raise InputError(
                "unwinding needs tool.magnet on the flange's z axis, so that the magnet's centre stays in place"
            )
        since = plan.unwindings[-1].time if plan.unwindings else 0.0
        ends = [motion.end for motion in plan.motions if since < motion.end < plan.offence.time]
        if not ends:
            break
        at = int(np.searchsorted(plan.times, ends[-1] - 1e-9))
        angle = plan.joints[at, 5]
        turns = math.floor((angle - low) / TURN) if plan.offence.value > high else -math.floor((high - angle) / TURN)
        joints = plan.joints.copy()
        joints[at:, 5] -= turns * TURN
        back = Unwinding(float(plan.times[at]), 5, -turns, abs(turns) * TURN / speed)
        offence = _unwinding_collision(plan, at, turns, reach) or first_offence(
            cell, plan.times, joints, plan.singular, rates
        )
        plan = replace(plan, joints=joints, offence=offence, unwindings=(*plan.unwindings, back))
    if plan.offence is not None and plan.offence.kind == "collision":
        return plan
    return replace(plan, offence=_earliest(plan.offence, first_collision(cell, plan.times, plan.joints, reach)))


def _unwinding_collision(plan: ArmPlan, at: int, turns: int, reach: float) -> Offence | None:
    """A collision while axis 6 turns back at this sample."""
    steps = np.linspace(0.0, -turns * TURN, 73 * abs(turns))
    swept = np.repeat(plan.joints[at : at + 1], steps.size, axis=0)
    swept[:, 5] += steps
    return first_collision(plan.cell, np.full(steps.size, plan.times[at]), swept, reach)


def _earliest(*offences: Offence | None) -> Offence | None:
    return min((offence for offence in offences if offence), key=lambda offence: offence.time, default=None)


def _sample_times(path: MagnetPath) -> Floats:
    """Times (n,) of the poses to check: all ends of motions, and between them as the path moves and turns."""
    rough = path.at(np.linspace(0.0, path.duration, 2001))
    length = float(np.linalg.norm(np.diff(rough.position, axis=0), axis=1).sum())
    steps = np.clip(np.einsum("nij,nij->n", rough.rotation[1:], rough.rotation[:-1]) / 2.0 - 0.5, -1.0, 1.0)
    turned = max(float(np.arccos(steps).sum()), abs(path.yaw_rate) * path.duration)
    count = int(np.clip(max(length / STEP_LENGTH, turned / STEP_ANGLE), FEWEST, MOST))
    ends = [motion.end for motion in path.motions] if len(path.motions) < count else []
    times = np.unique(np.concatenate([np.linspace(0.0, path.duration, count + 1), ends]))
    return np.asarray(times[np.append(True, np.diff(times) > SAME)])


def _candidates(path: MagnetPath, cell: Cell, times: Floats) -> Iterator[_Candidate]:
    poses = path.at(times)
    to_flange = inverse(cell.tool_in_flange)
    low, high = cell.arm.limits
    for reversed_axis in (False, True):
        for roll in np.pi * (2.0 * np.arange(ROLLS) / ROLLS - 1.0):
            flange = cell.lab_in_base @ tool_frames(poses, roll, reversed_axis) @ to_flange
            solutions = inverse_kinematics(cell.arm, flange)
            for branch in range(BRANCHES):
                joints = continuous(cell.arm, solutions, branch)
                singular = solutions.singular[:, branch]
                offence = first_offence(cell, times, joints, singular, joint_rates(times, joints))
                margin = min(float(np.minimum(joints - low, high - joints).min()), float(singular.min()))
                margin = margin if math.isfinite(margin) else -math.inf
                yield _Candidate(joints, singular, float(roll), reversed_axis, branch, offence, margin)


def _with_collisions(candidate: _Candidate, cell: Cell, times: Floats, reach: float) -> _Candidate:
    """The candidate with a collision as its offence, if that comes first."""
    until = times.size if candidate.offence is None else int(np.searchsorted(times, candidate.offence.time)) + 1
    finite = np.isfinite(candidate.joints[:until]).all(axis=1)
    until = until if finite.all() else int(np.argmin(finite))
    if until == 0:
        return candidate
    collision = first_collision(cell, times[:until], candidate.joints[:until], reach)
    return candidate if collision is None else replace(candidate, offence=collision)
