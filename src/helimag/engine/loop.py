"""The time loop: a method's steps under error control, with events, statistics and samples; one Warp thread a run.

Each run advances on its own clock. A launch lets it try so many steps and leaves in ``Progress`` all that is needed to
go on, so that the host can report, be interrupted and continue; what comes out does not depend on where launches end.
"""

from dataclasses import replace
from functools import cache

import warp as wp

from helimag.engine.attempts import RUNNING, TAKEN, Tried, build_judged, build_noted, build_planned, to_middle
from helimag.engine.columns import build_columns
from helimag.engine.control import Control
from helimag.engine.dense import KEPT
from helimag.engine.events import Bounds, clearance
from helimag.engine.methods import Method
from helimag.engine.moving import gone_on
from helimag.engine.poses import poses_of
from helimag.engine.progress import Progress
from helimag.engine.recording import recorded
from helimag.engine.samples import Record, Schedule, sample_time, statistics_from
from helimag.engine.system import System, build_rates_at, clear_of_walls, leaps_hold
from helimag.engine.turns import NODES
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import Instant, State, head_position, rotation_matrix
from helimag.physics.magnetics import FieldSource

IN_A_LANE = wp.constant(-1)  # instead of steps between nodes of a turn: a step that may be tried in a lane


@cache
def build_attempt(system: System, method: Method) -> wp.Function:
    """Make the function that tries a step of ``dt`` (s) to ``t``, under error control and with an eye on events.

    It returns whether the step was taken, the step to try next, the run's status; the instant, what is around the
    middle of the next step, and rates, as they are now; and what came of the step.
    """
    drive_type, medium, poses = system.drive_type, system.medium, poses_of(system.pose)
    rates_at, trial, instant, pose_at = build_rates_at(system), method.build(system), poses.instant, poses.at
    surroundings_type, here_type, local = medium.surroundings_type, medium.here_type, medium.local
    judged = build_judged(method)

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
        now: Instant,
        dt: wp.float64,
        t: wp.float64,
        step: wp.float64,
        state: State,
        k0: State,
        kept: wp.array(dtype=State),
        keep: bool,
    ):
        found = Tried()
        new, error, within = trial(body, here, drive, magnets, control, now, dt, state, k0, kept, keep)
        then = instant(drive, t)
        pose = pose_at(drive, then)
        least, kind = clearance(bounds, magnets, pose, new)
        outcome, following, status = judged(error, least, kind, dt, step)
        if outcome != TAKEN:
            return outcome, following, status, now, here, k0, found
        # surroundings as half way through the next step, if that goes on as this one went: second order in the step
        found.middle = gone_on(state, dt * k0, new, to_middle(control, step, dt))
        there = local(surroundings, head_position(found.middle), rotation_matrix(found.middle), sheets)
        rates, lag = rates_at(body, there, magnets, pose, new)
        found.state = new
        found.rates = rates
        found.within = within
        found.lag = lag
        return outcome, following, status, then, there, rates, found

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
def begun(p: wp.ref[Progress], schedule: Schedule, run: int, records: wp.array2d(dtype=Record)):
    """Where a run begins, new statistics; and what is due recorded."""
    if p.sample == 0:
        p.statistics = statistics_from(p.time, p.state)
    if p.time >= sample_time(schedule, p.sample):
        recorded(p, schedule, run, records)


@cache
def build_until(system: System, method: Method) -> wp.Function:
    """Make the function that lets a run try up to ``most`` steps, and records the samples it comes to.

    It ends early where a turn of the magnet is to be followed for leaping; and, where it goes ``abreast`` of others (1,
    else 0), before a step. It returns how many steps are left; steps between two nodes of that turn, none where there
    is none, or IN_A_LANE; and the instant and rates.
    """
    attempt, looked, columns_type = build_attempt(system, method), build_looked(system), build_columns(system)
    planned, noted, leaping = build_planned(method), build_noted(system, method), method.leaps
    asked = _asked() if leaping else None

    @wp.func
    def until(runs: columns_type, run: int, most: int, abreast: int):
        body, around, drive, rpm = runs.bodies[run], runs.surroundings[run], runs.drives[run], runs.magnets[run]
        control, bound, schedule, left, fine = runs.controls[run], runs.bounds[run], runs.schedules[run], most, int(0)
        sheets, kept = wp.zeros(shape=SHEETS, dtype=Sheet), wp.zeros(shape=KEPT, dtype=State)
        now, here, k0 = looked(body, around, sheets, drive, rpm, runs.progress[run])
        begun(runs.progress[run], schedule, run, runs.records)
        while left > 0 and runs.progress[run].status == RUNNING and fine == 0:
            if wp.static(leaping):  # noqa: SIM102 - a branch on a constant alone is left out of the kernel
                if runs.progress[run].time >= runs.progress[run].leap.ready:
                    p, fine = asked(body, drive, rpm, control, bound, schedule, runs.memory, run, runs.progress[run])
                    runs.progress[run] = p
                    left -= NODES
            t0 = runs.progress[run].time
            due = sample_time(schedule, runs.progress[run].sample)
            if fine == 0 and left > 0 and t0 < due and (wp.static(not leaping) or t0 < runs.progress[run].leap.ready):
                if abreast == 1:
                    fine = IN_A_LANE
                else:
                    k = k0
                    step = runs.progress[run].step
                    dt, t = planned(control, schedule, runs.progress[run].sample, due, t0, step)
                    outcome, step, status, now, here, k0, tried = attempt(
                        body, around, sheets, here, drive, rpm, control, bound, now, dt, t, step,
                        runs.progress[run].state, k0, kept, due < t
                    )  # fmt: skip
                    left -= 1 + noted(runs, run, here, outcome, dt, t, k, tried, kept, step, status)
        return left, fine, now, k0

    return until


def _asked() -> wp.Function:
    """What asks for turns of the magnet: imported where runs leap."""
    from helimag.engine.leaping import asked

    return asked


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
            left, fine, now, k0 = until(runs, run, left, 0)
            if wp.static(leaping):  # noqa: SIM102 - likewise
                if fine > 0:
                    turned(runs, run, fine)

    return advance
