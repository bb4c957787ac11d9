"""Turns, and parts of turns, followed for as many as a vector register holds, by :mod:`helimag.engine.lanes`."""

from functools import cache

import warp as wp

from helimag.engine.lanes import LANES, MOST_MAGNETS_IN_LANES, Translation, numbers_in
from helimag.engine.system import System
from helimag.engine.turns import Shape, Turn, build_part_turn, build_turn
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, State
from helimag.physics.magnetics import FieldSource

States = wp.types.matrix(shape=(LANES, 7), dtype=wp.float64)  # of as many as there are lanes
Spins = wp.types.matrix(shape=(LANES, 2), dtype=wp.float64)
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


@cache
def build_parts_abreast(system: System) -> wp.Function:
    """Make the function that goes on from a node of a turn in each lane, all of one run, to somewhere before the next.

    It takes the run, ``fine`` and for each lane spin and state at the node, and by which angle to go on.
    """
    said = Translation()
    part_turn = said.function(build_part_turn(system))
    kinds = (Swimmer, ArmMotion, FieldSource, system.medium.surroundings_type)
    swimmer, motion, source, around = (said.structure(kind) for kind in kinds)
    snippet = f"""{said.text}
{_sources(source)}
{swimmer} all_body; {motion} all_drive; {around} all_around; Sources rpm;
wp::vec_t<7, Lanes> begin; wp::vec_t<2, Lanes> spin; Lanes angle;
rpm.shape[0] = magnets.shape[0];
for (int l = 0; l < {LANES}; ++l) {{
    {_gathered("all_body", Swimmer, "body")}
    {_gathered("all_drive", ArmMotion, "drive")}
    for (int j = 0; j < rpm.shape[0]; ++j)
        {_gathered("rpm.at[j]", FieldSource, "magnets.data[j]")}
    for (int i = 0; i < 7; ++i) begin.c[i][l] = begins.data[l][i];
    for (int i = 0; i < 2; ++i) spin.c[i][l] = spins.data[l][i];
    angle[l] = angles.c[l];
}}
const auto found = {part_turn}(all_body, all_around, all_drive, rpm, spin, fine, angle, begin);
wp::mat_t<{LANES}, 7, wp::float64> ends;
for (int l = 0; l < {LANES}; ++l)
    for (int i = 0; i < 7; ++i) ends.data[l][i] = found.c[i][l];
return ends;
"""

    @wp.func_native(snippet)
    def parts_abreast(
        body: Swimmer,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        fine: int,
        spins: Spins,
        angles: Angles,
        begins: States,
    ) -> States: ...

    return parts_abreast
