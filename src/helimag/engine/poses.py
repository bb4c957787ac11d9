"""Where the magnet is at the stages of a step: by sums and products from where it is at the step's start.

Cosines and sines at each stage would cost much of a step's time, and lanes of a register have none. With equal steps,
as in a turn (:mod:`helimag.engine.turns`), the angles are the same for all of them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from helimag.engine import tableau
from helimag.engine.stages import STAGES
from helimag.physics.kinematics import ArmMotion, Instant, RpmPose, arm_instant, arm_pose_at, rpm_pose

ANGLES = STAGES + 1
LONGEST = 1.0 / 3.0  # of a turn of the magnet: as far as the series go
TERMS = 13  # of the series of cosine and sine
Shares = wp.types.vector(length=ANGLES, dtype=wp.float64)
StageSpins = wp.types.matrix(shape=(2, ANGLES), dtype=wp.float64)


@wp.struct
class Ahead:
    """By how much spin and yaw of the drive turn from a step's start to its stages and its end: cosines and sines."""

    spin: StageSpins
    yaw: StageSpins


@wp.func
def spin_ahead(spin: wp.vec2d, cosine: wp.float64, sine: wp.float64) -> wp.vec2d:
    """Cosine and sine of the magnet's spin, turned on by the angle of this cosine and sine."""
    return wp.vec2d(spin[0] * cosine - spin[1] * sine, spin[1] * cosine + spin[0] * sine)


@wp.func
def spin_at_stage(spin: wp.vec2d, ahead: StageSpins, i: int) -> wp.vec2d:
    """Cosine and sine of an angle at a step's start, turned on to stage ``i``."""
    return spin_ahead(spin, ahead[0, i], ahead[1, i])


@cache
def build_stage_spins() -> wp.Function:
    """Make the function that gives cosine and sine of the angle from a step's start to each stage and the end.

    The angle to the end is at most LONGEST. By their series, the rest of which is less than 1e-17: sums and products
    that all lanes of a register do at once.
    """
    shares = Shares(*tableau.C[:STAGES], 1.0)
    even = [wp.float64((-1.0) ** k / math.factorial(2 * k)) for k in range(TERMS)]
    odd = [wp.float64((-1.0) ** k / math.factorial(2 * k + 1)) for k in range(TERMS)]

    @wp.func
    def stage_spins(angle: wp.float64) -> StageSpins:
        parts = wp.static(shares) * angle
        squares = wp.cw_mul(parts, parts)
        cosines = Shares(wp.static(even[TERMS - 1]))
        sines = Shares(wp.static(odd[TERMS - 1]))
        for k in range(1, TERMS):
            cosines = wp.cw_mul(cosines, squares) + Shares(wp.static(even[TERMS - 1 - k]))
            sines = wp.cw_mul(sines, squares) + Shares(wp.static(odd[TERMS - 1 - k]))
        spins = StageSpins()
        spins[0] = cosines
        spins[1] = wp.cw_mul(parts, sines)
        return spins

    return stage_spins


@dataclass(frozen=True)
class MagnetPoses:
    """How the magnet's pose is worked out over a step.

    Attributes
    ----------
    instant
        ``instant(drive, t)``: what ``t`` (s) comes to.
    at
        ``at(drive, instant)``: the pose then.
    ahead
        ``ahead(drive, h)``: how the drive goes on to the stages of a step of ``h`` (s).
    at_stage
        ``at_stage(drive, instant, ahead, i, dt)``: the pose at stage ``i``, ``dt`` (s) after the step's start.
    """

    instant: wp.Function
    at: wp.Function
    ahead: wp.Function
    at_stage: wp.Function


@cache
def poses_of(pose: Callable[..., Any]) -> MagnetPoses:
    """How poses of a drive are worked out: where it turns evenly, without cosines and sines at the stages."""
    return _even() if pose is rpm_pose else _any(pose)


def _even() -> MagnetPoses:
    stage_spins = build_stage_spins()

    @wp.func
    def ahead(drive: ArmMotion, h: wp.float64) -> Ahead:
        return Ahead(stage_spins(drive.spin_rate * h), stage_spins(drive.yaw_rate * h))

    @wp.func
    def at_stage(drive: ArmMotion, instant: Instant, ahead: Ahead, i: int, dt: wp.float64) -> RpmPose:
        later = Instant(
            instant.time + dt, spin_at_stage(instant.yaw, ahead.yaw, i), spin_at_stage(instant.spin, ahead.spin, i)
        )
        return arm_pose_at(drive, later)

    return MagnetPoses(arm_instant, arm_pose_at, ahead, at_stage)


def _any(pose: Callable[..., Any]) -> MagnetPoses:
    drive_type = pose.input_types["drive"]  # type: ignore[attr-defined]

    @wp.func
    def instant(drive: drive_type, t: wp.float64) -> Instant:  # noqa: ARG001 - as for drives that turn evenly
        now = Instant()
        now.time = t
        return now

    @wp.func
    def at(drive: drive_type, instant: Instant) -> RpmPose:
        return pose(drive, instant.time)

    @wp.func
    def ahead(drive: drive_type, h: wp.float64) -> wp.float64:  # noqa: ARG001 - likewise
        return h

    @wp.func
    def at_stage(drive: drive_type, instant: Instant, ahead: wp.float64, i: int, dt: wp.float64) -> RpmPose:  # noqa: ARG001
        return pose(drive, instant.time + dt)

    return MagnetPoses(instant, at, ahead, at_stage)
