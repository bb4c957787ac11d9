"""When a run leaps over turns of the magnet, how far, and what is remembered of it."""

import math
from functools import cache

import warp as wp

from helimag.engine.charts import Place, far_off, from_chart, to_chart
from helimag.engine.columns import build_columns
from helimag.engine.control import Control
from helimag.engine.events import Bounds, clearance
from helimag.engine.filling import build_filled
from helimag.engine.leaps import (
    BEGINNING,
    COLUMNS,
    CORRECTING,
    GUESSING,
    ORDER,
    Curve,
    ahead,
    curve_through,
    difference,
    doubted,
    largest,
    next_turn,
    remembered,
    top_of,
    weights_at,
)
from helimag.engine.medium import OPEN_WATER
from helimag.engine.moving import to_lab, to_moving
from helimag.engine.progress import Leap, Progress
from helimag.engine.samples import Record, Schedule
from helimag.engine.system import System, clear_of_walls
from helimag.engine.turn_memory import MOST_TURNS, SLOTS, Memory, after_turns, chart_turn, slot_of
from helimag.engine.turns import FINEST, LEAST_STEPS_TOLERANCE, Shape, Turn, steps_between_nodes
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State, normalized, rpm_pose
from helimag.physics.magnetics import FieldSource

IN_STEP = wp.constant(wp.float64(-0.5))  # least cosine of the phase lag for leaps
SHARE = wp.constant(wp.float64(0.3))  # of the tolerance, for a leap's error; benchmarks/random_runs.py
SAFETY = wp.constant(wp.float64(0.85))
GROWTH = wp.constant(wp.float64(1.5))
SHRINK = wp.constant(wp.float64(0.2))
LEAST_ERROR = wp.constant(wp.float64(1e-8))
MISSED = 0.05  # of the tolerance, for what steps of a turn may miss: it changes unseen
MISSED_NEAR_WALLS = 0.1  # there half of it would ask most runs for twice the steps; random_runs.py --walls
MOST_LEAP = wp.constant(MOST_TURNS)
OLD = wp.constant(30)  # leaps after which the Jacobian is worked out again
FIRST_LOOK = wp.constant(0)  # turn of a leap after which room is looked at
TRIAL = wp.constant(14)  # leaps after which they must be worth while
WORTH = wp.constant(2)  # turns that they must be long by then
RETRY = wp.constant(wp.float64(2.0))  # turns until the next try, after one that came to nothing; then twice as many
LONG_RETRY = wp.constant(wp.float64(32.0))
ROOM = wp.constant(wp.float64(3.0))  # times what a turn reaches, to be kept clear of anything that ends a run
LEAST_ROOM = wp.constant(wp.float64(1e-4))  # m
BEFORE_END = wp.constant(wp.float64(1.0 - 1e-9))  # of the duration: the last sample is a step's
FINE_TOLERANCE = wp.constant(wp.float64(LEAST_STEPS_TOLERANCE))
TWO_PI = wp.constant(wp.float64(2.0 * math.pi))
ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
EIGHTH = wp.constant(wp.float64(0.125))


@wp.func
def in_step(lag: wp.vec2d) -> bool:
    """Whether the moment is near enough to the field for leaps."""
    return lag[0] > IN_STEP * wp.length(lag)


@wp.func
def rolls_along(turn: Turn, roll: wp.float64, leap: Leap) -> bool:
    """Whether the device rolled once with the magnet in a turn, the same way as before, so that turns are alike.

    In step it need not: a field that swings across it, and does not go around it, takes it back again.
    """
    begin = normalized(leap.aim)
    turned = ZERO
    for i in range(3, 7):
        turned += begin[i] * turn.end[i]
    return turned > ZERO and (leap.stage == BEGINNING or roll == leap.roll)


@wp.func
def drift(drive: ArmMotion, y: State, tail: wp.float64) -> wp.float64:
    """Speed (m/s) at which the moving frame takes the device along, at most."""
    across = wp.sqrt(y[0] * y[0] + y[1] * y[1]) + tail
    return wp.length(drive.velocity) + wp.abs(drive.yaw_rate) * across


@wp.func
def given_up(p: Progress, turns: wp.float64, period: wp.float64) -> Progress:
    """Leaping ended for now, not to be tried for some turns."""
    after = p
    after.leap.stage = BEGINNING
    after.leap.fine = 0
    after.leap.ready = p.time + turns * period
    return after


@wp.func
def put_off(p: Progress, period: wp.float64) -> Progress:
    """Leaping ended for now: each time that nothing came of it in a row, for twice as long as the time before."""
    after = p
    after.leap.wait = wp.clamp(wp.float64(2.0) * p.leap.wait, RETRY, LONG_RETRY)
    return given_up(after, after.leap.wait, period)


@wp.func
def stride_after(stride: int, error: wp.float64, order: int) -> int:
    """Turns to leap next, for an error in units of the tolerance after ``stride`` turns."""
    factor = SAFETY * wp.pow(wp.max(error, LEAST_ERROR), -ONE / wp.float64(order))
    if error > ONE:
        return wp.max(1, wp.min(stride - 1, int(wp.float64(stride) * wp.max(factor, SHRINK))))
    wanted = wp.float64(stride) * wp.min(factor, GROWTH)
    if wanted > wp.float64(stride):
        return wp.min(MOST_LEAP, int(wanted + wp.float64(0.5)))
    return wp.max(1, wp.min(stride, int(wanted) + 1))


@wp.struct
class Way:
    """Where a leap leads."""

    end: Place
    error: Place
    room: wp.float64  # least distance to anything that ends the run, less what is to be kept, m


@wp.func
def way_of(
    memory: Memory,
    run: int,
    curve: Curve,
    drive: ArmMotion,
    magnets: wp.array(dtype=FieldSource),
    bounds: Bounds,
    leap: Leap,
    keep: wp.float64,
    begin: Place,
) -> Way:
    """Where the cheap map leads from ``begin``, what is doubtful about it, and how much room there is on the way.

    The way is remembered, turn by turn.
    """
    way = Way()
    way.end = begin
    way.room = ONE
    top = top_of(curve)
    jacobian = memory.jacobians[run]
    period = TWO_PI / wp.abs(drive.spin_rate)
    # no turn goes farther than a third of what is to be kept: where there is room, some need no look
    look = int(FIRST_LOOK)
    for j in range(leap.turns_aimed):
        at = leap.number + wp.float64(j)
        weights = weights_at(curve, at)
        way.end = next_turn(jacobian, curve, weights, way.end)
        way.error = doubted(jacobian, top, weights[curve.oldest], way.error)
        state = from_chart(leap.reference, way.end)
        memory.path[run, j] = state
        memory.weights[run, j] = weights
        if j >= look:
            t = leap.origin + (at + ONE) * period
            room = room_at(drive, magnets, bounds, t, to_lab(drive, t, state)) - keep
            way.room = wp.min(way.room, room)
            look = j + 1 + int(wp.clamp(room / keep, ZERO, wp.float64(MOST_LEAP)))
    return way


@wp.func
def begun(drive: ArmMotion, before: Progress) -> Progress:
    """Leaping begun where a run stands: the turn from there is to be followed."""
    p = before
    p.leap.origin = p.time
    p.leap.number = ZERO
    p.leap.aim_number = ZERO
    p.leap.stride = 1
    p.leap.pushes = 0
    p.leap.known = 0
    p.leap.aim = to_moving(drive, p.time, p.state)
    return p


@wp.func
def column_aimed(control: Control, memory: Memory, run: int, before: Progress) -> Progress:
    """A turn to be followed beside the last one, for a column of the Jacobian."""
    p = before
    beside = to_chart(p.leap.reference, memory.places[run, slot_of(p.leap.pushes - 1)])
    if p.leap.column < 6:
        beside[p.leap.column] += difference(control, p.leap.column)
    p.leap.aim = from_chart(p.leap.reference, beside)
    return p


@wp.func
def guessed(schedule: Schedule, memory: Memory, run: int, period: wp.float64, before: Progress) -> Progress:
    """A leap begun: a guess where it leads, from where the turn is to be followed; given up where the run is over."""
    p = before
    rest = (schedule.duration * BEFORE_END - p.time) / period
    turns = wp.min(p.leap.stride, int(wp.min(rest, wp.float64(MOST_LEAP))))
    if turns < 1:
        p.leap.stage = BEGINNING
        p.leap.ready = schedule.duration + period
    else:
        known = wp.min(p.leap.known, ORDER)
        reference = p.leap.reference
        curve = curve_through(memory, run, p.leap.pushes - known, known)
        y = memory.begins[run, slot_of(p.leap.pushes - 1)]
        p.leap.turns_aimed = turns
        p.leap.aim_number = p.leap.number + wp.float64(turns)
        p.leap.aim = from_chart(reference, ahead(memory.jacobians[run], curve, p.leap.number, turns, y))
    return p


@wp.func
def room_at(
    drive: ArmMotion, magnets: wp.array(dtype=FieldSource), bounds: Bounds, t: wp.float64, state: State
) -> wp.float64:
    """Distance (m) to anything that ends the run, or to where walls that hold begin to act."""
    least, kind = clearance(bounds, magnets, rpm_pose(drive, t), state)
    return least - bounds.pull_reach


@wp.func
def room_needed(turn: Turn, drive: ArmMotion, bounds: Bounds, period: wp.float64, begin: State) -> wp.float64:
    """How much of it a turn like this one needs (m)."""
    return wp.max(ROOM * (turn.reach + period * drift(drive, begin, bounds.tail)), LEAST_ROOM)


@wp.func
def first_followed(
    turn: Turn,
    roll: wp.float64,
    drive: ArmMotion,
    magnets: wp.array(dtype=FieldSource),
    bounds: Bounds,
    period: wp.float64,
    before: Progress,
) -> Progress:
    """Progress after the turn from where leaping began."""
    p = before
    p.leap.roll = roll
    p.leap.pushes = 1
    p.leap.known = 1
    p.leap.stage = COLUMNS
    p.leap.column = 0
    p.leap.reference = p.leap.aim
    if not turn.cosine > IN_STEP or room_at(drive, magnets, bounds, p.time, p.state) < room_needed(
        turn, drive, bounds, period, p.leap.aim
    ):
        p = put_off(p, period)
    return p


@wp.func
def miss_followed(
    miss: Place, bearable: wp.float64, control: Control, period: wp.float64, before: Progress
) -> Progress:
    """Progress after a turn in twice as many steps: leaps begin; or again, with finer steps, where that misses much.

    ``bearable``: share of the tolerance.
    """
    p = before
    p.leap.miss = miss
    p.leap.stage = GUESSING
    p.leap.age = 0
    lasting = miss
    lasting[5] = ZERO  # a turn that begins with another roll ends with the same
    ratio = largest(lasting, control) / (bearable * control.tolerance)
    if ratio > ONE:
        needed = int(wp.ceil(wp.float64(p.leap.fine) * wp.pow(ratio, EIGHTH)))
        p = given_up(p, wp.where(needed > FINEST, LONG_RETRY, ZERO), period)
        p.leap.fine = wp.where(needed > FINEST, 0, needed)
    return p


@wp.func
def column_followed(
    turn: Turn,
    bearable: wp.float64,
    control: Control,
    memory: Memory,
    run: int,
    period: wp.float64,
    before: Progress,
) -> Progress:
    """Progress after a turn for the Jacobian."""
    p = before
    now = slot_of(p.leap.pushes - 1)
    change = to_chart(p.leap.reference, turn.end) - to_chart(p.leap.reference, memory.ends[run, now])
    if p.leap.column == 6:
        p = miss_followed(change, bearable, control, period, p)
        for i in range(wp.min(p.leap.known, SLOTS)):
            chart_turn(memory, run, slot_of(p.leap.pushes - 1 - i), p.leap.reference, p.leap.miss)
    else:
        slope = change / difference(control, p.leap.column)
        jacobian = memory.jacobians[run]
        for i in range(6):
            jacobian[i, p.leap.column] = slope[i]
        jacobian[p.leap.column, p.leap.column] -= ONE
        memory.jacobians[run] = jacobian
        p.leap.column += 1
    return p


@wp.func
def guess_followed(
    turn: Turn,
    drive: ArmMotion,
    magnets: wp.array(dtype=FieldSource),
    control: Control,
    bounds: Bounds,
    memory: Memory,
    run: int,
    period: wp.float64,
    before: Progress,
) -> Progress:
    """Progress after the turn from where a leap was guessed to lead: where it leads with that known, if it is good."""
    p = before
    known = wp.min(p.leap.known, ORDER)
    turns = p.leap.turns_aimed
    curve = curve_through(memory, run, p.leap.pushes - known, known + 1)
    now = slot_of(p.leap.pushes - 1)
    keep = room_needed(turn, drive, bounds, period, memory.places[run, now])
    way = way_of(memory, run, curve, drive, magnets, bounds, p.leap, keep, memory.begins[run, now])
    # a polynomial through few turns says less of what lies between them than its end tells
    few = wp.float64(known + 1) / wp.float64(ORDER + 1)
    p.leap.error = largest(way.error, control) / (SHARE * few * few * control.tolerance)
    near = p.leap.error <= ONE or turns == 1  # one turn was followed from where it begins
    if near and turn.cosine > IN_STEP and way.room > ZERO:
        p.leap.stage = CORRECTING
        p.leap.aim = from_chart(p.leap.reference, way.end)
    elif turns == 1:
        p = put_off(p, period)
    elif near:
        p.leap.stride = wp.max(1, turns // 4)
    else:
        p.leap.stride = stride_after(turns, p.leap.error, known + 1)
    return p


@cache
def build_leapt(system: System, lanes: bool) -> wp.Function:
    """Make the function that takes a run over a leap, once the turn from where that led was followed."""
    filled, around_type = build_filled(system, lanes), system.medium.surroundings_type

    @wp.func
    def leapt(
        turn: Turn,
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        schedule: Schedule,
        memory: Memory,
        run: int,
        before: Progress,
        records: wp.array2d(dtype=Record),
    ) -> Progress:
        period = TWO_PI / wp.abs(drive.spin_rate)
        known = wp.min(before.leap.known, ORDER)
        sample, stats, walls = filled(
            body, around, drive, magnets, schedule, memory, run, before.leap, before.sample, before.statistics,
            before.synchrony.slips, before.touches.lately, records
        )  # fmt: skip
        p = before
        p.sample = sample
        p.statistics = stats
        p.touches.lately = walls
        p.leap.number = p.leap.aim_number
        p.leap.pushes += 1
        p.leap.known += 1
        p.leap.age += 1
        p.leap.turns += wp.int64(p.leap.turns_aimed)
        p.leap.stride = stride_after(p.leap.turns_aimed, p.leap.error, known + 1)
        p.time = p.leap.origin + p.leap.number * period
        p.state = to_lab(drive, p.time, after_turns(p.leap.aim, p.leap.number))
        p.middle = p.state
        p.synchrony.lag = turn.lag
        if turn.lag[0] > ZERO:
            p.synchrony.locked = 1
        p.leap.stage = GUESSING
        if p.leap.age >= OLD or far_off(to_chart(p.leap.reference, p.leap.aim)):
            p.leap.stage = COLUMNS
            p.leap.column = 0
            p.leap.reference = p.leap.aim
        if p.leap.known > TRIAL:
            p.leap.wait = ZERO
            if p.leap.stride < WORTH:
                p = given_up(p, LONG_RETRY, period)
        return p

    return leapt


@wp.func
def ready_with(ready: wp.float64, spin_rate: wp.float64, t: wp.float64, lag: wp.vec2d) -> wp.float64:
    """When leaps may begin (s), with a step to ``t`` behind: not before the device has been in step for a turn."""
    return wp.where(in_step(lag), ready, wp.max(ready, t + TWO_PI / wp.abs(spin_rate)))


@wp.func
def steps_for(
    body: Swimmer, drive: ArmMotion, magnets: wp.array(dtype=FieldSource), control: Control, bounds: Bounds, aim: State
) -> int:
    """Steps between two nodes that the turn from ``aim`` needs."""
    least = int(wp.ceil(wp.pow(FINE_TOLERANCE / control.tolerance, EIGHTH)))
    return steps_between_nodes(body, drive, magnets, bounds.contact, least, aim)


@wp.func
def asked(
    body: Swimmer,
    drive: ArmMotion,
    magnets: wp.array(dtype=FieldSource),
    control: Control,
    bounds: Bounds,
    schedule: Schedule,
    memory: Memory,
    run: int,
    before: Progress,
):
    """The turn that is to be followed next for leaping: progress that aims at it, and steps between two nodes of it.

    No steps where none is to be followed now.
    """
    p = before
    period = TWO_PI / wp.abs(drive.spin_rate)
    if p.leap.stage == BEGINNING:
        if room_at(drive, magnets, bounds, p.time, p.state) < LEAST_ROOM:
            return put_off(p, period), 0
        p = begun(drive, p)
    elif p.leap.stage == COLUMNS:
        p = column_aimed(control, memory, run, p)
    elif p.leap.stage == GUESSING:
        p = guessed(schedule, memory, run, period, p)
        if p.leap.stage == BEGINNING:
            return p, 0
    needed = steps_for(body, drive, magnets, control, bounds, p.leap.aim)
    if needed > FINEST:
        return given_up(p, LONG_RETRY, period), 0
    if p.leap.stage != BEGINNING and needed > p.leap.fine:
        p = given_up(p, ZERO, period)  # to begin again with finer steps
        p.leap.fine = needed
        return p, 0
    p.leap.fine = wp.max(p.leap.fine, needed)
    fine = p.leap.fine
    if p.leap.stage == COLUMNS and p.leap.column == 6:
        fine *= 2
    return p, fine


@cache
def build_answered(system: System, lanes: bool) -> wp.Function:
    """Make the function that does with a turn that a run asked for what comes next; with lanes for samples."""
    clear, beyond, columns_type = clear_of_walls(system), system.medium.beyond, build_columns(system)
    leapt = build_leapt(clear, lanes)
    bearable = wp.constant(wp.float64(MISSED if clear.medium == OPEN_WATER else MISSED_NEAR_WALLS))

    @wp.func
    def answered(runs: columns_type, run: int, followed: Turn, shape: Shape, roll: wp.float64):
        p = runs.progress[run]
        turn = followed
        drive, rpm, control, bound = runs.drives[run], runs.magnets[run], runs.controls[run], runs.bounds[run]
        period = TWO_PI / wp.abs(drive.spin_rate)
        remembered(runs.memory, run, p.leap, turn.end, shape)
        p.leap.followed += wp.int64(1)
        if not rolls_along(turn, roll, p.leap):
            turn.cosine = -ONE
        if p.leap.stage == BEGINNING:
            p = first_followed(turn, roll, drive, rpm, bound, period, p)
        elif p.leap.stage == COLUMNS:
            p = column_followed(turn, bearable, control, runs.memory, run, period, p)
        elif p.leap.stage == GUESSING:
            p = guess_followed(turn, drive, rpm, control, bound, runs.memory, run, period, p)
        elif turn.cosine > IN_STEP:
            body, around, schedule = runs.bodies[run], beyond(runs.surroundings[run]), runs.schedules[run]
            p = leapt(turn, body, around, drive, rpm, schedule, runs.memory, run, p, runs.records)
        else:
            p = put_off(p, period)
        runs.progress[run] = p

    return answered
