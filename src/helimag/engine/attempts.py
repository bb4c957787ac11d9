"""One step of a run: planned, judged by its error and by events, and noted; the same in a lane and by itself."""

from functools import cache

import warp as wp

from helimag.engine.columns import build_columns
from helimag.engine.control import Control, build_rescaled
from helimag.engine.dense import STAGES
from helimag.engine.events import Bounds, clearance
from helimag.engine.methods import Method
from helimag.engine.moving import gone_on
from helimag.engine.poses import poses_of
from helimag.engine.recording import build_within, recorded
from helimag.engine.samples import Schedule, sample_time, stepped_with
from helimag.engine.synchrony import synchrony_with
from helimag.engine.system import System, build_rates_at
from helimag.engine.touches import touches_with
from helimag.outcomes import End
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import Instant, State
from helimag.physics.magnetics import FieldSource

ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
REACH = wp.constant(wp.float64(0.8))  # of a step, for samples: within one they are a power less exact than at its end
MOST_WITHIN = wp.constant(wp.float64(1000.0))  # samples within a step, so that launches stay short
SHORTEST = wp.constant(wp.float64(1e-9))  # s; needing a shorter step means that the numbers are broken
EVENT_TIME = wp.constant(wp.float64(1e-9))  # s; events are located to this: magnets are met at metres a second
TAKEN, REJECTED, LOCATING = (wp.constant(i) for i in range(3))  # what became of a trial step
RUNNING, NOT_FINITE = (wp.constant(end.flag) for end in (End.RUNNING, End.NOT_FINITE))


@wp.struct
class Aim:
    """A step that a run is to try in a lane."""

    now: Instant
    then: Instant  # at its end
    dt: wp.float64  # s
    share: wp.float64  # of the step, from its end to the middle of the next
    state: State
    k0: State  # its rates
    keep: wp.int32  # whether samples lie within (1, else 0)


@wp.struct
class Tried:
    """What came of a step."""

    state: State
    error: wp.float64  # in units of the tolerance
    least: wp.float64  # distance to what would end the run, m
    kind: wp.float64  # which end that would be
    middle: State  # of the next step
    rates: State
    within: wp.vec2d  # lag vectors within the step and at its end
    lag: wp.vec2d


@wp.func
def within_reach(schedule: Schedule, sample: int, due: wp.float64, reach: wp.float64) -> wp.float64:
    """When the last sample is due (s) that a step can reach; or the next one, where that is too far."""
    if due + schedule.interval > reach:
        return due
    further = wp.min(wp.floor((reach - due) / schedule.interval), MOST_WITHIN)
    return sample_time(schedule, sample + int(further))


@wp.func
def to_middle(control: Control, step: wp.float64, dt: wp.float64) -> wp.float64:
    """The share of a step of ``dt`` (s) from its end to the middle of the next, if that is as long as wanted now.

    Not asked for the step's length that follows from the error, so that a processor can do both at a time.
    """
    return HALF * wp.min(step, control.longest) / dt


@cache
def build_planned(method: Method) -> wp.Function:
    """Make the function that says how long the next step towards a sample is, and when it ends (s)."""
    dense = method.course is not None

    @wp.func
    def planned(control: Control, schedule: Schedule, sample: int, due: wp.float64, now: wp.float64, step: wp.float64):
        longest = wp.min(step, control.longest)
        end = due
        if wp.static(dense):
            end = within_reach(schedule, sample, due, now + REACH * longest)
        # equal steps to the sample, so that landing on it never costs a tiny one
        count = wp.ceil((end - now) / longest)
        dt = (end - now) / count
        t = now + dt
        if count == ONE:
            t = end
        return dt, t

    return planned


@cache
def build_judged(method: Method) -> wp.Function:
    """Make the function that says what becomes of a step of ``dt`` (s) that was tried where ``step`` was wanted.

    From its error, and the least distance to what would end the run and which end that is, it returns the outcome, the
    step to try next (s) and the run's status.
    """
    rescaled = build_rescaled(method.error_order, method.safety)
    growth = wp.constant(wp.float64(method.growth))

    @wp.func
    def judged(error: wp.float64, least: wp.float64, kind: wp.float64, dt: wp.float64, step: wp.float64):
        if not error <= ONE:
            shorter = wp.min(rescaled(dt, error), HALF * dt)
            return REJECTED, shorter, wp.where(shorter < SHORTEST, NOT_FINITE, RUNNING)
        if least < ZERO and dt > EVENT_TIME:
            return LOCATING, HALF * dt, RUNNING
        return TAKEN, wp.min(rescaled(dt, error), growth * step), wp.where(least < ZERO, int(kind), RUNNING)

    return judged


@cache
def build_noted(system: System, method: Method) -> wp.Function:
    """Make the function that notes what became of a step of ``dt`` (s) to ``t``, and the samples it comes to.

    ``here`` is around its end, ``k0`` the rates at its start; where samples lie within it, its stages were ``kept``. It
    returns the steps that those samples are worth. All is noted in place: a function of the whole progress would copy
    it at each step, some percent of the time.
    """
    dense, leaping, touched = method.course is not None, method.leaps, system.medium.touched
    within, ready_with = build_within(system, method) if dense else None, _ready_with() if leaping else None
    columns_type, here_type = build_columns(system), system.medium.here_type

    @wp.func
    def noted(
        runs: wp.ref[columns_type],
        run: int,
        here: here_type,
        outcome: int,
        dt: wp.float64,
        t: wp.float64,
        k0: State,
        tried: wp.ref[Tried],
        kept: wp.array(dtype=State),
        step: wp.float64,
        status: int,
    ) -> int:
        due = sample_time(runs.schedules[run], runs.progress[run].sample)
        samples = 0
        if outcome == TAKEN:
            climb = k0[2]
            since = dt
            if wp.static(dense):  # noqa: SIM102 - a branch on a constant alone is left out of the kernel
                if due < t:
                    climb, since, samples = within(runs, run, dt, t, kept)
                    due = sample_time(runs.schedules[run], runs.progress[run].sample)
            if samples == 0:  # or else they are seen
                runs.progress[run].synchrony = synchrony_with(runs.progress[run].synchrony, tried.within)
            runs.progress[run].synchrony = synchrony_with(runs.progress[run].synchrony, tried.lag)
            runs.progress[run].statistics = stepped_with(
                runs.progress[run].statistics, since, climb, tried.state, tried.rates[2]
            )
            runs.progress[run].time = t
            runs.progress[run].state = tried.state
            runs.progress[run].middle = tried.middle
            runs.progress[run].steps = runs.progress[run].steps + wp.int64(1)
            if wp.static(touched is not None):
                touching = touched(here, tried.state, tried.rates)
                runs.progress[run].touches = touches_with(runs.progress[run].touches, touching, t, since)
            if wp.static(leaping):
                runs.progress[run].leap.ready = ready_with(
                    runs.progress[run].leap.ready, runs.drives[run].spin_rate, t, tried.lag
                )
        if outcome == REJECTED:
            runs.progress[run].rejected = runs.progress[run].rejected + wp.int64(1)
        runs.progress[run].step = step
        runs.progress[run].status = status
        if runs.progress[run].time >= due or status != RUNNING:
            recorded(runs.progress[run], runs.schedules[run], run, runs.records)
        return samples // STAGES

    return noted


def _ready_with() -> wp.Function:
    """What keeps leaps from beginning too early: imported where runs leap."""
    from helimag.engine.leaping import ready_with

    return ready_with


@cache
def build_tried(system: System, method: Method) -> wp.Function:
    """Make the function that tries a step in open water, with all that may be asked at its end."""
    rates_at, trial, pose_at = build_rates_at(system), method.build(system), poses_of(system.pose).at
    drive_type, here_type = system.drive_type, system.medium.here_type

    @wp.func
    def tried(
        body: Swimmer,
        here: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        control: Control,
        bounds: Bounds,
        aim: Aim,
        kept: wp.array(dtype=State),
        keep: bool,
    ) -> Tried:
        state, error, within = trial(
            body, here, drive, magnets, control, aim.now, aim.dt, aim.state, aim.k0, kept, keep
        )
        pose = pose_at(drive, aim.then)
        least, kind = clearance(bounds, magnets, pose, state)
        rates, lag = rates_at(body, here, magnets, pose, state)
        found = Tried()
        found.state = state
        found.error = error
        found.least = least
        found.kind = kind
        found.middle = gone_on(aim.state, aim.dt * aim.k0, state, aim.share)
        found.rates = rates
        found.within = within
        found.lag = lag
        return found

    return tried
