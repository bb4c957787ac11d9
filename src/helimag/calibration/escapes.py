"""When a run ends so or so, as a smooth quantity: a time that goes on beyond the run's horizon and past other ends.

A plain likelihood of "it was attracted at 400 s" is nought for every device that stays, and tells a search nothing of
where to go. Here the logarithm of the time is continued: a run that comes to its horizon H without that end has
``ln H + w``, where w is the way that is left to it, as a share of the way at the start; nought where the end comes at
the horizon itself, so that nothing jumps there. One that ended otherwise at t has ``ln(H / t)`` more: the sooner, the
further from what was seen.
"""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, initial_gap, start_state
from helimag.geometry import long_axes, magnet_motion
from helimag.outcomes import End, Limit
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

ENDS = {
    "attracted": End.CONTACT,
    "fell": End.FALL,
    "floor": End.FLOOR,
    "surface": End.SURFACE,
    "wall": End.WALL,
}
FALLEN = 0.5  # of the initial gap below the start, as helimag.runs.judge has it
LEAST_WAY = 1e-2  # of the initial gap: a device that starts nearer to a wall than that counts as that far from it


def ways(scenario: Scenario, time: float, state: Floats) -> dict[End, float]:
    """How far (m) a device in a state (7,) is from each end that a run can have; only of what is there."""
    pose = magnet_motion(scenario.drive)(np.array([time]))
    gaps = [
        float(np.linalg.norm(state[:3] - pose.position[0] - pose.rotation[0] @ np.array(magnet.offset)))
        for magnet in scenario.magnet
    ]
    found = {
        End.CONTACT: min(gaps) - scenario.contact_distance,
        End.FALL: float(state[2]) - scenario.drive.start[2] + FALLEN * initial_gap(scenario),
    }
    below, above = _clear(scenario, state)
    sides = {End.FLOOR: below[2], End.SURFACE: above[2], End.WALL: min(*below[:2], *above[:2])}
    return found | {end: float(way) for end, way in sides.items() if math.isfinite(way)}


def _clear(scenario: Scenario, state: Floats) -> tuple[Floats, Floats]:
    """Free way (3,) along each axis, down and up, of head and rear end."""
    device, (low, high) = scenario.device, scenario.workspace.box
    head = state[:3]
    tail = head - device.tail_length * long_axes(state[None, 3:])[0]
    below = np.minimum(head - device.head_radius, tail - device.tail_radius) - np.array(low)
    above = np.array(high) - np.maximum(head + device.head_radius, tail + device.tail_radius)
    return below, above


def log_time(history: History, end: End) -> float:
    """Logarithm of the time (s) at which a run has an end, continued as above.

    A wall that is not there is as far as the magnet is at the start. One that holds is reached at the first contact.
    """
    reached = _reached(history, end)
    if reached is not None:
        return math.log(max(reached, 1e-3))
    scenario, horizon = history.scenario, history.scenario.run.duration
    gap = initial_gap(scenario)
    last, first = (ways(scenario, float(history.time[i]), history.states[i]).get(end, gap) for i in (-1, 0))
    left = max(last, 0.0) / max(first, LEAST_WAY * gap)
    early = math.log(horizon / max(float(history.time[-1]), 1e-3)) if history.status is not End.HORIZON else 0.0
    return math.log(horizon) + left + early


def log_stay(history: History) -> float:
    """Logarithm of the time (s) for which a run stays, continued as above: the first of all its ends."""
    scenario = history.scenario
    ends = set(ways(scenario, 0.0, start_state(scenario)))
    if scenario.workspace.holds:
        ends -= {End.FLOOR, End.SURFACE, End.WALL}
    if history.status not in (End.HORIZON, End.FALL):
        return math.log(max(float(history.time[-1]), 1e-3))
    return min(log_time(history, end) for end in ends)


def _reached(history: History, end: End) -> float | None:
    if end is End.FALL:
        return _fallen(history)
    if history.status is end:
        return float(history.time[-1])
    limits = {End.FLOOR: {Limit.FLOOR}, End.SURFACE: {Limit.SURFACE}}.get(end)
    if end is End.WALL:
        limits = set(Limit) - {Limit.FLOOR, Limit.SURFACE}
    times = [touch.first for touch in history.touches if limits and touch.wall in limits]
    return min(times, default=None)


def _fallen(history: History) -> float | None:
    """When the head passes the fallen line for good, between the samples about it."""
    heights = history.states[:, 2]
    line = history.scenario.drive.start[2] - FALLEN * history.heights.initial_gap
    if not heights[-1] < line:
        return None
    above = np.flatnonzero(heights >= line)
    if above.size == 0:
        return float(history.time[0])
    i = int(above[-1])
    share = (heights[i] - line) / (heights[i] - heights[i + 1])
    return float(history.time[i] + share * (history.time[i + 1] - history.time[i]))
