"""Turns, and parts of turns, followed for as many as a vector register holds, by :mod:`helimag.engine.lanes`."""

from functools import cache

import warp as wp

from helimag.engine.lanes import LANES, MOST_MAGNETS_IN_LANES, Translation, arrays_in, numbers_in
from helimag.engine.system import System
from helimag.engine.turns import Shape, Turn, build_part_step, build_turn
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import ArmMotion, State, head_position, rotation_matrix
from helimag.physics.magnetics import FieldSource

# of as many as there are lanes: a state, the middle of the step that comes next, and cosine and sine of the spin
Ways = wp.types.matrix(shape=(LANES, 16), dtype=wp.float64)
Angles = wp.types.vector(length=LANES, dtype=wp.float64)


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


def _sources(source: str) -> str:
    """C++ for magnets in lanes, which functions take for the array that they are written for."""
    return (
        f"struct Sources {{ int shape[1]; {source} at[{MOST_MAGNETS_IN_LANES}]; "
        f"const {source}& operator[](int j) const {{ return at[j]; }} }};"
    )


def _gathered(name: str, kind: object, one: str) -> str:
    """C++ that puts a structure's numbers into lane ``l``."""
    lines = [
        f"{name}{path}[l] = one{path};" if number is wp.float64 else f"{name}{path} = one{path};"
        for path, number in numbers_in(kind)
    ]
    for path, rows in arrays_in(kind):
        each = " ".join(f"{name}{path}.at[i]{rest}[l] = row{rest};" for rest, _ in numbers_in(rows))
        ranges = f"for (int i = 0; i < one{path}.shape[0]; ++i)"
        lines.append(f"{ranges} {{ const auto& row = wp::index(one{path}, i); {each} }}")
    return f"{{ const auto& one = {one}; {' '.join(lines)} }}"


@cache
def build_turns_abreast(system: System) -> wp.Function:
    """Make the function that follows a turn for the run in each lane, ``fine`` steps between two nodes."""
    said = Translation()
    turn = said.function(build_turn(system))
    kinds = (Swimmer, ArmMotion, FieldSource, Waiting, Followed, system.medium.surroundings_type)
    swimmer, motion, source, asked, result, around = (said.structure(kind) for kind in kinds)
    scattered = " ".join(f"one{path} = all{path}[l];" for path, _ in numbers_in(Followed))
    snippet = f"""{said.text}
{_sources(source)}
{swimmer} body; {motion} drive; {asked} asked; {around} around; Sources rpm;
rpm.shape[0] = magnets.shape[1];
for (int l = 0; l < {LANES}; ++l) {{
    const int run = lanes.data[l];
    {_gathered("body", Swimmer, "bodies.data[run]")}
    {_gathered("drive", ArmMotion, "drives.data[run]")}
    {_gathered("asked", Waiting, "waiting.data[run]")}
    for (int j = 0; j < rpm.shape[0]; ++j)
        {_gathered("rpm.at[j]", FieldSource, "magnets.data[run * rpm.shape[0] + j]")}
}}
const auto found = {turn}(body, around, 0, 0, drive, rpm, asked.tail, asked.spin, fine, asked.start);
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


@cache
def build_part_steps_abreast(system: System) -> wp.Function:
    """Make the function that takes a step of a part of a turn in each lane, all of one run.

    It takes the run, what is around it in each lane, ``fine``, and for each lane by which angle to go on in all, and
    the way so far, see :func:`helimag.engine.turns.build_part_step`.
    """
    said = Translation()
    part_step, here_type = said.function(build_part_step(system)), system.medium.here_type
    swimmer, motion, source, near = (said.structure(kind) for kind in (Swimmer, ArmMotion, FieldSource, here_type))
    snippet = f"""{said.text}
{_sources(source)}
{swimmer} all_body; {motion} all_drive; {near} all_here; Sources rpm;
wp::vec_t<7, Lanes> state; wp::vec_t<2, Lanes> spin; Lanes angle;
rpm.shape[0] = magnets.shape[0];
for (int l = 0; l < {LANES}; ++l) {{
    {_gathered("all_body", Swimmer, "body")}
    {_gathered("all_drive", ArmMotion, "drive")}
    {_gathered("all_here", here_type, "heres.data[l]")}
    for (int j = 0; j < rpm.shape[0]; ++j)
        {_gathered("rpm.at[j]", FieldSource, "magnets.data[j]")}
    for (int i = 0; i < 7; ++i) state.c[i][l] = ways.data[l][i];
    for (int i = 0; i < 2; ++i) spin.c[i][l] = ways.data[l][14 + i];
    angle[l] = angles.c[l];
}}
const auto found = {part_step}(all_body, all_here, all_drive, rpm, spin, fine, angle, state);
wp::mat_t<{LANES}, 16, wp::float64> after;
for (int l = 0; l < {LANES}; ++l) {{
    for (int i = 0; i < 7; ++i) after.data[l][i] = found.r0.c[i][l];
    for (int i = 0; i < 7; ++i) after.data[l][7 + i] = found.r1.c[i][l];
    for (int i = 0; i < 2; ++i) after.data[l][14 + i] = found.r2.c[i][l];
}}
return after;
"""

    @wp.func_native(snippet)
    def part_steps_abreast(
        body: Swimmer,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        heres: wp.array(dtype=here_type),
        fine: int,
        angles: Angles,
        ways: Ways,
    ) -> Ways: ...

    return part_steps_abreast


@wp.func
def state_in(ways: Ways, lane: int, first: int) -> State:
    """The state in a lane of ways: where a step ends, or from 7 on the middle of the next."""
    state = State()
    for i in range(7):
        state[i] = ways[lane, first + i]
    return state


@cache
def build_parts_abreast(system: System) -> wp.Function:
    """Make the function that goes on from a node of a turn in each lane, all of one run, to somewhere before the next.

    It takes the run, ``fine`` and for each lane by which angle to go on, and state, state again and spin at the node;
    ``most`` lanes from the first on are of use.
    """
    part_steps, medium = build_part_steps_abreast(system), system.medium
    local, around_type, here_type = medium.local, medium.surroundings_type, medium.here_type

    @wp.func
    def parts_abreast(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        fine: int,
        most: int,
        angles: Angles,
        begins: Ways,
    ) -> Ways:
        ways = begins
        sheets = wp.zeros(shape=(LANES, SHEETS), dtype=Sheet)
        heres = wp.zeros(shape=LANES, dtype=here_type)
        here = here_type()
        lanes = int(LANES)
        for _ in range(fine):
            for lane in range(lanes):
                if lane < most:
                    middle = state_in(ways, lane, 7)
                    here = local(around, head_position(middle), rotation_matrix(middle), sheets[lane])
                heres[lane] = here
            ways = part_steps(body, drive, magnets, heres, fine, angles, ways)
        return ways

    return parts_abreast
