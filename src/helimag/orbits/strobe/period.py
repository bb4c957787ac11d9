"""Kernel of the stroboscopic map: states through part of one drive period in the frame that moves with the drive.

That frame turns with the yaw rate and moves with the velocity, and is the lab frame at t = 0. In it the arm stands
still, so the equations of motion depend on time through the magnet's spin alone and repeat after one turn of it.
"""

from functools import cache

import warp as wp

from helimag.engine import (
    KEPT,
    Control,
    Method,
    System,
    build_balance,
    build_load,
    lag_vector,
    shifted,
    to_lab,
    to_moving,
)
from helimag.physics.balance import SHEETS, Sheet, Swimmer, moment_of
from helimag.physics.kinematics import (
    ArmMotion,
    State,
    arm_instant,
    attack_angle,
    head_position,
    rotation_matrix,
    rpm_pose,
)
from helimag.physics.magnetics import FieldSource

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))


@wp.struct
class Measures:
    """What was seen over a passage, in the moving frame; means are over time."""

    position: wp.vec3d  # mean, m
    low: wp.float64  # lowest head, m
    high: wp.float64  # highest head, m
    attack: wp.float64  # mean attack angle, rad
    square: wp.float64  # mean of its square, rad^2
    cosine: wp.float64  # least, of the phase lag


@wp.struct
class Passage:
    """Which part of the period to pass, of which problem of the batch, in how many equal steps."""

    problem: wp.int32
    steps: wp.int32
    begin: wp.float64  # s
    end: wp.float64  # s


@wp.func
def with_step(m: Measures, weight: wp.float64, state: State, lag: wp.vec2d) -> Measures:
    """The measures with the end of one more step in them; ``weight`` is the step's share of the passage."""
    attack = attack_angle(state)
    m.position += weight * head_position(state)
    m.low = wp.min(m.low, state[2])
    m.high = wp.max(m.high, state[2])
    m.attack += weight * attack
    m.square += weight * attack * attack
    m.cosine = wp.min(m.cosine, lag[0] / wp.max(wp.length(lag), wp.float64(1e-300)))
    return m


@cache
def build_pass(system: System, method: Method, held: bool) -> wp.Kernel:
    """Make the kernel that takes each state of a batch through its passage; with ``held`` the head keeps its place.

    Equal steps and no error control: the result is then a smooth function of the state, so that differences of it are
    derivatives. A held head is put back after each step, in the moving frame.
    """
    load, balance, trial = build_load(system.magnet), build_balance(system.medium.response), method.build(system)
    surroundings_type, local = system.medium.surroundings_type, system.medium.local
    free = wp.constant(not held)

    @wp.kernel(enable_backward=False, module="unique")
    def pass_period(
        bodies: wp.array(dtype=Swimmer),
        surroundings: wp.array(dtype=surroundings_type),
        drives: wp.array(dtype=ArmMotion),
        magnets: wp.array2d(dtype=FieldSource),
        passages: wp.array(dtype=Passage),
        states: wp.array(dtype=State),
        results: wp.array(dtype=State),
        measures: wp.array(dtype=Measures),
    ):
        i = wp.tid()
        passage = passages[i]
        drive = drives[passage.problem]
        body = bodies[passage.problem]
        control = Control()
        control.tolerance = ONE
        control.length = ONE
        start = states[i]
        sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
        kept = wp.zeros(shape=KEPT, dtype=State)
        dt = (passage.end - passage.begin) / wp.float64(passage.steps)
        weight = ONE / wp.float64(passage.steps)
        state = to_lab(drive, passage.begin, start)
        moving = start
        m = Measures()
        m.low = start[2]
        m.high = start[2]
        m.cosine = ONE
        field, force = load(
            magnets[passage.problem], rpm_pose(drive, passage.begin), head_position(state), moment_of(body, state)
        )
        for k in range(passage.steps):
            t = passage.begin + wp.float64(k) * dt
            here = local(surroundings[passage.problem], head_position(state), rotation_matrix(state), sheets)
            k0 = balance(body, here, state, force, field)
            now = arm_instant(drive, t)
            state, error, within = trial(
                body, here, drive, magnets[passage.problem], control, now, dt, state, k0, kept, False
            )
            t += dt
            moving = to_moving(drive, t, state)
            if not free:
                slip = head_position(moving) - head_position(start)
                moving = shifted(moving, -slip)
                state = to_lab(drive, t, moving)
            field, force = load(
                magnets[passage.problem], rpm_pose(drive, t), head_position(state), moment_of(body, state)
            )
            m = with_step(m, weight, moving, lag_vector(field, state))
        results[i] = moving
        measures[i] = m

    return pass_period
