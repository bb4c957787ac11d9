"""Samples and statistics of turns that were leapt over, from the shapes of those that were followed."""

import warp as wp

from helimag.engine.leaps import Curve, next_turn, weights_at
from helimag.engine.moving import to_lab
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule, record_of, sample_time, statistics_from, statistics_with
from helimag.engine.turn_memory import (
    FINE,
    LOOKS,
    Memory,
    Weights,
    attacks_between,
    heights_between,
    state_between,
    with_roll,
)
from helimag.physics.kinematics import ArmMotion, State, attack_angle

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
TURN_PARTS = wp.constant(wp.float64(int(LOOKS)))


@wp.func
def turn_filled(
    memory: Memory,
    run: int,
    first: int,
    count: int,
    weights: Weights,
    drive: ArmMotion,
    schedule: Schedule,
    period: wp.float64,
    number: wp.float64,
    begin: State,
    end: State,
    before: Progress,
    records: wp.array2d(dtype=Record),
) -> Progress:
    """Progress after turn ``number`` from ``begin`` to ``end``, moving frame; samples due in it are recorded."""
    p = before
    start = p.leap.origin + number * period
    heights = heights_between(memory, run, first, count, weights)
    attacks = attacks_between(memory, run, first, count, weights)
    attack = attack_angle(begin)
    climb = attack_angle(end) - attack
    due = sample_time(schedule, p.sample)
    last = start
    for i in range(LOOKS):
        share = wp.float64(i + 1) / TURN_PARTS
        t = start + share * period
        while due <= t and p.sample < records.shape[1]:
            phase = (due - start) / period
            moving = state_between(memory, run, first, count, weights, phase, begin, end)
            state = to_lab(drive, due, with_roll(moving, p.leap.roll * (number + phase)))
            p.statistics = statistics_with(p.statistics, due - last, state[2], attack_angle(state))
            records[run, p.sample] = record_of(p.statistics, due, state, p.synchrony.slips)
            p.statistics = statistics_from(due, state)
            p.sample += 1
            last = due
            due = sample_time(schedule, p.sample)
        height = begin[2] + share * (end[2] - begin[2]) + heights[i]
        p.statistics.low = wp.min(p.statistics.low, height)
        p.statistics.high = wp.max(p.statistics.high, height)
        if (i + 1) % FINE == 0:
            angle = attack + share * climb + attacks[(i + 1) // FINE - 1]
            p.statistics = statistics_with(p.statistics, t - last, height, angle)
            last = t
    return p


@wp.func
def filled(
    memory: Memory,
    run: int,
    first: int,
    curve: Curve,
    drive: ArmMotion,
    schedule: Schedule,
    period: wp.float64,
    begin: State,
    before: Progress,
    records: wp.array2d(dtype=Record),
) -> Progress:
    """Progress after a leap from ``begin``, moving frame."""
    p = before
    y = begin
    jacobian = memory.jacobians[run]
    for j in range(p.leap.turns_aimed):
        number = p.leap.number + wp.float64(j)
        weights = weights_at(curve, number)
        following = next_turn(jacobian, curve, weights, y)
        p = turn_filled(
            memory, run, first, curve.count, weights, drive, schedule, period, number, y, following, p, records
        )
        y = following
    return p
