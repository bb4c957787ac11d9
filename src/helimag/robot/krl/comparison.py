"""What a programme does, against the plan it was written from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.planning import Plan
from helimag.robot.krl.interpreter import Playback

Floats = NDArray[np.float64]

POSITION = 1e-6  # m; these three are what a programme is held to
AXIS = 1e-6  # rad
TIMING = 1e-3  # of the duration
ARM = 1.0  # m; weighs axis against position where times are matched: a yawing axis tells the time best
STEP = 1e-3  # s; of the differences that give the speed
SLACK = 1e-3  # s; programme times carry the rounding of the speeds


@dataclass(frozen=True)
class Deviation:
    """Largest deviations of a programme: position (m), rotation axis (rad), timing (share of the duration)."""

    position: float
    axis: float
    timing: float
    duration: float

    @property
    def acceptable(self) -> bool:
        """Whether all three are within 1 um, 1e-6 rad and 0.1 %."""
        return self.position < POSITION and self.axis < AXIS and self.timing < TIMING


def deviation(plan: Plan, playback: Playback) -> Deviation:
    """Compare a programme with the plan.

    Every pose of the programme is held against the nearest planned pose around its time: what is left is the
    deviation in position and axis, and how far in time that pose lies is the deviation in timing, as is the
    difference in duration with the ramps of start and stop. An unwinding is compared in position only: the rotation
    axis leaves the path there on purpose.
    """
    times, unwinding = path_time(plan, playback.time)
    sign = -1.0 if plan.reversed_axis else 1.0
    position, axis = playback.pose[:, :3, 3], sign * playback.pose[:, :3, 0]
    late = np.where(unwinding, 0.0, _lateness(plan, times, position, axis))
    planned = plan.path.at(_inside(plan, times - late))
    away = np.linalg.norm(position - planned.position, axis=1)
    chord = np.linalg.norm(axis - planned.axis, axis=1)
    turned = 2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0))
    late_at_end = playback.duration - plan.duration
    timing = max(float(np.abs(late).max()), abs(late_at_end)) / plan.duration
    return Deviation(float(away.max()), float(turned[~unwinding].max()), timing, playback.duration)


def _lateness(plan: Plan, times: Floats, position: Floats, axis: Floats) -> Floats:
    """How much later (s) than planned the magnet is where it is: Gauss-Newton on position and ``ARM`` times axis."""
    late = np.zeros_like(times)
    for _ in range(2):
        now = times - late
        before, here, after = (plan.path.at(_inside(plan, now + shift)) for shift in (-STEP, 0.0, STEP))
        span = np.maximum(after.time - before.time, STEP)[:, None]
        rate = np.concatenate([after.position - before.position, ARM * (after.axis - before.axis)], axis=1) / span
        ahead = np.concatenate([position - here.position, ARM * (axis - here.axis)], axis=1)
        square = np.einsum("ni,ni->n", rate, rate)
        late -= np.where(square > 0.0, np.einsum("ni,ni->n", ahead, rate) / np.where(square > 0.0, square, 1.0), 0.0)
    return late


def _inside(plan: Plan, times: Floats) -> Floats:
    return np.clip(times, 0.0, plan.path.duration)


def path_time(plan: Plan, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Path times of programme times (n,), and whether the arm is unwinding then."""
    path_times = times.copy()
    unwinding = np.zeros(times.shape, dtype=bool)
    delay = 0.0
    for unwound in plan.unwindings:
        begin = unwound.time + delay
        inside = (times > begin + SLACK) & (times < begin + unwound.duration - SLACK)
        unwinding |= inside
        delay += unwound.duration
        path_times = np.where(
            inside, unwound.time, np.where(times >= begin + unwound.duration - SLACK, times - delay, path_times)
        )
    return path_times, unwinding
