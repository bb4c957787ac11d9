"""Samples and statistics of turns that were leapt over, from the shapes of those that were followed."""

import math
from functools import cache

import warp as wp

from helimag.engine.abreast import Angles, Ways, build_parts_abreast, state_in
from helimag.engine.lanes import LANES
from helimag.engine.leaps import spin_at
from helimag.engine.moving import to_lab
from helimag.engine.progress import Leap
from helimag.engine.samples import (
    Record,
    Schedule,
    Statistics,
    gone_from,
    record_of,
    sample_time,
    statistics_with,
    turning_at,
)
from helimag.engine.system import System
from helimag.engine.turn_memory import (
    FINE,
    LOOKS,
    Heights,
    Memory,
    after_turns,
    attacks_between,
    heights_between,
    node_between,
    slot_of,
)
from helimag.engine.turns import NODES, Nodes, build_part_turn, rolled_to_node, spin_at_node
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State, attack_angle
from helimag.physics.magnetics import FieldSource

HALF = wp.constant(wp.float64(0.5))
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
    drive: ArmMotion, spin: wp.vec2d, schedule: Schedule, memory: Memory, run: int, leap: Leap, sample: int
) -> Sample:
    """Where a sample is in the leap whose way is remembered; ``spin``: of the magnet where turns begin."""
    at = Sample()
    period = TWO_PI / wp.abs(drive.spin_rate)
    at.due = sample_time(schedule, sample)
    turn = wp.clamp(int((at.due - leap.origin) / period - leap.number), 0, leap.turns_aimed - 1)
    at.number = leap.number + wp.float64(turn)
    phase = (at.due - leap.origin) / period - at.number
    node = wp.clamp(int(phase * COUNT), 0, NODES - 1)
    at.begin = memory.places[run, slot_of(leap.pushes - 1)]
    if turn > 0:
        at.begin = memory.path[run, turn - 1]
    if node > 0:
        shape = node_between(memory, run, memory.weights[run, turn], node, at.begin, memory.path[run, turn])
        at.begin = rolled_to_node(shape, leap.roll, node)
    at.spin = spin_at_node(drive, spin, node)
    at.angle = TWO_PI * (phase - wp.float64(node) / COUNT)
    return at


@wp.func
def seen_in_lab(drive: ArmMotion, due: wp.float64, number: wp.float64, state: State) -> State:
    """The state at a sample that is due, moving frame and what rolled in turns before off, as the lab sees it."""
    return to_lab(drive, due, after_turns(state, number))


@cache
def build_seen_one(system: System) -> wp.Function:
    """Make the function that works out and remembers a sample of a leap; it returns the number of the one after."""
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
        leap: Leap,
        sample: int,
    ) -> int:
        at = sample_in_leap(drive, spin_at(drive, leap.origin), schedule, memory, run, leap, sample)
        state = part_turn(body, around, drive, magnets, at.spin, leap.fine, at.angle, at.begin)
        memory.seen[run, 0] = seen_in_lab(drive, at.due, at.number, state)
        return sample + 1

    return seen_one


@cache
def build_seen_in_lanes(system: System) -> wp.Function:
    """Make the function that does the same for as many samples, from this one on, as there are lanes."""
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
        leap: Leap,
        sample: int,
    ) -> int:
        ways = Ways()
        angles = Angles()
        dues = Angles()
        numbers = Angles()
        spin = spin_at(drive, leap.origin)
        over = leap.origin + (leap.number + wp.float64(leap.turns_aimed)) * TWO_PI / wp.abs(drive.spin_rate)
        at = Sample()
        found = int(0)
        lanes = int(LANES)
        for lane in range(lanes):  # the last sample is in all lanes that are left
            if lane == 0 or (lane == found and sample_time(schedule, sample + lane) <= over):
                at = sample_in_leap(drive, spin, schedule, memory, run, leap, sample + lane)
                found = lane + 1
            dues[lane] = at.due
            numbers[lane] = at.number
            angles[lane] = at.angle
            for i in range(7):
                ways[lane, i] = at.begin[i]
                ways[lane, 7 + i] = at.begin[i]
            ways[lane, 14] = at.spin[0]
            ways[lane, 15] = at.spin[1]
        ways = parts_abreast(body, around, drive, magnets, leap.fine, found, angles, ways)
        for lane in range(found):
            end = state_in(ways, lane, 0)
            memory.seen[run, lane] = seen_in_lab(drive, dues[lane], numbers[lane], end)
        return sample + found

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
def lower(a: wp.float64, b: wp.float64) -> wp.float64:
    """The lower of two heights; by a comparison, one instruction, as minimum is not."""
    return wp.where(b < a, b, a)


@wp.func
def looked_through(
    before: Statistics,
    level: Level,
    heights: Heights,
    attacks: Nodes,
    start: wp.float64,
    period: wp.float64,
    first: int,
    end: int,
    begin: wp.float64,
):
    """The statistics with some looks at a turn in them, and the last node's time (s): ``begin`` before the first look.

    With numbers of its own for what the loop changes, which stay in registers.
    """
    low = before.low
    high = before.high
    height = before.height
    attack = before.attack
    square = before.square
    old_height = before.last_height
    old_attack = before.last_attack
    last = begin
    rise = level.rise / TURN_PARTS
    here = heights[first % LOOKS]
    left = here - heights[(first + LOOKS - 1) % LOOKS] + rise
    for look in range(first, end):
        there = heights[(look + 1) % LOOKS]  # the turn after is like this
        right = there - here + rise
        share = wp.float64(look + 1) / TURN_PARTS
        at = level.height + share * level.rise + here
        turn = turning_at(at, left, right)
        here = there
        left = right
        low = lower(lower(low, at), turn)
        high = -lower(lower(-high, -at), -turn)
        if (look + 1) % FINE == 0:
            t = start + share * period
            angle = level.attack + share * level.climb + attacks[look // FINE]
            half = HALF * (t - last)
            height += half * (old_height + at)
            attack += half * (old_attack + angle)
            square += half * (old_attack * old_attack + angle * angle)
            old_height = at
            old_attack = angle
            last = t
    return Statistics(low, high, height, attack, square, before.begin, old_height, old_attack), last


@cache
def build_filled(system: System, lanes: bool) -> wp.Function:
    """Make the function that records the samples due in a leap, whose way is remembered; no wall pushes during one.

    It takes what the run is, its leap, the next sample, its statistics, slips, and walls that pushed since the last
    sample; and returns the next sample, statistics, and walls since the last sample then.
    """
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
        leap: Leap,
        next_sample: int,
        statistics: Statistics,
        slips: int,
        pushed: int,
        records: wp.array2d(dtype=Record),
    ):
        sample = next_sample
        stats = statistics
        walls = pushed
        seen_from = int(0)  # number of the first sample that is remembered of the leap, and the first after these
        seen_to = int(0)
        period = TWO_PI / wp.abs(drive.spin_rate)
        state = memory.places[run, slot_of(leap.pushes - 1)]
        due = sample_time(schedule, sample)
        for j in range(leap.turns_aimed):
            start = leap.origin + (leap.number + wp.float64(j)) * period
            end = memory.path[run, j]
            level = level_of(drive, start, period, state, end)
            weights = memory.weights[run, j]
            heights = heights_between(memory, run, weights)
            attacks = attacks_between(memory, run, weights)
            last = start
            look = int(0)
            while due <= start + period and sample < records.shape[1]:
                before = wp.clamp(int(wp.ceil((due - start) / period * TURN_PARTS)) - 1, look, LOOKS)
                stats, last = looked_through(stats, level, heights, attacks, start, period, look, before, last)
                look = before
                if sample >= seen_to:
                    seen_from = sample
                    seen_to = seen(body, around, drive, magnets, schedule, memory, run, leap, sample)
                there = memory.seen[run, sample - seen_from]
                stats = statistics_with(stats, due - last, there[2], attack_angle(there))
                records[run, sample] = record_of(stats, due, there, slips, walls)
                stats = gone_from(stats, due)
                walls = int(0)
                sample += 1
                last = due
                due = sample_time(schedule, sample)
            stats, last = looked_through(stats, level, heights, attacks, start, period, look, LOOKS, last)
            state = end
        return sample, stats, walls

    return filled
