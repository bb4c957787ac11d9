"""Runs abreast: one thread leads all runs of a batch, and follows turns of the magnet for as many as a register holds.

Each run goes on by itself up to a turn that is to be followed for leaping. Turns with as many steps are followed
together, by what :mod:`helimag.engine.lanes` makes of the same functions; so a run's bits are those that it has alone.
"""

from functools import cache

import warp as wp

from helimag.engine.batch import MOST_MAGNETS_ABREAST
from helimag.engine.control import Control
from helimag.engine.events import Bounds
from helimag.engine.lanes import LANES, Translation, numbers_in
from helimag.engine.leaping import build_answered
from helimag.engine.leaps import spin_at
from helimag.engine.loop import RUNNING, build_until
from helimag.engine.methods import Method
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule
from helimag.engine.system import System, clear_of_walls
from helimag.engine.turn_memory import Memory
from helimag.engine.turns import FINEST, Shape, Turn, build_turn
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State
from helimag.physics.magnetics import FieldSource

WIDTH = wp.constant(LANES)
MOST_STEPS = wp.constant(2 * FINEST)  # between two nodes of a turn


@wp.struct
class Waiting:
    """What a run stands at: what it may still try in this launch, and the turn that is to be followed for it."""

    left: wp.int32  # steps
    fine: wp.int32  # steps between two nodes; none where no turn is to be followed
    spin: wp.vec2d  # cosine and sine, where it begins
    start: State
    tail: wp.float64  # m


@wp.struct
class Followed:
    """A turn that was followed."""

    turn: Turn
    shape: Shape
    roll: wp.float64


def room(runs: int) -> list[wp.array]:
    """Room for what the kernel keeps of each run between a turn's start and its end, and for who is in which lane."""
    kinds = ((runs, Waiting), (runs, Followed), (LANES, wp.int32))
    return [wp.zeros(count, dtype=kind, device="cpu") for count, kind in kinds]


def _gathered(name: str, kind: object, array: str, at: str) -> str:
    """C++ that puts the numbers of a structure of eight runs into lanes."""
    lines = [
        f"{name}{path}[l] = one{path};" if number is wp.float64 else f"{name}{path} = one{path};"
        for path, number in numbers_in(kind)
    ]
    return f"{{ const auto& one = {array}.data[{at}]; {' '.join(lines)} }}"


@cache
def build_turns_abreast(system: System) -> wp.Function:
    """Make the function that follows a turn for the run in each lane, ``fine`` steps between two nodes."""
    said = Translation()
    turn = said.function(build_turn(system))
    kinds = (Swimmer, ArmMotion, FieldSource, Waiting, Followed, system.medium.surroundings_type)
    swimmer, motion, source, asked, result, around = (said.structure(kind) for kind in kinds)
    scattered = " ".join(f"one{path} = all{path}[l];" for path, _ in numbers_in(Followed))
    snippet = f"""{said.text}
struct Sources {{ int shape[1]; {source} at[{MOST_MAGNETS_ABREAST}]; const {source}& operator[](int j) const {{ return at[j]; }} }};
{swimmer} body; {motion} drive; {asked} asked; {around} around; Sources rpm;
rpm.shape[0] = magnets.shape[1];
for (int l = 0; l < {LANES}; ++l) {{
    const int run = lanes.data[l];
    {_gathered("body", Swimmer, "bodies", "run")}
    {_gathered("drive", ArmMotion, "drives", "run")}
    {_gathered("asked", Waiting, "waiting", "run")}
    for (int j = 0; j < rpm.shape[0]; ++j)
        {_gathered("rpm.at[j]", FieldSource, "magnets", "run * rpm.shape[0] + j")}
}}
const auto found = {turn}(body, around, drive, rpm, asked.tail, asked.spin, fine, asked.start);
const {result} all{{found.r0, found.r1, found.r2}};
for (int l = 0; l < {LANES}; ++l) {{ auto& one = followed.data[lanes.data[l]]; {scattered} }}
"""

    @wp.func_native(snippet)
    def turns_abreast(
        bodies: wp.array(dtype=Swimmer),
        drives: wp.array(dtype=ArmMotion),
        magnets: wp.array2d(dtype=FieldSource),
        waiting: wp.array(dtype=Waiting),
        followed: wp.array(dtype=Followed),
        lanes: wp.array(dtype=wp.int32),
        fine: int,
    ): ...

    return turns_abreast


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
    until, answered = build_until(system, method), build_answered(clear)
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
