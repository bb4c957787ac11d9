"""What a programme does, against the plan it was written from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.robot.interpreter import Playback
from helimag.robot.planning import Plan

Floats = NDArray[np.float64]

POSITION = 1e-6  # m; these three are what a programme is held to
AXIS = 1e-6  # rad
TIMING = 1e-3  # of the duration
SLACK = 1e-3  # s; programme times carry the rounding of the speeds


@dataclass(frozen=True)
class Deviation:
    """Largest deviations of a programme from its plan: position (m), rotation axis (rad), duration (share of the planned one)."""

    position: float
    axis: float
    timing: float
    duration: float

    @property
    def acceptable(self) -> bool:
        """Whether all three are within 1 um, 1e-6 rad and 0.1 %."""
        return self.position < POSITION and self.axis < AXIS and self.timing < TIMING


def deviation(plan: Plan, playback: Playback) -> Deviation:
    """Compare a programme with the plan, pose by pose at equal times, the ramps of start and stop counted as time alone.

    An unwinding is compared in position only: the rotation axis leaves the path there on purpose.
    """
    times = playback.time
    path_times, unwinding = path_time(plan, times)
    planned = plan.path.at(np.clip(path_times, 0.0, plan.path.duration))
    sign = -1.0 if plan.reversed_axis else 1.0
    position = np.linalg.norm(playback.pose[:, :3, 3] - planned.position, axis=1)
    chord = np.linalg.norm(sign * playback.pose[:, :3, 0] - planned.axis, axis=1)
    axis = 2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0))
    timing = abs(playback.duration - plan.duration) / plan.duration
    return Deviation(float(position.max()), float(axis[~unwinding].max()), timing, playback.duration)


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
        path_times = np.where(inside, unwound.time, np.where(times >= begin + unwound.duration - SLACK, times - delay, path_times))
    return path_times, unwinding
