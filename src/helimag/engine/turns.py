"""One turn of the magnet as a map, in the frame that moves with the drive: equal steps of DOP853, no trigonometry.

In that frame the arm stands still and only the magnet's spin depends on time. With equal steps a turn, the spin at
every stage is the spin at the step's start turned by an angle that is known when the kernel is built.
"""

import math
from functools import cache

import numpy as np
import warp as wp

from helimag.engine import tableau
from helimag.engine.moving import frame_rates, gone_on
from helimag.engine.poses import StageSpins, build_stage_spins, spin_ahead, spin_at_stage
from helimag.engine.stages import STAGES, Stages, weighted_sum
from helimag.engine.system import System, build_rates_at
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import (
    ArmMotion,
    RpmPose,
    State,
    head_position,
    normalized,
    rotation_matrix,
    rpm_rotation,
)
from helimag.physics.magnetics import FieldSource

NODES = 12  # phases of a turn at which its shape is kept: steps a turn are a multiple of it
FINEST = 5  # steps between two nodes at most; where more are needed, runs are stepped directly
ROLL_PER_STEP = 3.0  # at most, of a step times the rate at which the roll relaxes (DOP853 is stable up to about 6)
LEAST_STEPS_TOLERANCE = 3e-7  # of a step, which NODES steps a turn meet; others need its eighth root more
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
ZERO = wp.constant(wp.float64(0.0))
TINY = wp.constant(wp.float64(1e-300))
PER_NODE = wp.constant(wp.float64(2.0 * math.pi / NODES))
HALF_COSINE = wp.constant(wp.float64(math.cos(math.pi / NODES)))
HALF_SINE = wp.constant(wp.float64(math.sin(math.pi / NODES)))
NODE_ANGLES = np.arange(NODES) * 2.0 * math.pi / NODES
# cosine and sine of the angle at each node, and of half of it
AT_NODES = wp.constant(
    wp.types.matrix(shape=(NODES, 4), dtype=wp.float64)(
        *np.stack(
            [np.cos(NODE_ANGLES), np.sin(NODE_ANGLES), np.cos(NODE_ANGLES / 2.0), np.sin(NODE_ANGLES / 2.0)], axis=1
        )
        .ravel()
        .tolist()
    )
)
ROLL_SHARE = wp.constant(wp.float64(ROLL_PER_STEP))
ROLL_FACTOR = wp.constant(wp.float64(2e-7))  # twice mu0 / (4 pi), T m/A: the field on the axis of a dipole

Nodes = wp.types.vector(length=NODES, dtype=wp.float64)
Shape = wp.types.matrix(shape=(NODES, 7), dtype=wp.float64)


@wp.struct
class Turn:
    """What a turn of the magnet did, moving frame."""

    end: State  # with the roll of the turn itself taken off, so that a device in step comes back to where it was
    cosine: wp.float64  # least, of the phase lag
    lag: wp.vec2d  # at the end, see ``synchrony``
    reach: wp.float64  # furthest from the start, of head or of the tail's end, m


@wp.func
def rolled(state: State, c: wp.float64, s: wp.float64) -> State:
    """The state with the body turned about its long axis, by the angle whose half has this cosine and sine."""
    w = state[3]
    x = state[4]
    y = state[5]
    z = state[6]
    return State(state[0], state[1], state[2], c * w - s * x, c * x + s * w, c * y + s * z, c * z - s * y)


@wp.func
def arm_pose(drive: ArmMotion, spin: wp.vec2d) -> RpmPose:
    """The RPM's pose in the moving frame, where the arm stands still."""
    pose = RpmPose()
    pose.position = drive.arm
    pose.rotation = rpm_rotation(ONE, ZERO, drive.cos_pitch, drive.sin_pitch)
    pose.spin = spin
    return pose


@wp.func
def steps_between_nodes(
    body: Swimmer, drive: ArmMotion, magnets: wp.array(dtype=FieldSource), contact: wp.float64, least: int, state: State
) -> int:
    """Steps between two nodes that follow the roll, which relaxes the faster the nearer the magnet is."""
    rotation = rpm_rotation(ONE, ZERO, drive.cos_pitch, drive.sin_pitch)
    rate = ZERO
    for j in range(magnets.shape[0]):
        gap = wp.max(wp.length(head_position(state) - drive.arm - rotation * magnets[j].offset), HALF * contact)
        rate += wp.abs(magnets[j].moment) / (gap * gap * gap)
    rate *= ROLL_FACTOR * body.magnetic_moment * body.mobility[3, 3]
    return wp.max(least, int(wp.ceil(rate * PER_NODE / (wp.abs(drive.spin_rate) * ROLL_SHARE))))


@cache
def build_moving_rates(system: System) -> wp.Function:
    """Make the right-hand side in the moving frame: rates of a state, and its lag vector, at a spin of the magnet."""
    here_type = system.medium.here_type
    rates_at = build_rates_at(system)

    @wp.func
    def rates(
        body: Swimmer,
        here: here_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        spin: wp.vec2d,
        state: State,
    ):
        found, lag = rates_at(body, here, magnets, arm_pose(drive, spin), state)
        return found + frame_rates(drive, state), lag

    return rates


@cache
def build_spun_step(system: System) -> wp.Function:
    """Make DOP853's step of ``h`` (s) in the moving frame, over which the spin turns as ``spins`` has it."""
    rates, here_type = build_moving_rates(system), system.medium.here_type
    argument = [None] + [weighted_sum(tableau.A[i, :i]) for i in range(1, STAGES)]
    result = weighted_sum(tableau.B)

    @wp.func
    def step(
        body: Swimmer,
        here: here_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        spin: wp.vec2d,
        spins: StageSpins,
        h: wp.float64,
        state: State,
        k0: State,
    ) -> State:
        k = Stages()
        k[0] = k0
        for i in range(1, STAGES):
            stage = state + h * wp.static(argument[i])(k)
            at = spin_at_stage(spin, spins, i)
            there, lag = rates(body, here, drive, magnets, at, stage)
            k[i] = there
        return normalized(state + h * result(k))

    return step


@cache
def build_part_step(system: System) -> wp.Function:
    """Make the function that takes one of ``fine`` equal steps by which the spin turns by ``angle`` in all.

    It returns the state after it, the middle of the next such step, and the spin there.
    """
    rates, step, stage_spins = build_moving_rates(system), build_spun_step(system), build_stage_spins()
    here_type = system.medium.here_type

    @wp.func
    def part_step(
        body: Swimmer,
        here: here_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        spin: wp.vec2d,
        fine: int,
        angle: wp.float64,
        state: State,
    ):
        part = angle / wp.float64(fine)
        h = part / wp.abs(drive.spin_rate)
        spins = stage_spins(wp.sign(drive.spin_rate) * part)
        k0, lag = rates(body, here, drive, magnets, spin, state)
        new = step(body, here, drive, magnets, spin, spins, h, state, k0)
        return new, gone_on(state, h * k0, new, HALF), spin_at_stage(spin, spins, STAGES)

    return part_step


@cache
def build_part_turn(system: System) -> wp.Function:
    """Make the function that goes on from a node by an angle of the spin that is less than to the next."""
    part_step, around_type, local = build_part_step(system), system.medium.surroundings_type, system.medium.local

    @wp.func
    def part_turn(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        spin_at_node: wp.vec2d,
        fine: int,
        angle: wp.float64,
        begin: State,
    ) -> State:
        spin = spin_at_node
        sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
        state = begin
        middle = begin
        for _ in range(fine):
            here = local(around, head_position(middle), rotation_matrix(middle), sheets)
            state, middle, spin = part_step(body, here, drive, magnets, spin, fine, angle, state)
        return state

    return part_turn


@wp.func
def spin_at_node(drive: ArmMotion, spin_at_start: wp.vec2d, node: int) -> wp.vec2d:
    """Cosine and sine of the magnet's spin at a node of a turn."""
    return spin_ahead(spin_at_start, AT_NODES[node, 0], wp.sign(drive.spin_rate) * AT_NODES[node, 1])


@wp.func
def rolled_to_node(state: State, roll: wp.float64, node: int) -> State:
    """The state after the body rolled from a turn's start to a node, ``roll`` (1 or -1) telling which way."""
    return rolled(state, AT_NODES[node, 2], roll * AT_NODES[node, 3])


@wp.func
def tail_end(state: State, tail: wp.float64) -> wp.vec3d:
    """Where the helix ends (m), ``tail`` behind the head's centre."""
    rotation = rotation_matrix(state)
    return head_position(state) - tail * wp.vec3d(rotation[0, 0], rotation[1, 0], rotation[2, 0])


@wp.func
def about_axis(old: State, new: State) -> wp.float64:
    """Sine of half the angle by which the body rolled about its long axis from one state to the next."""
    return old[3] * new[4] - old[4] * new[3] - old[5] * new[6] + old[6] * new[5]


@cache
def build_again(system: System) -> wp.Function:
    """Make the function that asks a medium what is around a place, or recalls it, see :class:`Medium`."""
    if system.medium.again is not None:
        return system.medium.again
    around_type, here_type, local = system.medium.surroundings_type, system.medium.here_type, system.medium.local

    @wp.func
    def again(
        around: around_type,
        position: wp.vec3d,
        rotation: wp.mat33d,
        sheets: wp.array2d(dtype=Sheet),
        look: int,
        known: int,  # noqa: ARG001 - never so, or asked anew
    ) -> here_type:
        return local(around, position, rotation, sheets[look])

    return again


@cache
def build_set_out(system: System) -> wp.Function:
    """Make the function that looks around for a turn's first step of ``h`` (s): surroundings, rates and lag vector.

    No step before it tells where it goes, so rates where it begins do, once they are known.
    """
    rates, around_type = build_moving_rates(system), system.medium.surroundings_type
    here_type, again = system.medium.here_type, build_again(system)

    @wp.func
    def set_out(
        body: Swimmer,
        around: around_type,
        sheets: wp.array2d(dtype=Sheet),
        known: int,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        spin: wp.vec2d,
        h: wp.float64,
        state: State,
    ):
        here = here_type()
        k0 = State()
        lag = wp.vec2d()
        middle = state
        looks = 2 - known  # not unrolled, so that it compiles sooner
        for _ in range(looks):
            here = again(around, head_position(middle), rotation_matrix(middle), sheets, 0, known)
            k0, lag = rates(body, here, drive, magnets, spin, state)
            middle = normalized(state + HALF * h * k0)
        return here, k0, lag

    return set_out


@cache
def build_turn(system: System) -> wp.Function:
    """Make the map over one turn of the magnet: what it does, and its shape at the nodes, its last row the end.

    What is around the device is looked up about the middle of each step. ``sheets`` keep that, the last look after each
    node on a row; where ``known`` (1, else 0) it is recalled, for which there must be one step between two nodes.
    """
    rates, step, stage_spins = build_moving_rates(system), build_spun_step(system), build_stage_spins()
    set_out, around_type, again = build_set_out(system), system.medium.surroundings_type, build_again(system)

    @wp.func
    def turn(
        body: Swimmer,
        around: around_type,
        sheets: wp.array2d(dtype=Sheet),
        known: int,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        tail: wp.float64,
        spin_at_start: wp.vec2d,
        fine: int,
        start: State,
    ):
        h = PER_NODE / (wp.abs(drive.spin_rate) * wp.float64(fine))
        spins = stage_spins(drive.spin_rate * h)
        half = wp.vec2d(ONE, ZERO)  # cosine and sine of half the angle to a node
        state = normalized(start)
        begin = state
        spin = spin_at_start
        shape = Shape()
        result = Turn()
        result.cosine = ONE
        here, k0, lag = set_out(body, around, sheets, known, drive, magnets, spin, h, state)
        left = NODES * fine
        roll = wp.float64(1.0)
        nodes = int(NODES)  # not unrolled: a step is much code
        for node in range(nodes):
            for _ in range(fine):
                new = step(body, here, drive, magnets, spin, spins, h, state, k0)
                middle = gone_on(state, h * k0, new, HALF)
                left -= 1
                if left > 0:
                    look = (NODES * fine - left) // fine
                    here = again(around, head_position(middle), rotation_matrix(middle), sheets, look, known)
                state = new
                spin = spin_at_stage(spin, spins, STAGES)
                k0, lag = rates(body, here, drive, magnets, spin, state)
                result.cosine = wp.min(result.cosine, lag[0] / wp.max(wp.length(lag), TINY))
            if node == 0:
                roll = wp.where(about_axis(begin, state) < ZERO, -ONE, ONE)
            half = spin_ahead(half, HALF_COSINE, HALF_SINE)
            seen = rolled(state, half[0], -roll * half[1])
            moved = wp.max(
                wp.length(head_position(seen) - head_position(begin)),
                wp.length(tail_end(seen, tail) - tail_end(begin, tail)),
            )
            result.reach = wp.max(result.reach, moved)
            for i in range(7):
                shape[node, i] = seen[i]
            result.end = seen
            result.lag = lag
        return result, shape, roll

    return turn
