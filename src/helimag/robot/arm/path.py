"""The path of the magnet that a scenario asks for: poses of its centre and axis over time, and the motor's angle."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import Poses, magnet_motion, magnet_start, turn
from helimag.robot.arm.frames import frames
from helimag.scenario import Drive, Scenario
from helimag.scenario import Path as SampledPath

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Floats = NDArray[np.float64]

CHORD = 3e-7  # m; how far a straight piece may leave a curved path
SLEW = 3e-7  # rad; how far a steady turn may leave an unsteady one
ARC = math.pi / 2.0  # longest piece of a circle
TURN = math.radians(5.0)  # longest turn between two points: controllers differ in how they turn a tilted tool
STILL = 1e-4  # m; a smaller circle is programmed as turns: single precision could not time its arcs


class MotionKind(StrEnum):
    """How the arm takes the magnet from one point to the next."""

    LINE = "line"
    ARC = "arc"
    TURN = "turn"
    HOLD = "hold"


@dataclass(frozen=True)
class Motion:
    """A piece of the path that one instruction of a robot programme makes: when it begins and ends (s)."""

    kind: MotionKind
    begin: float
    end: float


@dataclass(frozen=True)
class MagnetPath:
    """Where the magnet is at any time from 0 to ``duration``, and the pieces that a programme makes of it."""

    duration: float
    frequency: float
    at: Callable[[Floats], Poses]
    motions: tuple[Motion, ...]
    yaw_rate: float  # rad/s, of a circle; zero where the path is no steady circle


def magnet_path(scenario: Scenario) -> MagnetPath:
    """The magnet's path in a scenario: eqs (1)-(3) with either reading of pitch, or its samples."""
    drive, duration = scenario.drive, scenario.run.duration
    motions = _drive_motions(drive, duration) if drive.path is None else _sampled_motions(drive, drive.path, duration)
    return MagnetPath(duration, drive.frequency, magnet_motion(drive), motions, drive.yaw_rate)


def _sampled_motions(drive: Drive, path: SampledPath, duration: float) -> tuple[Motion, ...]:
    """A path through samples, cut into straight pieces short enough for its bends and for its changes of speed."""
    spline = path.spline(drive.pitch)
    knots = np.append(spline.x[spline.x < duration * (1.0 - 1e-12)], duration)
    return tuple(
        piece
        for begin, end in pairwise(knots.tolist())
        for piece in pieces(MotionKind.LINE, end, _longest_piece(spline, begin, end), begin)
    )


def _longest_piece(spline: "CubicSpline", begin: float, end: float) -> float:
    """Longest straight piece (s) within ``CHORD`` and ``SLEW``; second derivatives are linear between samples."""
    edges = np.array([begin, end - 1e-9 * (end - begin)])
    bend = float(np.linalg.norm(spline(edges, 2)[:, :3], axis=1).max())
    rates, changes = np.abs(spline(np.linspace(begin, end, 5), 1)[:, 3:5]).max(axis=0), np.abs(spline(edges, 2)[:, 3:5])
    slew = float(changes.max() + rates[0] * rates[1] + rates[1] * rates[1])
    limits = [end - begin]
    limits += [math.sqrt(8.0 * CHORD / bend)] if bend > 0.0 else []
    limits += [math.sqrt(8.0 * SLEW / slew)] if slew > 0.0 else []
    limits += [TURN / float(rates.max())] if rates.max() > 0.0 else []
    return min(limits)


def _drive_motions(drive: Drive, duration: float) -> tuple[Motion, ...]:
    moving = any(drive.velocity)
    if drive.yaw_rate == 0.0:
        return (Motion(MotionKind.LINE if moving else MotionKind.HOLD, 0.0, duration),)
    radius = math.hypot(*magnet_start(drive)[:2])
    rate = abs(drive.yaw_rate)
    if not moving:
        arc = radius > STILL
        return pieces(MotionKind.ARC if arc else MotionKind.TURN, duration, (ARC if arc else TURN) / rate)
    bend = radius * rate**2
    longest = min(TURN / rate, math.sqrt(8.0 * CHORD / bend) if bend > 0.0 else math.inf)
    return pieces(MotionKind.LINE, duration, longest)


def pieces(kind: MotionKind, duration: float, longest: float, begin: float = 0.0) -> tuple[Motion, ...]:
    """Pieces from ``begin`` to ``duration``, of equal length but for the last, which may be shorter."""
    count = max(1, math.ceil((duration - begin) / longest * (1.0 - 1e-9)))
    ends = [min(begin + longest * (i + 1), duration) for i in range(count)]
    return tuple(Motion(kind, a, b) for a, b in zip([begin, *ends], ends, strict=False))


def tool_frames(poses: Poses, roll: float, reversed_axis: bool) -> Floats:
    """Tool frames (n, 4, 4) in the lab frame: x along the motor's axis, turned by ``roll`` (rad) about it.

    With ``reversed_axis`` the motor points against the rotation axis; it then has to run the other way.
    """
    facing = turn(2, math.pi if reversed_axis else 0.0)
    return frames(poses.position, poses.rotation @ facing @ turn(0, roll))


def motor_angle(spin: Floats, roll: float, reversed_axis: bool) -> Floats:
    """Angle (rad) of the moment about the tool's x axis, from its y axis, at these spin angles."""
    return (math.pi - spin if reversed_axis else spin) - roll
