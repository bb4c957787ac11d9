"""What a run leaves behind: states at sample times, and statistics of every step in between."""

import math
from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.structures import structs
from helimag.physics.kinematics import State, attack_angle
from helimag.scenario import Run, Scenario

ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
TWO = wp.constant(wp.float64(2.0))
THREE = wp.constant(wp.float64(3.0))
EIGHT = wp.constant(wp.float64(8.0))
NEARLY_ONE = wp.constant(wp.float64(1.0 - 2e-12))  # a sample this close to the end is the end, whatever rounding did


@wp.struct
class Schedule:
    """When one run is sampled: each ``interval`` from zero, and at ``duration``, its horizon (s)."""

    interval: wp.float64
    duration: wp.float64


def pack_schedules(scenarios: Sequence[Scenario]) -> NDArray[np.void]:
    """Sample times of each run as the kernels take them."""
    return structs(Schedule, [{"interval": s.run.sample_interval, "duration": s.run.duration} for s in scenarios])


def sample_times(run: Run) -> NDArray[np.float64]:
    """When a run that reaches its horizon is sampled (s)."""
    count = math.ceil(run.duration / run.sample_interval * (1.0 - 1e-12)) + 1
    times = np.arange(count) * run.sample_interval
    times[times >= float(NEARLY_ONE) * run.duration] = run.duration
    return times


@wp.func
def sample_time(schedule: Schedule, sample: int) -> wp.float64:
    """When sample number ``sample`` is due (s): the kernels' :func:`sample_times`."""
    time = wp.float64(sample) * schedule.interval
    if time >= NEARLY_ONE * schedule.duration:
        return schedule.duration
    return time


@wp.struct
class Statistics:
    """Running statistics between two samples: extremes of height, time integrals by the trapezoidal rule."""

    low: wp.float64
    high: wp.float64
    height: wp.float64
    attack: wp.float64
    square: wp.float64
    begin: wp.float64
    last_height: wp.float64
    last_attack: wp.float64


@wp.struct
class Record:
    """One sample; what it says of heights and attack angles is over the interval that it ends."""

    state: State
    slips: wp.int32  # turns slipped so far
    walls: wp.int32  # bits of the walls that pushed, by their numbers
    low: wp.float64  # lowest head, m
    high: wp.float64  # highest head, m
    height: wp.float64  # mean, m
    attack: wp.float64  # mean, rad
    square: wp.float64  # mean of the attack angle's square, rad^2


@wp.func
def statistics_from(t: wp.float64, state: State) -> Statistics:
    """Statistics of an interval that begins at ``t``."""
    stats = Statistics()
    stats.last_height = state[2]
    stats.last_attack = attack_angle(state)
    stats.low = state[2]
    stats.high = state[2]
    stats.begin = t
    return stats


@wp.func
def gone_from(before: Statistics, t: wp.float64) -> Statistics:
    """Statistics of an interval that begins at ``t``, where those of the one before have come to."""
    stats = Statistics()
    stats.last_height = before.last_height
    stats.last_attack = before.last_attack
    stats.low = before.last_height
    stats.high = before.last_height
    stats.begin = t
    return stats


@wp.func
def stretched(stats: Statistics, height: wp.float64) -> Statistics:
    """The statistics with a height (m) among the extremes; by comparisons, each one instruction, as minimum is not."""
    if height < stats.low:
        stats.low = height
    if height > stats.high:
        stats.high = height
    return stats


@wp.func
def statistics_with(stats: Statistics, dt: wp.float64, height: wp.float64, attack: wp.float64) -> Statistics:
    """The statistics with one more step in them, which ended at this height (m) and attack angle (rad)."""
    a = stats.last_attack
    stats = stretched(stats, height)
    stats.height += HALF * dt * (stats.last_height + height)
    stats.attack += HALF * dt * (a + attack)
    stats.square += HALF * dt * (a * a + attack * attack)
    stats.last_height = height
    stats.last_attack = attack
    return stats


@wp.func
def turned_within(
    stats: Statistics, before: wp.float64, rise_before: wp.float64, after: wp.float64, rise: wp.float64
) -> Statistics:
    """The statistics with the extreme between two heights (m), if there is one, where their cubic turns.

    A rise (m) is the rate at one of the two times the time between them: Hermite's data, and an error of fourth order.
    """
    if rise_before * rise >= ZERO:
        return stats
    square = THREE * (after - before) - TWO * rise_before - rise
    cube = rise_before + rise - TWO * (after - before)
    root = wp.sqrt(wp.max(square * square - THREE * rise_before * cube, ZERO))
    share = rise_before / (wp.sign(rise_before) * root - square)
    turn = before + share * (rise_before + share * (square + share * cube))
    return stretched(stats, turn)


@wp.func
def stepped_with(
    stats: Statistics, dt: wp.float64, climb_before: wp.float64, state: State, climb: wp.float64
) -> Statistics:
    """The statistics with one more step in them, at whose ends the head climbed at these speeds (m/s)."""
    turned = turned_within(stats, stats.last_height, dt * climb_before, state[2], dt * climb)
    return statistics_with(turned, dt, state[2], attack_angle(state))


@wp.func
def turning_at(height: wp.float64, left: wp.float64, right: wp.float64) -> wp.float64:
    """A height (m) that the head came to by a rise of ``left`` (m), as long before as it goes on by ``right``; or where
    the parabola through the three turns, if it does within half of that time.
    """
    if left * right >= ZERO:
        return height
    tilt = left + right
    return height - tilt * tilt / (EIGHT * (right - left))


@wp.func
def record_of(stats: Statistics, t: wp.float64, state: State, slips: int, walls: int) -> Record:
    """The sample that ends an interval at ``t``, which the statistics have come to."""
    record = Record()
    record.state = state
    record.slips = slips
    record.walls = walls
    record.low = stats.low
    record.high = stats.high
    record.height = stats.last_height
    record.attack = stats.last_attack
    record.square = record.attack * record.attack
    span = t - stats.begin
    if span > ZERO:
        record.height = stats.height / span
        record.attack = stats.attack / span
        record.square = stats.square / span
    return record
