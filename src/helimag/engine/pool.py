"""Runs abreast: one thread leads all runs of a batch, and follows turns of the magnet for as many as a register holds.

Each run goes on by itself up to a turn that is to be followed for leaping. Turns with as many steps are followed
together, by what :mod:`helimag.engine.lanes` makes of the same functions; so a run's bits are those that it has alone.
"""

from functools import cache

import warp as wp

from helimag.engine.abreast import Followed, Waiting, build_turns_abreast
from helimag.engine.control import Control
from helimag.engine.events import Bounds
from helimag.engine.lanes import LANES
from helimag.engine.leaping import build_answered
from helimag.engine.leaps import spin_at
from helimag.engine.loop import RUNNING, build_until
from helimag.engine.methods import Method
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule
from helimag.engine.system import System, clear_of_walls
from helimag.engine.turn_memory import Memory
from helimag.engine.turns import FINEST
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion
from helimag.physics.magnetics import FieldSource

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
def build_advance_abreast(system: System, method: Method) -> wp.Kernel:
    """Make the kernel whose one thread lets each run of a batch try up to ``budget`` steps, as ``loop``'s does each."""
    clear = clear_of_walls(system)
    until, answered = build_until(system, method), build_answered(clear, True)
    turns_abreast, beyond = build_turns_abreast(clear), system.medium.beyond

    @wp.kernel(enable_backward=False, module="unique")
    def advance_abreast(
        bodies: wp.array(dtype=Swimmer),
        surroundings: wp.array(dtype=system.medium.surroundings_type),
        drives: wp.array(dtype=system.drive_type),
        magnets: wp.array2d(dtype=FieldSource),
        controls: wp.array(dtype=Control),
        bounds: wp.array(dtype=Bounds),
        schedules: wp.array(dtype=Schedule),
        budget: int,
        progress: wp.array(dtype=Progress),
        records: wp.array2d(dtype=Record),
        memory: Memory,
        waiting: wp.array(dtype=Waiting),
        followed: wp.array(dtype=Followed),
        lanes: wp.array(dtype=wp.int32),
    ):
        runs = progress.shape[0]
        for run in range(runs):
            waiting[run].left = budget
            waiting[run].fine = 0
        going = bool(True)
        while going:
            for run in range(runs):
                if waiting[run].fine == 0 and waiting[run].left > 0 and progress[run].status == RUNNING:
                    left, fine = until(
                        bodies,
                        surroundings,
                        drives,
                        magnets,
                        controls,
                        bounds,
                        schedules,
                        progress,
                        records,
                        memory,
                        run,
                        waiting[run].left,
                    )
                    now = Waiting()
                    now.left = left
                    now.fine = fine
                    now.spin = spin_at(drives[run], progress[run].leap.origin)
                    now.start = progress[run].leap.aim
                    now.tail = bounds[run].tail
                    waiting[run] = now
            fine = next_steps(waiting)
            going = fine > 0
            if going:
                count = lined_up(waiting, fine, lanes)
                turns_abreast(bodies, drives, magnets, waiting, followed, lanes, fine)
                for lane in range(count):
                    run = lanes[lane]
                    done = followed[run]
                    progress[run] = answered(
                        done.turn,
                        done.shape,
                        done.roll,
                        bodies[run],
                        beyond(surroundings[run]),
                        drives[run],
                        magnets[run],
                        controls[run],
                        bounds[run],
                        schedules[run],
                        memory,
                        run,
                        progress[run],
                        records,
                    )
                    waiting[run].fine = 0

    return advance_abreast
