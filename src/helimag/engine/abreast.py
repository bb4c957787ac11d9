"""Steps, turns and parts of turns, taken for as many as a vector register holds, by :mod:`helimag.engine.lanes`."""

from functools import cache

import warp as wp

from helimag.engine.attempts import Aim, Tried, build_tried
from helimag.engine.control import Control
from helimag.engine.events import Bounds
from helimag.engine.lanes import LANES, MOST_MAGNETS_IN_LANES, Translation, arrays_in, numbers_in
from helimag.engine.methods import Method
from helimag.engine.stages import STAGES
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
    fine: wp.int32  # steps between two nodes; none where no turn is to be followed, or IN_A_LANE
    spin: wp.vec2d  # cosine and sine, where it begins
    start: State
    tail: wp.float64  # m


@wp.struct
class Followed:
    """A turn that was followed."""

    turn: Turn
    shape: Shape
    roll: wp.float64


def crew_room() -> int:
    """How many numbers :func:`build_steps_abreast` keeps of the runs in lanes, with room to align them."""
    kinds = (Swimmer, ArmMotion, Control, Bounds, *(FieldSource,) * MOST_MAGNETS_IN_LANES)
    return LANES * (2 + sum(1 for kind in kinds for _ in numbers_in(kind)))


def _sources(source: str) -> str:
    """C++ for magnets in lanes, which functions take for the array that they are written for."""
    return (
        f"struct Sources {{ int shape[1]; {source} at[{MOST_MAGNETS_IN_LANES}]; "
        f"const {source}& operator[](int j) const {{ return at[j]; }} }};"
    )


def _gathered(name: str, kind: object, one: str) -> str:
    """C++ that puts a structure's numbers into lanes, from ``one`` that lane ``l`` has."""
    lines = []
    for path, number in numbers_in(kind):
        taken = f"in_lanes([&](int l) {{ return {one}{path}; }})" if number is wp.float64 else f"{one}{path}"
        lines.append(f"{name}{path} = {taken};")
    for path, rows in arrays_in(kind):
        each = " ".join(
            f"{name}{path}.at[i]{rest} = in_lanes([&](int l) {{ return wp::index({one}{path}, i){rest}; }});"
            for rest, _ in numbers_in(rows)
        )
        lines.append(f"for (int i = 0; i < {one}{path}.shape[0]; ++i) {{ {each} }}")
    return f"{{ constexpr int l = 0; {' '.join(lines)} }}"


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
{_gathered("body", Swimmer, "bodies.data[lanes.data[l]]")}
{_gathered("drive", ArmMotion, "drives.data[lanes.data[l]]")}
{_gathered("asked", Waiting, "waiting.data[lanes.data[l]]")}
for (int j = 0; j < rpm.shape[0]; ++j)
    {_gathered("rpm.at[j]", FieldSource, "magnets.data[lanes.data[l] * rpm.shape[0] + j]")}
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
def build_steps_abreast(system: System, method: Method) -> wp.Function:
    """Make the function that tries a step for the run in each lane.

    What the runs are is put into lanes where they are other runs (``anew``, 1 or else 0) than the last time, and kept
    in ``crew_room``. Where one of them is to ``keep`` its stages (1, else 0), all do.
    """
    said = Translation()
    tried = said.function(build_tried(system, method))
    kinds = (Swimmer, ArmMotion, FieldSource, Control, Bounds, Aim, system.medium.here_type, wp.array(dtype=State))
    swimmer, motion, source, keeping, ends, aimed, near, rows = (said.structure(kind) for kind in kinds)
    scattered = " ".join(f"one{path} = all{path}[l];" for path, _ in numbers_in(Tried))
    snippet = f"""{said.text}
{_sources(source)}
struct Crew {{ {swimmer} body; {motion} drive; {keeping} control; {ends} bound; Sources rpm; }};
Crew& crew = *(Crew*)((unsigned long long)(crew_room.data + 7) / 64 * 64);
if (anew) {{
    crew.rpm.shape[0] = magnets.shape[1];
    {_gathered("crew.body", Swimmer, "bodies.data[lanes.data[l]]")}
    {_gathered("crew.drive", ArmMotion, "drives.data[lanes.data[l]]")}
    {_gathered("crew.control", Control, "controls.data[lanes.data[l]]")}
    {_gathered("crew.bound", Bounds, "bounds.data[lanes.data[l]]")}
    for (int j = 0; j < crew.rpm.shape[0]; ++j)
        {_gathered("crew.rpm.at[j]", FieldSource, "magnets.data[lanes.data[l] * crew.rpm.shape[0] + j]")}
}}
{aimed} aim; {near} here; {rows} stages;
{_gathered("aim", Aim, "aims.data[lanes.data[l]]")}
const auto all = {tried}(crew.body, here, crew.drive, crew.rpm, crew.control, crew.bound, aim, stages, keep);
for (int l = 0; l < {LANES}; ++l) {{
    const int run = lanes.data[l];
    auto& one = tries.data[run];
    {scattered}
    if (keep)
        for (int i = 0; i < {STAGES}; ++i)
            for (int c = 0; c < 7; ++c) wp::index(kept, run, i).c[c] = stages.at[i].c[c][l];
}}
"""

    @wp.func_native(snippet)
    def steps_abreast(
        bodies: wp.array(dtype=Swimmer),
        drives: wp.array(dtype=ArmMotion),
        magnets: wp.array2d(dtype=FieldSource),
        controls: wp.array(dtype=Control),
        bounds: wp.array(dtype=Bounds),
        aims: wp.array(dtype=Aim),
        tries: wp.array(dtype=Tried),
        kept: wp.array2d(dtype=State),
        lanes: wp.array(dtype=wp.int32),
        crew_room: wp.array(dtype=wp.float64),
        anew: int,
        keep: int,
    ): ...

    return steps_abreast


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
{_gathered("all_body", Swimmer, "body")}
{_gathered("all_drive", ArmMotion, "drive")}
{_gathered("all_here", here_type, "heres.data[l]")}
for (int j = 0; j < rpm.shape[0]; ++j)
    {_gathered("rpm.at[j]", FieldSource, "magnets.data[j]")}
for (int l = 0; l < {LANES}; ++l) {{
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
