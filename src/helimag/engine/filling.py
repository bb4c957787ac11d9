"""Samples and statistics of turns that were leapt over, from the shapes of those that were followed."""

import math
from functools import cache

import warp as wp

from helimag.engine.abreast import Angles, Ways, build_parts_abreast, state_in
from helimag.engine.lanes import LANES
from helimag.engine.leaps import spin_at
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
    attacks_between,
    heights_between,
    node_between,
    slot_of,
    with_roll,
)
from helimag.engine.turns import NODES, build_part_turn, spin_at_node
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State, attack_angle
from helimag.physics.magnetics import FieldSource

ONE = wp.constant(wp.float64(1.0))
TURN_PARTS = wp.constant(wp.float64(int(LOOKS)))
COUNT = wp.constant(wp.float64(NODES))
TWO_PI = wp.constant(wp.float64(2.0 * math.pi))


@wp.struct
class Sample:
    """A sample within a leap: the node of a turn before it, and by which angle of the spin it is on; moving frame."""

    due: wp.float64  # s
    number: wp.float64  # of the turn
    begin: State
    spin: wp.vec2d  # cosine and sine, at the node
    angle: wp.float64


@wp.func
def sample_in_leap(
    drive: ArmMotion, schedule: Schedule, memory: Memory, run: int, first: int, count: int, p: Progress, sample: int
) -> Sample:
    """Where a sample is in the leap whose way is remembered."""
    at = Sample()
    period = TWO_PI / wp.abs(drive.spin_rate)
    at.due = sample_time(schedule, sample)
    turn = wp.clamp(int((at.due - p.leap.origin) / period - p.leap.number), 0, p.leap.turns_aimed - 1)
    at.number = p.leap.number + wp.float64(turn)
    phase = (at.due - p.leap.origin) / period - at.number
    node = wp.clamp(int(phase * COUNT), 0, NODES - 1)
    share = wp.float64(node) / COUNT
    at.begin = memory.places[run, slot_of(p.leap.pushes - 1)]
    if turn > 0:
        at.begin = memory.path[run, turn - 1]
    if node > 0:
        shape = node_between(
            memory, run, first, count, memory.weights[run, turn], node, at.begin, memory.path[run, turn]
        )
        at.begin = with_roll(shape, p.leap.roll * share)
    at.spin = spin_at_node(drive, spin_at(drive, p.leap.origin), node)
    at.angle = TWO_PI * (phase - share)
    return at


@wp.func
def seen_in_lab(drive: ArmMotion, due: wp.float64, roll: wp.float64, number: wp.float64, state: State) -> State:
    """The state at a sample that is due, moving frame and what rolled in turns before off, as the lab sees it."""
    return to_lab(drive, due, with_roll(state, roll * number))


@cache
def build_seen_one(system: System) -> wp.Function:
    """Make the function that works out and remembers a leap's next sample; it returns the number of the one after."""
    part_turn, around_type = build_part_turn(system), system.medium.surroundings_type

    @wp.func
    def seen_one(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        schedule: Schedule,
        memory: Memory,
        run: int,
        first: int,
        count: int,
        p: Progress,
    ) -> int:
        at = sample_in_leap(drive, schedule, memory, run, first, count, p, p.sample)
        state = part_turn(body, around, drive, magnets, at.spin, p.leap.fine, at.angle, at.begin)
        memory.seen[run, 0] = seen_in_lab(drive, at.due, p.leap.roll, at.number, state)
        return p.sample + 1

    return seen_one


@cache
def build_seen_in_lanes(system: System) -> wp.Function:
    """Make the function that does the same for as many samples of the leap as there are lanes."""
    parts_abreast, around_type = build_parts_abreast(system), system.medium.surroundings_type

    @wp.func
    def seen_in_lanes(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        schedule: Schedule,
        memory: Memory,
        run: int,
        first: int,
        count: int,
        p: Progress,
    ) -> int:
        ways = Ways()
        angles = Angles()
        dues = Angles()
        numbers = Angles()
        over = p.leap.origin + (p.leap.number + wp.float64(p.leap.turns_aimed)) * TWO_PI / wp.abs(drive.spin_rate)
        at = Sample()
        found = int(0)
        lanes = int(LANES)
        for lane in range(lanes):  # the last sample is in all lanes that are left
            if lane == 0 or (lane == found and sample_time(schedule, p.sample + lane) <= over):
                at = sample_in_leap(drive, schedule, memory, run, first, count, p, p.sample + lane)
                found = lane + 1
            dues[lane] = at.due
            numbers[lane] = at.number
            angles[lane] = at.angle
            for i in range(7):
                ways[lane, i] = at.begin[i]
                ways[lane, 7 + i] = at.begin[i]
            ways[lane, 14] = at.spin[0]
            ways[lane, 15] = at.spin[1]
        ways = parts_abreast(body, around, drive, magnets, p.leap.fine, found, angles, ways)
        for lane in range(found):
            end = state_in(ways, lane, 0)
            memory.seen[run, lane] = seen_in_lab(drive, dues[lane], p.leap.roll, numbers[lane], end)
        return p.sample + found

    return seen_in_lanes


@wp.struct
class Level:
    """Height (m) and attack angle (rad) through a turn but for its shape: where they begin, and how much they rise."""

    height: wp.float64
    rise: wp.float64
    attack: wp.float64
    climb: wp.float64


@wp.func
def level_of(drive: ArmMotion, start: wp.float64, period: wp.float64, begin: State, end: State) -> Level:
    """Level of a turn that begins at ``start`` (s), from states in the moving frame, which rises in the lab."""
    level = Level()
    level.height = begin[2] + start * drive.velocity[2]
    level.rise = end[2] - begin[2] + period * drive.velocity[2]
    level.attack = attack_angle(begin)
    level.climb = attack_angle(end) - level.attack
    return level


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
def build_filled(system: System, lanes: bool) -> wp.Function:
    """Make the function that records the samples due in a leap, whose way is remembered."""
    around_type = system.medium.surroundings_type
    seen = build_seen_in_lanes(system) if lanes else build_seen_one(system)

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
        p.leap.seen_to = 0
        period = TWO_PI / wp.abs(drive.spin_rate)
        state = memory.places[run, slot_of(before.leap.pushes - 1)]
        due = sample_time(schedule, p.sample)
        for j in range(p.leap.turns_aimed):
            start = p.leap.origin + (p.leap.number + wp.float64(j)) * period
            level = level_of(drive, start, period, state, memory.path[run, j])
            weights = memory.weights[run, j]
            heights = heights_between(memory, run, first, count, weights)
            attacks = attacks_between(memory, run, first, count, weights)
            left = heights[0] - heights[LOOKS - 1] + level.rise / TURN_PARTS
            last = start
            for i in range(LOOKS):
                share = wp.float64(i + 1) / TURN_PARTS
                t = start + share * period
                while due <= t and p.sample < records.shape[1]:
                    if p.sample >= p.leap.seen_to:
                        p.leap.seen_from = p.sample
                        p.leap.seen_to = seen(body, around, drive, magnets, schedule, memory, run, first, count, p)
                    p = sampled(p, run, due, due - last, memory.seen[run, p.sample - p.leap.seen_from], records)
                    last = due
                    due = sample_time(schedule, p.sample)
                height = level.height + share * level.rise + heights[i]
                right = heights[(i + 1) % LOOKS] - heights[i] + level.rise / TURN_PARTS  # the turn after is like this
                p.statistics = looked_at(p.statistics, height, left, right)
                left = right
                if (i + 1) % FINE == 0:
                    attack = level.attack + share * level.climb + attacks[(i + 1) // FINE - 1]
                    p.statistics = statistics_with(p.statistics, t - last, height, attack)
                    last = t
            state = memory.path[run, j]
        return p

    return filled
