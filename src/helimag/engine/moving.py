"""The frame that moves with the drive: it yaws and travels with it, so that only the magnet's spin depends on time.

It is the lab frame at t = 0. In it the arm stands still, and the equations of motion repeat after one turn of the
magnet. Where the drive yaws it must not travel sideways: no such frame exists then.
"""

import warp as wp

from helimag.physics.kinematics import ArmMotion, State, head_position, normalized, turn_z

ONE = wp.constant(wp.float64(1.0))
HALF = wp.constant(wp.float64(0.5))


@wp.func
def turned(state: State, angle: wp.float64) -> State:
    """The state seen after rotating position and body about the lab's z axis by ``angle``."""
    p = turn_z(head_position(state), wp.cos(angle), wp.sin(angle))
    c = wp.cos(HALF * angle)
    s = wp.sin(HALF * angle)
    return State(
        p[0],
        p[1],
        p[2],
        c * state[3] - s * state[6],
        c * state[4] - s * state[5],
        c * state[5] + s * state[4],
        c * state[6] + s * state[3],
    )


@wp.func
def gone_on(before: State, way: State, after: State, share: wp.float64) -> State:
    """The state a share of a step on from ``after``, by the parabola from ``before``.

    ``way`` is how far the rates there would have led in that step.
    """
    reached = ONE + share
    return normalized(before + way * reached + (after - before - way) * (reached * reached))


@wp.func
def shifted(state: State, by: wp.vec3d) -> State:
    """The state with its head moved ``by`` (m)."""
    return State(state[0] + by[0], state[1] + by[1], state[2] + by[2], state[3], state[4], state[5], state[6])


@wp.func
def to_lab(drive: ArmMotion, t: wp.float64, state: State) -> State:
    """From the moving frame to the lab frame at time ``t``."""
    return shifted(turned(state, t * drive.yaw_rate), t * drive.velocity)


@wp.func
def to_moving(drive: ArmMotion, t: wp.float64, state: State) -> State:
    """From the lab frame at time ``t`` to the moving frame."""
    return turned(shifted(state, -t * drive.velocity), -t * drive.yaw_rate)


@wp.func
def frame_rates(drive: ArmMotion, state: State) -> State:
    """Rates that a state at rest in the lab has in the moving frame, to be added to those of its own motion."""
    yaw = drive.yaw_rate
    half = HALF * yaw
    return State(
        yaw * state[1] - drive.velocity[0],
        -yaw * state[0] - drive.velocity[1],
        -drive.velocity[2],
        half * state[6],
        half * state[5],
        -half * state[4],
        -half * state[3],
    )
