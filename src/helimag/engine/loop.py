"""The time loop: a method's steps under error control, with events, statistics and samples; one Warp thread a run.

Each run advances on its own clock. A launch lets it try so many steps and leaves in ``Progress`` all that is needed to
go on, so that the host can report, be interrupted and continue; what comes out does not depend on where launches end.
"""

from dataclasses import replace
from functools import cache

import warp as wp

from helimag.engine.columns import build_columns
from helimag.engine.control import Control, build_rescaled
from helimag.engine.dense import KEPT, STAGES
from helimag.engine.events import Bounds, clearance
from helimag.engine.methods import Method
from helimag.engine.moving import gone_on
from helimag.engine.poses import poses_of
from helimag.engine.progress import Progress
from helimag.engine.recording import build_within, recorded
from helimag.engine.samples import Record, Schedule, sample_time, statistics_from, stepped_with
from helimag.engine.synchrony import synchrony_with
from helimag.engine.system import System, build_rates_at, clear_of_walls, leaps_hold
from helimag.engine.touches import touches_with
from helimag.engine.turns import NODES
from helimag.outcomes import End
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import Instant, State, head_position, rotation_matrix
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


@wp.func
def within_reach(schedule: Schedule, sample: int, due: wp.float64, reach: wp.float64) -> wp.float64:
    """When the last sample is due (s) that a step can reach; or the next one, where that is too far."""
    if due + schedule.interval > reach:
        return due
    further = wp.min(wp.floor((reach - due) / schedule.interval), MOST_WITHIN)
    return sample_time(schedule, sample + int(further))


@cache
def build_attempt(system: System, method: Method) -> wp.Function:
    """Make the function that tries one step towards a sample, under error control and with an eye on events.

    It returns whether the step was taken, how long it was, the instant, the step to try next, the state, the middle of
    the next step with what is around it, rates, lag vectors within the step and at its end, and the run's status.
    """
    drive_type, medium, poses = system.drive_type, system.medium, poses_of(system.pose)
    rates_at, trial, instant, pose_at = build_rates_at(system), method.build(system), poses.instant, poses.at
    dense = method.course is not None
    surroundings_type, here_type, local = medium.surroundings_type, medium.here_type, medium.local
    rescaled = build_rescaled(method.error_order, method.safety)
    growth = wp.constant(wp.float64(method.growth))

    @wp.func
    def attempt(
        body: Swimmer,
        surroundings: surroundings_type,
        sheets: wp.array(dtype=Sheet),
        here: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        control: Control,
        bounds: Bounds,
        schedule: Schedule,
        sample: int,
        due: wp.float64,
        now: Instant,
        step: wp.float64,
        state: State,
        middle: State,
        k0: State,
        kept: wp.array(dtype=State),
    ):
        end = due
        if wp.static(dense):
            end = within_reach(schedule, sample, due, now.time + REACH * wp.min(step, control.longest))
        # equal steps to the sample, so that landing on it never costs a tiny one
        count = wp.ceil((end - now.time) / wp.min(step, control.longest))
        dt = (end - now.time) / count
        t = now.time + dt
        if count == ONE:
            t = end
        new, error, lag_within = trial(body, here, drive, magnets, control, now, dt, state, k0, kept, due < t)
        lag = wp.vec2d()
        if not error <= ONE:
            shorter = wp.min(rescaled(dt, error), HALF * dt)
            broken = wp.where(shorter < SHORTEST, NOT_FINITE, RUNNING)
            return REJECTED, dt, now, shorter, state, middle, here, k0, lag, lag, broken
        then = instant(drive, t)
        pose = pose_at(drive, then)
        least, kind = clearance(bounds, magnets, pose, new)
        if least < ZERO and dt > EVENT_TIME:
            return LOCATING, dt, now, HALF * dt, state, middle, here, k0, lag, lag, RUNNING
        if least >= ZERO:
            kind = RUNNING
        # surroundings as half way through the next step, if that goes on as this one went: second order in the step;
        # not asked for the step's length that follows from the error, so that a processor can do both at a time
        share = HALF * wp.min(step, control.longest) / dt
        following_middle = gone_on(state, dt * k0, new, share)
        there = local(surroundings, head_position(following_middle), rotation_matrix(following_middle), sheets)
        following = wp.min(rescaled(dt, error), growth * step)
        rates, lag = rates_at(body, there, magnets, pose, new)
        return TAKEN, dt, then, following, new, following_middle, there, rates, lag_within, lag, kind

    return attempt


@cache
def build_looked(system: System) -> wp.Function:
    """Make the function that looks around where a run stands: the instant, surroundings of its next step, rates."""
    drive_type, around_type, local = system.drive_type, system.medium.surroundings_type, system.medium.local
    rates_at, poses = build_rates_at(system), poses_of(system.pose)
    instant, pose_at = poses.instant, poses.at

    @wp.func
    def looked(
        body: Swimmer,
        around: around_type,
        sheets: wp.array(dtype=Sheet),
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        p: Progress,
    ):
        here = local(around, head_position(p.middle), rotation_matrix(p.middle), sheets)
        now = instant(drive, p.time)
        rates, lag = rates_at(body, here, magnets, pose_at(drive, now), p.state)
        return now, here, rates

    return looked


@wp.func
def begun(before: Progress, schedule: Schedule, run: int, records: wp.array2d(dtype=Record)) -> Progress:
    """The progress that a launch goes on with: where a run begins, with new statistics, and what is due recorded."""
    p = before
    if p.sample == 0:
        p.statistics = statistics_from(p.time, p.state)
    if p.time >= sample_time(schedule, p.sample):
        p = recorded(p, schedule, run, records)
    return p


@cache
def build_until(system: System, method: Method) -> wp.Function:
    """Make the function that lets a run try up to ``left`` steps, and records the samples it comes to.

    It ends early where a turn of the magnet is to be followed for leaping. It returns how many steps are left, and
    steps between two nodes of that turn; none where there is none. Steps are noted in place: a function of the whole
    progress would copy it at each, some percent of the time.
    """
    attempt, looked, columns_type = build_attempt(system, method), build_looked(system), build_columns(system)
    dense, leaping, touched = method.course is not None, method.leaps, system.medium.touched
    within = build_within(system, method) if dense else None
    asked, watched = _asking_parts() if leaping else (None, None)

    @wp.func
    def until(runs: columns_type, run: int, most: int):
        p = runs.progress[run]
        body, around, drive, rpm = runs.bodies[run], runs.surroundings[run], runs.drives[run], runs.magnets[run]
        control, bound, schedule, left, fine = runs.controls[run], runs.bounds[run], runs.schedules[run], most, int(0)
        sheets, kept = wp.zeros(shape=SHEETS, dtype=Sheet), wp.zeros(shape=KEPT, dtype=State)
        now, here, k0 = looked(body, around, sheets, drive, rpm, p)
        p = begun(p, schedule, run, runs.records)
        while left > 0 and p.status == RUNNING and fine == 0:
            if wp.static(leaping):  # noqa: SIM102 - a branch on a constant alone is left out of the kernel
                if p.time >= p.leap.ready:
                    p, fine = asked(body, drive, rpm, control, bound, schedule, runs.memory, run, p)
                    left -= NODES
            due = sample_time(schedule, p.sample)
            if fine == 0 and p.time < due and (wp.static(not leaping) or p.time < p.leap.ready):
                climb = k0[2]
                outcome, dt, now, step, new, middle, here, k0, lag_within, lag, status = attempt(
                    body, around, sheets, here, drive, rpm, control, bound, schedule, p.sample, due, now, p.step,
                    p.state, p.middle, k0, kept
                )  # fmt: skip
                if outcome == TAKEN:
                    t = now.time
                    since = dt
                    if due >= t:  # or else the samples within are seen
                        p.synchrony = synchrony_with(p.synchrony, lag_within)
                    if wp.static(dense):  # noqa: SIM102 - likewise
                        if due < t:
                            runs.progress[run] = p
                            climb, since, samples = within(runs, run, dt, t, kept)
                            left -= samples // STAGES
                            p.sample = runs.progress[run].sample  # all of the progress would cost each step time
                            p.synchrony = runs.progress[run].synchrony
                            p.statistics = runs.progress[run].statistics
                            if wp.static(touched is not None):
                                p.touches = runs.progress[run].touches
                            due = sample_time(schedule, p.sample)
                    p.synchrony = synchrony_with(p.synchrony, lag)
                    p.statistics = stepped_with(p.statistics, since, climb, new, k0[2])
                    p.time = t
                    p.state = new
                    p.steps += wp.int64(1)
                    if wp.static(touched is not None):
                        p.touches = touches_with(p.touches, touched(here, new, k0), t, since)
                    if wp.static(leaping):
                        p.leap = watched(p.leap, drive.spin_rate, t, lag)
                p.rejected += wp.where(outcome == REJECTED, wp.int64(1), wp.int64(0))
                p.step = step
                p.middle = middle
                p.status = status
                left -= 1
                if p.time >= due or p.status != RUNNING:
                    p = recorded(p, schedule, run, runs.records)
        runs.progress[run] = p
        return left, fine

    return until


def _asking_parts() -> tuple[wp.Function, wp.Function]:
    """What asks for turns of the magnet, and what keeps leaps from beginning too early: imported where runs leap."""
    from helimag.engine.leaping import asked, watched

    return asked, watched


def build_advance(system: System, method: Method, lanes: bool = False) -> wp.Kernel:
    """Make the kernel that lets each run of a batch try up to ``budget`` steps, and records the samples it comes to.

    Methods that differ in their names alone have one kernel, such as direct steps and leaps where those do not hold.
    Samples of a leap may be worked out in the lanes of a vector register, as many at once.
    """
    leaps = method.leaps and leaps_hold(system)
    return _advance(system, replace(method, name="", leaps=leaps), lanes and leaps)


@cache
def build_turned(system: System, lanes: bool) -> wp.Function:
    """Make the function that follows the turn a run asks for, and does with it what comes next."""
    from helimag.engine.leaping import build_answered
    from helimag.engine.leaps import build_follow

    clear, beyond, columns_type = clear_of_walls(system), system.medium.beyond, build_columns(system)
    follow, answered = build_follow(clear), build_answered(system, lanes)

    @wp.func
    def turned(runs: columns_type, run: int, fine: int):
        around, tail = beyond(runs.surroundings[run]), runs.bounds[run].tail
        leap = runs.progress[run].leap
        looks = runs.memory.looks[run]
        turn, shape, roll = follow(
            runs.bodies[run], around, runs.drives[run], runs.magnets[run], tail, looks, leap, fine
        )
        answered(runs, run, turn, shape, roll)

    return turned


@cache
def _advance(system: System, method: Method, lanes: bool) -> wp.Kernel:
    until, leaping, columns_type = build_until(system, method), method.leaps, build_columns(system)
    turned = build_turned(system, lanes) if leaping else None

    @wp.kernel(enable_backward=False, module="unique")
    def advance(runs: columns_type, budget: int):
        run = wp.tid()
        left = int(budget)
        while left > 0 and runs.progress[run].status == RUNNING:
            left, fine = until(runs, run, left)
            if wp.static(leaping):  # noqa: SIM102 - likewise
                if fine > 0:
                    turned(runs, run, fine)

    return advance
