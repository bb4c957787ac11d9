"""Runs abreast: one thread leads all runs of a batch, and steps or follows turns of as many as a register holds.

Each run goes on by itself up to a step, or up to a turn of the magnet that is to be followed for leaping. Steps, and
turns with as many steps, are taken together, by what :mod:`helimag.engine.lanes` makes of the same functions; so the
bits of a run are those that it has alone.
"""

from functools import cache

import warp as wp

from helimag.engine.abreast import Followed, Waiting, build_steps_abreast, build_turns_abreast, crew_room
from helimag.engine.attempts import RUNNING, TAKEN, Aim, Tried, build_judged, build_noted, build_planned, to_middle
from helimag.engine.columns import build_columns
from helimag.engine.dense import KEPT
from helimag.engine.lanes import LANES
from helimag.engine.leaping import build_answered
from helimag.engine.leaps import spin_at
from helimag.engine.loop import IN_A_LANE, build_until
from helimag.engine.methods import Method
from helimag.engine.poses import poses_of
from helimag.engine.samples import sample_time
from helimag.engine.system import System, clear_of_walls
from helimag.engine.turns import FINEST
from helimag.physics.kinematics import State

WIDTH = wp.constant(LANES)
MOST_STEPS = 2 * FINEST  # between two nodes of a turn
KINDS = wp.constant(MOST_STEPS + 2)  # of what runs wait for: a step, nothing, or a turn of so many steps
FEWEST = wp.constant(2)  # runs for which a step in lanes is worth while
Counts = wp.types.vector(length=MOST_STEPS + 2, dtype=wp.int32)


def room(runs: int) -> list[wp.array]:
    """Room for what the kernel keeps of each run between steps or turns, and for who is in which lane."""
    shapes = [(runs, kind) for kind in (Waiting, Followed, Aim, Tried)]
    shapes += [((runs, KEPT), State), (LANES, wp.int32), (crew_room(), wp.float64)]
    return [wp.zeros(shape, dtype=kind, device="cpu") for shape, kind in shapes]


@wp.func
def wanted(waiting: wp.array(dtype=Waiting)):
    """What is to be done next, and for how many: what a register's worth of runs waits for, or else most runs.

    Steps of a turn, or IN_A_LANE; none where no run waits.
    """
    counts = Counts()
    for run in range(waiting.shape[0]):
        counts[waiting[run].fine - IN_A_LANE] += 1
    best = int(0)
    most = int(0)
    kinds = int(KINDS)
    for kind in range(kinds):
        fine = kind + IN_A_LANE
        if fine != 0 and counts[kind] > 0 and (counts[kind] >= WIDTH or counts[kind] >= most):
            best = fine
            most = counts[kind]
    return best, most


@wp.func
def lined_up(waiting: wp.array(dtype=Waiting), fine: int, lanes: wp.array(dtype=wp.int32)) -> int:
    """Put runs that wait for this into lanes, the first of them again where none is left."""
    count = int(0)
    for run in range(waiting.shape[0]):
        if waiting[run].fine == fine and count < WIDTH:
            lanes[count] = run
            count += 1
    for lane in range(count, WIDTH):
        lanes[lane] = lanes[0]
    return count


@cache
def build_goes_on(system: System, method: Method) -> wp.Function:
    """Make the function that says whether a run goes on by a step in a lane (1, else 0), and aims it."""
    planned, instant, leaping = build_planned(method), poses_of(system.pose).instant, method.leaps
    columns_type = build_columns(system)

    @wp.func
    def goes_on(runs: columns_type, run: int, left: int, aim: wp.ref[Aim]) -> int:
        now = runs.progress[run].time
        sample = runs.progress[run].sample
        step = runs.progress[run].step
        due = sample_time(runs.schedules[run], sample)
        if left <= 0 or runs.progress[run].status != RUNNING:
            return 0
        if wp.static(leaping):  # noqa: SIM102 - a branch on a constant alone is left out of the kernel
            if now >= runs.progress[run].leap.ready:
                return 0
        dt, t = planned(runs.controls[run], runs.schedules[run], sample, due, now, step)
        aim.then = instant(runs.drives[run], t)
        aim.dt = dt
        aim.share = to_middle(runs.controls[run], step, dt)
        aim.state = runs.progress[run].state
        aim.keep = wp.where(due < t, 1, 0)
        return 1

    return goes_on


@cache
def build_stepping(system: System, method: Method) -> wp.Function:
    """Make the function that steps the first ``count`` lanes, until one of them is not to be stepped on."""
    steps_abreast, columns_type = build_steps_abreast(system, method), build_columns(system)
    here_type, goes_on = system.medium.here_type, build_goes_on(system, method)
    judged, noted = build_judged(method), build_noted(system, method)

    @wp.func
    def stepping(
        runs: columns_type,
        waiting: wp.array(dtype=Waiting),
        aims: wp.array(dtype=Aim),
        tries: wp.array(dtype=Tried),
        kept: wp.array2d(dtype=State),
        lanes: wp.array(dtype=wp.int32),
        crew: wp.array(dtype=wp.float64),
        count: int,
    ):
        going = int(count)
        anew = int(1)
        while going == count:
            keep = int(0)
            for lane in range(count):
                keep = wp.max(keep, aims[lanes[lane]].keep)
            steps_abreast(
                runs.bodies, runs.drives, runs.magnets, runs.controls, runs.bounds,
                aims, tries, kept, lanes, crew, anew, keep
            )  # fmt: skip
            anew = 0
            for lane in range(count):
                run = lanes[lane]
                dt = aims[run].dt
                outcome, step, status = judged(
                    tries[run].error, tries[run].least, tries[run].kind, dt, runs.progress[run].step
                )
                worth = noted(
                    runs, run, here_type(), outcome, dt, aims[run].then.time, aims[run].k0, tries[run], kept[run], step,
                    status
                )  # fmt: skip
                if outcome == TAKEN:
                    aims[run].now = aims[run].then
                    aims[run].k0 = tries[run].rates
                left = waiting[run].left - 1 - worth
                waiting[run].left = left
                if goes_on(runs, run, left, aims[run]) == 0:
                    waiting[run].fine = 0
                    going -= 1

    return stepping


@cache
def build_asking(system: System, method: Method, steps: bool) -> wp.Function:
    """Make the function that lets runs that wait for nothing go on, each up to a step or a turn for lanes.

    Where those who wait for steps are too few to be lined up, ``alone`` (1, else 0), they go on by themselves.
    """
    until, columns_type, leaping = build_until(system, method), build_columns(system), method.leaps
    goes_on = build_goes_on(system, method)

    @wp.func
    def asking(runs: columns_type, waiting: wp.array(dtype=Waiting), aims: wp.array(dtype=Aim), alone: int):
        for run in range(waiting.shape[0]):
            fine = waiting[run].fine
            if fine == 0 or (alone == 1 and fine == IN_A_LANE):
                left = waiting[run].left
                waiting[run].fine = 0
                if left > 0 and runs.progress[run].status == RUNNING:
                    left, fine, now, k0 = until(runs, run, left, wp.where(wp.static(steps), 1 - alone, 0))
                    waiting[run].left = left
                    waiting[run].fine = fine
                    if fine == IN_A_LANE:
                        aims[run].now = now
                        aims[run].k0 = k0
                        goes_on(runs, run, left, aims[run])  # it does: there are steps left, see ``until``
                    if wp.static(leaping):
                        waiting[run].spin = spin_at(runs.drives[run], runs.progress[run].leap.origin)
                        waiting[run].start = runs.progress[run].leap.aim
                        waiting[run].tail = runs.bounds[run].tail

    return asking


@cache
def build_following(system: System) -> wp.Function:
    """Make the function that follows turns for the first ``count`` lanes."""
    answered, columns_type = build_answered(system, True), build_columns(system)
    turns_abreast = build_turns_abreast(clear_of_walls(system))

    @wp.func
    def following(
        runs: columns_type,
        waiting: wp.array(dtype=Waiting),
        followed: wp.array(dtype=Followed),
        lanes: wp.array(dtype=wp.int32),
        count: int,
        fine: int,
    ):
        turns_abreast(runs.bodies, runs.drives, runs.magnets, waiting, followed, lanes, fine)
        for lane in range(count):
            run = lanes[lane]
            answered(runs, run, followed[run].turn, followed[run].shape, followed[run].roll)
            waiting[run].fine = 0

    return following


@cache
def build_advance_abreast(system: System, method: Method, steps: bool) -> wp.Kernel:
    """Make the kernel whose one thread lets each run of a batch try up to ``budget`` steps, as ``loop``'s does each.

    With ``steps`` in lanes, or turns alone.
    """
    leaping, columns_type = method.leaps, build_columns(system)
    asking = build_asking(system, method, steps)
    stepping = build_stepping(system, method) if steps else None
    following = build_following(system) if leaping else None

    @wp.kernel(enable_backward=False, module="unique")
    def advance_abreast(
        runs: columns_type,
        budget: int,
        waiting: wp.array(dtype=Waiting),
        followed: wp.array(dtype=Followed),
        aims: wp.array(dtype=Aim),
        tries: wp.array(dtype=Tried),
        kept: wp.array2d(dtype=State),
        lanes: wp.array(dtype=wp.int32),
        crew: wp.array(dtype=wp.float64),
    ):
        for run in range(waiting.shape[0]):
            waiting[run].left = budget
            waiting[run].fine = 0
        alone = int(0)
        fine = int(1)
        while fine != 0:
            asking(runs, waiting, aims, alone)
            fine, count = wanted(waiting)
            alone = wp.where(fine == IN_A_LANE and count < FEWEST, 1, 0)
            if fine != 0 and alone == 0:
                count = lined_up(waiting, fine, lanes)
                if wp.static(steps):  # noqa: SIM102 - a branch on a constant alone is left out of the kernel
                    if fine == IN_A_LANE:
                        stepping(runs, waiting, aims, tries, kept, lanes, crew, count)
                if wp.static(leaping):  # noqa: SIM102 - likewise
                    if fine > 0:
                        following(runs, waiting, followed, lanes, count, fine)

    return advance_abreast
