"""Samples and statistics of turns that were leapt over, from the shapes of those that were followed."""

import math
from functools import cache

import warp as wp

from helimag.engine.charts import from_chart
from helimag.engine.moving import to_lab
from helimag.engine.progress import Progress
from helimag.engine.samples import (
    Record,
    Schedule,
    looked_at,
    record_of,
    sample_time,
    statistics_from,
    statistics_with,
)
from helimag.engine.system import System
from helimag.engine.turn_memory import (
    FINE,
    LOOKS,
    Memory,
    Weights,
    attacks_between,
    heights_between,
    node_between,
    slot_of,
    with_roll,
)
from helimag.engine.turns import NODES, build_part_turn
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State, attack_angle
from helimag.physics.magnetics import FieldSource

ONE = wp.constant(wp.float64(1.0))
TURN_PARTS = wp.constant(wp.float64(int(LOOKS)))
COUNT = wp.constant(wp.float64(NODES))
TWO_PI = wp.constant(wp.float64(2.0 * math.pi))


@cache
def build_state_between(system: System) -> wp.Function:
    """Make the function that gives the state at a share ``phase`` of a turn, moving frame: from the node before it."""
    part_turn, around_type = build_part_turn(system), system.medium.surroundings_type

    @wp.func
    def state_between(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        memory: Memory,
        run: int,
        first: int,
        count: int,
        weights: Weights,
        p: Progress,
        phase: wp.float64,
        begin: State,
        end: State,
    ) -> State:
        node = wp.clamp(int(phase * COUNT), 0, NODES - 1)
        share = wp.float64(node) / COUNT
        state = begin
        if node > 0:
            state = with_roll(node_between(memory, run, first, count, weights, node, begin, end), p.leap.roll * share)
        angle = drive.spin_rate * p.leap.origin
        spin = wp.vec2d(wp.cos(angle), wp.sin(angle))
        return part_turn(body, around, drive, magnets, spin, node, p.leap.fine, TWO_PI * (phase - share), state)

    return state_between


@wp.func
def sampled(
    before: Progress, run: int, due: wp.float64, dt: wp.float64, state: State, records: wp.array2d(dtype=Record)
) -> Progress:
    """The progress once the sample that is due ``dt`` (s) on is recorded; no wall pushes during a leap."""
    p = before
    p.statistics = statistics_with(p.statistics, dt, state[2], attack_angle(state))
    records[run, p.sample] = record_of(p.statistics, due, state, p.synchrony.slips, p.touches.lately)
    p.statistics = statistics_from(due, state)
    p.touches.lately = wp.int32(0)
    p.sample += 1
    return p


@cache
def build_turn_filled(system: System) -> wp.Function:
    """Make the function that records the samples due in a turn from ``begin`` to ``end``, moving frame."""
    state_between, around_type = build_state_between(system), system.medium.surroundings_type

    @wp.func
    def turn_filled(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        schedule: Schedule,
        memory: Memory,
        run: int,
        first: int,
        count: int,
        weights: Weights,
        number: wp.float64,
        begin: State,
        end: State,
        before: Progress,
        records: wp.array2d(dtype=Record),
    ) -> Progress:
        p = before
        period = TWO_PI / wp.abs(drive.spin_rate)
        start = p.leap.origin + number * period
        heights = heights_between(memory, run, first, count, weights)
        attacks = attacks_between(memory, run, first, count, weights)
        attack, climb = attack_angle(begin), attack_angle(end) - attack_angle(begin)
        bottom = begin[2] + start * drive.velocity[2]
        rise = end[2] - begin[2] + period * drive.velocity[2]  # in the lab: the moving frame rises
        left = heights[0] - heights[LOOKS - 1] + rise / TURN_PARTS
        due = sample_time(schedule, p.sample)
        last = start
        for i in range(LOOKS):
            share = wp.float64(i + 1) / TURN_PARTS
            t = start + share * period
            while due <= t and p.sample < records.shape[1]:
                phase = (due - start) / period
                moving = state_between(
                    body, around, drive, magnets, memory, run, first, count, weights, p, phase, begin, end
                )
                state = to_lab(drive, due, with_roll(moving, p.leap.roll * number))
                p = sampled(p, run, due, due - last, state, records)
                last = due
                due = sample_time(schedule, p.sample)
            height = bottom + share * rise + heights[i]
            right = heights[(i + 1) % LOOKS] - heights[i] + rise / TURN_PARTS  # the turn after is like this one
            p.statistics = looked_at(p.statistics, height, left, right)
            left = right
            if (i + 1) % FINE == 0:
                angle = attack + share * climb + attacks[(i + 1) // FINE - 1]
                p.statistics = statistics_with(p.statistics, t - last, height, angle)
                last = t
        return p

    return turn_filled


@cache
def build_filled(system: System) -> wp.Function:
    """Make the function that records the samples due in a leap, whose way is remembered."""
    turn_filled, around_type = build_turn_filled(system), system.medium.surroundings_type

    @wp.func
    def filled(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        schedule: Schedule,
        memory: Memory,
        run: int,
        first: int,
        count: int,
        before: Progress,
        records: wp.array2d(dtype=Record),
    ) -> Progress:
        p = before
        reference = before.leap.reference
        state = memory.places[run, slot_of(before.leap.pushes - 1)]
        for j in range(p.leap.turns_aimed):
            following = from_chart(reference, memory.path[run, j])
            p = turn_filled(
                body,
                around,
                drive,
                magnets,
                schedule,
                memory,
                run,
                first,
                count,
                memory.weights[run, j],
                p.leap.number + wp.float64(j),
                state,
                following,
                p,
                records,
            )
            state = following
        return p

    return filled
