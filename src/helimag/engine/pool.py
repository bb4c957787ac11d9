"""Runs abreast: one thread leads all runs of a batch, and follows turns of the magnet for as many as a register holds.

Each run goes on by itself up to a turn that is to be followed for leaping. Turns with as many steps are followed
together, by what :mod:`helimag.engine.lanes` makes of the same functions; so a run's bits are those that it has alone.
"""

from functools import cache

import warp as wp

from helimag.engine.abreast import Followed, Waiting, build_turns_abreast
from helimag.engine.columns import build_columns
from helimag.engine.lanes import LANES
from helimag.engine.leaping import build_answered
from helimag.engine.leaps import spin_at
from helimag.engine.loop import RUNNING, build_until
from helimag.engine.methods import Method
from helimag.engine.system import System, clear_of_walls
from helimag.engine.turns import FINEST

WIDTH = wp.constant(LANES)
MOST_STEPS = wp.constant(2 * FINEST)  # between two nodes of a turn


def room(runs: int) -> list[wp.array]:
    """Room for what the kernel keeps of each run between a turn's start and its end, and for who is in which lane."""
    kinds = ((runs, Waiting), (runs, Followed), (LANES, wp.int32))
    return [wp.zeros(count, dtype=kind, device="cpu") for count, kind in kinds]


@wp.func
def next_steps(waiting: wp.array(dtype=Waiting)) -> int:
    """Steps of the turns to be followed next: the most that a register's worth of runs waits for, or else most runs."""
    best = int(0)
    most = int(0)
    for fine in range(1, MOST_STEPS + 1):
        count = int(0)
        for run in range(waiting.shape[0]):
            if waiting[run].fine == fine:
                count += 1
        if count > 0 and (count >= WIDTH or count >= most):
            best = fine
            most = count
    return best


@wp.func
def lined_up(waiting: wp.array(dtype=Waiting), fine: int, lanes: wp.array(dtype=wp.int32)) -> int:
    """Put runs that wait for turns of so many steps into lanes, the first of them again where none is left."""
    count = int(0)
    for run in range(waiting.shape[0]):
        if waiting[run].fine == fine and count < WIDTH:
            lanes[count] = run
            count += 1
    for lane in range(count, WIDTH):
        lanes[lane] = lanes[0]
    return count


@cache
def build_asking(system: System, method: Method) -> wp.Function:
    """Make the function that lets runs that wait for nothing go on, each up to a turn that is to be followed."""
    until, columns_type = build_until(system, method), build_columns(system)

    @wp.func
    def asking(runs: columns_type, waiting: wp.array(dtype=Waiting)):
        for run in range(waiting.shape[0]):
            now = waiting[run]
            if now.fine == 0 and now.left > 0 and runs.progress[run].status == RUNNING:
                left, fine = until(runs, run, now.left)
                leap = runs.progress[run].leap
                now.left = left
                now.fine = fine
                now.spin = spin_at(runs.drives[run], leap.origin)
                now.start = leap.aim
                now.tail = runs.bounds[run].tail
                waiting[run] = now

    return asking


@cache
def build_advance_abreast(system: System, method: Method) -> wp.Kernel:
    """Make the kernel whose one thread lets each run of a batch try up to ``budget`` steps, as ``loop``'s does each."""
    asking, answered = build_asking(system, method), build_answered(system, True)
    turns_abreast, columns_type = build_turns_abreast(clear_of_walls(system)), build_columns(system)

    @wp.kernel(enable_backward=False, module="unique")
    def advance_abreast(
        runs: columns_type,
        budget: int,
        waiting: wp.array(dtype=Waiting),
        followed: wp.array(dtype=Followed),
        lanes: wp.array(dtype=wp.int32),
    ):
        for run in range(waiting.shape[0]):
            waiting[run].left = budget
            waiting[run].fine = 0
        asking(runs, waiting)
        fine = next_steps(waiting)
        while fine > 0:
            count = lined_up(waiting, fine, lanes)
            turns_abreast(runs.bodies, runs.drives, runs.magnets, waiting, followed, lanes, fine)
            for lane in range(count):
                run = lanes[lane]
                answered(runs, run, followed[run].turn, followed[run].shape, followed[run].roll)
                waiting[run].fine = 0
            asking(runs, waiting)
            fine = next_steps(waiting)

    return advance_abreast
