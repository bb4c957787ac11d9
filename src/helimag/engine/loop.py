"""The time loop: DOP853 with error control, events and running statistics, one Warp thread a run.

Each run advances on its own clock from sample to sample. A launch takes a batch through a few samples only and leaves
in ``Progress`` all that is needed to go on, so that the host can report, be interrupted, and continue.

The magnet model and the kind of path are chosen when a kernel is built, not by branches in the loop: see
:func:`build_advance`.
"""

from collections.abc import Callable
from enum import IntEnum
from functools import cache
from typing import Any

import warp as wp

from helimag.engine.step import GROW, Clock, build_load, build_rates, build_trial, rescaled
from helimag.physics.balance import Body, balance_rates, moment_of
from helimag.physics.kinematics import (
    RpmPose,
    State,
    attack_angle,
    head_position,
    rotation_matrix,
)
from helimag.physics.magnetics import Magnet, phased_axis

ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
SHORTEST = wp.constant(wp.float64(1e-9))  # s; needing a shorter step means that the numbers are broken
EVENT_TIME = wp.constant(wp.float64(1e-6))  # s; events are located to this
NEARLY_ONE = wp.constant(wp.float64(1.0 - 2e-12))  # a sample this close to the end is the end, whatever rounding did


class Status(IntEnum):
    """How a run stands."""

    RUNNING = 0
    HORIZON = 1
    CONTACT = 2
    FALL = 3
    FLOOR = 4
    SURFACE = 5
    WALL = 6
    NOT_FINITE = 7


RUNNING, HORIZON, CONTACT, FALL, FLOOR, SURFACE, WALL, NOT_FINITE = (wp.constant(int(s)) for s in Status)

# Written at each sample: state (7), turns slipped so far; then, over the interval that ends there, lowest and highest
# head and the time means of height, attack angle and its square.
Record = wp.types.vector(length=13, dtype=wp.float64)


@wp.struct
class Bounds:
    """Where a run ends, lab frame, m; infinite where nothing is there."""

    contact: wp.float64  # between the centres of head and magnet
    fall: wp.float64  # height of the head
    low: wp.vec3d
    high: wp.vec3d
    tail: wp.float64  # from the head's centre back to the end of the helix
    head_radius: wp.float64
    tail_radius: wp.float64


@wp.struct
class Progress:
    """Where one run stands between launches.

    A slip is a passage of the field behind the moment after one in front of it.
    """

    time: wp.float64
    step: wp.float64
    state: State
    status: wp.int32
    slips: wp.int32
    locked: wp.int32  # whether the moment has been within a quarter turn of the field since the last slip
    lag: wp.vec2d
    steps: wp.int32
    rejected: wp.int32


@wp.struct
class Interval:
    """Running statistics between two samples: extremes of height, time integrals by the trapezoidal rule."""

    low: wp.float64
    high: wp.float64
    height: wp.float64
    attack: wp.float64
    square: wp.float64
    begin: wp.float64
    last_attack: wp.float64


@wp.func
def interval_from(t: wp.float64, state: State) -> Interval:
    stats = Interval()
    stats.last_attack = attack_angle(state)
    stats.low = state[2]
    stats.high = state[2]
    stats.begin = t
    return stats


@wp.func
def interval_with(stats: Interval, dt: wp.float64, old: State, new: State) -> Interval:
    """The statistics with one more step in them."""
    a = stats.last_attack
    b = attack_angle(new)
    stats.last_attack = b
    stats.low = wp.min(stats.low, new[2])
    stats.high = wp.max(stats.high, new[2])
    stats.height += HALF * dt * (old[2] + new[2])
    stats.attack += HALF * dt * (a + b)
    stats.square += HALF * dt * (a * a + b * b)
    return stats


@wp.func
def record_of(stats: Interval, t: wp.float64, state: State, slips: int) -> Record:
    height = state[2]
    attack = attack_angle(state)
    square = attack * attack
    span = t - stats.begin
    if span > ZERO:
        height = stats.height / span
        attack = stats.attack / span
        square = stats.square / span
    return Record(
        state[0],
        state[1],
        state[2],
        state[3],
        state[4],
        state[5],
        state[6],
        wp.float64(slips),
        stats.low,
        stats.high,
        height,
        attack,
        square,
    )


@wp.func
def lag_vector(field: wp.vec3d, state: State) -> wp.vec2d:
    """Field across the long axis (T), along the moment and a quarter turn ahead: its angle is the phase lag."""
    body_field = wp.transpose(rotation_matrix(state)) * field
    return wp.vec2d(body_field[1], body_field[2])


@wp.func
def passed_behind(old: wp.vec2d, new: wp.vec2d) -> bool:
    """Whether the field went through the direction opposite to the moment between two lag vectors."""
    return old[0] < ZERO and new[0] < ZERO and old[1] * new[1] <= ZERO


@wp.func
def clearance(bounds: Bounds, magnets: wp.array(dtype=Magnet), pose: RpmPose, state: State):
    """Least distance (m) to anything that ends the run, and which status that would be."""
    head = head_position(state)
    rotation = rotation_matrix(state)
    tail = head - bounds.tail * wp.vec3d(rotation[0, 0], rotation[1, 0], rotation[2, 0])
    least = head[2] - bounds.fall
    kind = int(FALL)
    for j in range(magnets.shape[0]):
        gap = wp.length(head - pose.position - pose.rotation * magnets[j].offset) - bounds.contact
        if gap < least:
            least = gap
            kind = int(CONTACT)
    for i in range(3):
        below = wp.min(head[i] - bounds.head_radius, tail[i] - bounds.tail_radius) - bounds.low[i]
        above = bounds.high[i] - wp.max(head[i] + bounds.head_radius, tail[i] + bounds.tail_radius)
        if below < least:
            least = below
            kind = int(WALL)
            if i == 2:
                kind = int(FLOOR)
        if above < least:
            least = above
            kind = int(WALL)
            if i == 2:
                kind = int(SURFACE)
    return least, kind


def build_to_sample(magnet_model: Callable[..., Any], pose_model: wp.Function) -> wp.Function:
    """Make the function that steps one run to its next sample, or to the event that ends it."""
    load = build_load(magnet_model)
    drive_type = pose_model.input_types["drive"]
    rates = build_rates(load, pose_model)
    trial = build_trial(rates)

    @wp.func
    def to_sample(
        body: Body,
        drive: drive_type,
        magnets: wp.array(dtype=Magnet),
        clock: Clock,
        bounds: Bounds,
        end: wp.float64,
        p: Progress,
    ):
        stats = interval_from(p.time, p.state)
        k0 = rates(body, drive, magnets, p.time, p.state)
        while p.time < end and p.status == RUNNING:
            # equal steps to the sample, so that landing on it never costs a tiny one
            count = wp.ceil((end - p.time) / wp.min(p.step, clock.longest))
            dt = (end - p.time) / count
            new, error = trial(body, drive, magnets, clock, p.time, dt, p.state, k0)
            if error <= ONE:
                t = p.time + dt
                if count == ONE:
                    t = end
                pose = pose_model(drive, t)
                least, kind = clearance(bounds, magnets, pose, new)
                if least < ZERO and dt > EVENT_TIME:
                    p.step = HALF * dt
                else:
                    if least < ZERO:
                        p.status = kind
                    field, force = load(magnets, pose, head_position(new), moment_of(body, new))
                    lag = lag_vector(field, new)
                    if lag[0] > ZERO:
                        p.locked = 1
                    if p.locked == 1 and passed_behind(p.lag, lag):
                        p.slips += 1
                        p.locked = 0
                    p.lag = lag
                    stats = interval_with(stats, dt, p.state, new)
                    p.step = wp.min(rescaled(dt, error), GROW * p.step)
                    p.time = t
                    p.state = new
                    p.steps += 1
                    k0 = balance_rates(body, new, force, field)
            else:
                p.step = wp.min(rescaled(dt, error), HALF * dt)
                p.rejected += 1
                if p.step < SHORTEST:
                    p.status = NOT_FINITE
        return p, record_of(stats, p.time, p.state, p.slips)

    return to_sample


@cache
def build_advance(magnet_model: Callable[..., Any], pose_model: wp.Function) -> wp.Kernel:
    """Make the kernel that takes a batch of runs from sample ``first`` up to, not with, sample ``last``.

    ``magnet_model(magnet, r, axis, m)`` returns field (T) and force (N) of one magnet at ``r`` (m) from it, its moment
    along the unit vector ``axis``, on the moment ``m`` (A m^2): see :mod:`helimag.physics.magnetics`.
    ``pose_model(drive, t)`` returns the RPM's pose: see :mod:`helimag.physics.kinematics`.
    """
    drive_type = pose_model.input_types["drive"]
    to_sample = build_to_sample(magnet_model, pose_model)

    @wp.kernel(enable_backward=False, module="unique")
    def advance(
        bodies: wp.array(dtype=Body),
        drives: wp.array(dtype=drive_type),
        magnets: wp.array2d(dtype=Magnet),
        clocks: wp.array(dtype=Clock),
        bounds: wp.array(dtype=Bounds),
        first: int,
        last: int,
        progress: wp.array(dtype=Progress),
        records: wp.array2d(dtype=Record),
    ):
        run = wp.tid()
        p = progress[run]
        clock = clocks[run]
        sample = int(first)
        while sample < last and p.status == RUNNING:
            end = wp.float64(sample) * clock.interval
            if end >= NEARLY_ONE * clock.duration:
                end = clock.duration
            p, record = to_sample(bodies[run], drives[run], magnets[run], clock, bounds[run], end, p)
            records[run, sample - first] = record
            if p.status == RUNNING and p.time >= clock.duration:
                p.status = HORIZON
            sample += 1
        progress[run] = p

    return advance


@cache
def build_observe(magnet_model: Callable[..., Any], pose_model: wp.Function) -> wp.Kernel:
    """Make the kernel that adds to sampled states what else a trajectory holds: RPM pose, field and phase lag."""
    load = build_load(magnet_model)
    drive_type = pose_model.input_types["drive"]

    @wp.kernel(enable_backward=False, module="unique")
    def observe(
        drives: wp.array(dtype=drive_type),
        magnets: wp.array(dtype=Magnet),
        times: wp.array(dtype=wp.float64),
        states: wp.array(dtype=State),
        positions: wp.array(dtype=wp.vec3d),
        moments: wp.array(dtype=wp.vec3d),
        fields: wp.array(dtype=wp.vec3d),
        lags: wp.array(dtype=wp.float64),
    ):
        i = wp.tid()
        pose = pose_model(drives[0], times[i])
        field, force = load(magnets, pose, head_position(states[i]), wp.vec3d())
        lag = lag_vector(field, states[i])
        positions[i] = pose.position
        rotation_axis = wp.vec3d(pose.rotation[0, 0], pose.rotation[1, 0], pose.rotation[2, 0])
        moment = wp.vec3d()
        for j in range(magnets.shape[0]):
            moment += magnets[j].moment * phased_axis(magnets[j], pose.moment_axis, rotation_axis)
        moments[i] = moment
        fields[i] = field
        lags[i] = wp.atan2(lag[1], lag[0])

    return observe
