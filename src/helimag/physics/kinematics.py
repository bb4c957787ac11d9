"""Where the rotating permanent magnet (RPM) is, which way it points, and how a body frame turns.

Equations (1) to (3) of the paper, with the conventions of ``docs/conventions.md``. Every formula is a Warp function:
kernels inline it, and Python may call it with Warp values (``wp.vec3d``, ``wp.float64``) or over arrays with
:func:`helimag.physics.evaluate`.
"""

import warp as wp

HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))
ZERO = wp.constant(wp.float64(0.0))

# position of the head (3), then quaternion w, x, y, z rotating body to lab: the order of every state in helimag
State = wp.types.vector(length=7, dtype=wp.float64)


@wp.struct
class ArmMotion:
    """What the arm does with the magnet, reduced to what the kernels need (all SI and radians).

    ``arm`` is the RPM's position at t = 0 after pitch has acted on it, so both readings of pitch (about the lab origin
    or about the magnet) are the same kernel.
    """

    arm: wp.vec3d
    velocity: wp.vec3d
    yaw_rate: wp.float64
    spin_rate: wp.float64
    cos_pitch: wp.float64
    sin_pitch: wp.float64


@wp.func
def turn_z(v: wp.vec3d, cos_angle: wp.float64, sin_angle: wp.float64) -> wp.vec3d:
    """Rotate ``v`` about the z axis by the angle of this cosine and sine: R_z of eq. (3)."""
    return wp.vec3d(cos_angle * v[0] - sin_angle * v[1], sin_angle * v[0] + cos_angle * v[1], v[2])


@wp.struct
class RpmPose:
    """The RPM at one instant, lab frame."""

    position: wp.vec3d  # m
    spin: wp.vec2d  # cosine and sine of the angle that the moment has turned about the rotation axis
    rotation: wp.mat33d  # R_a of eq. (3): arm frame to lab; its first column is the rotation axis


@wp.func
def rpm_rotation(cos_yaw: wp.float64, sin_yaw: wp.float64, cos_pitch: wp.float64, sin_pitch: wp.float64) -> wp.mat33d:
    """R_a = R_z(yaw) R_y(-pitch), eq. (3), from cosines and sines: a positive pitch lifts the x axis."""
    return wp.mat33d(
        cos_yaw * cos_pitch,
        -sin_yaw,
        -cos_yaw * sin_pitch,
        sin_yaw * cos_pitch,
        cos_yaw,
        -sin_yaw * sin_pitch,
        sin_pitch,
        ZERO,
        cos_pitch,
    )


@wp.struct
class Instant:
    """What a time comes to for a drive."""

    time: wp.float64  # s
    yaw: wp.vec2d  # cosine and sine, where the drive turns evenly
    spin: wp.vec2d


@wp.func
def arm_instant(drive: ArmMotion, t: wp.float64) -> Instant:
    """What ``t`` (s) comes to for a drive that turns evenly."""
    yaw = drive.yaw_rate * t
    spin = drive.spin_rate * t
    return Instant(t, wp.vec2d(wp.cos(yaw), wp.sin(yaw)), wp.vec2d(wp.cos(spin), wp.sin(spin)))


@wp.func
def arm_pose_at(drive: ArmMotion, instant: Instant) -> RpmPose:
    """Pose of the RPM at an instant, eqs (1)-(3)."""
    yaw = instant.yaw
    pose = RpmPose()
    pose.rotation = rpm_rotation(yaw[0], yaw[1], drive.cos_pitch, drive.sin_pitch)
    pose.position = turn_z(drive.arm, yaw[0], yaw[1]) + instant.time * drive.velocity
    pose.spin = instant.spin
    return pose


@wp.func
def rpm_pose(drive: ArmMotion, t: wp.float64) -> RpmPose:
    """Pose of the RPM at time ``t`` (s)."""
    return arm_pose_at(drive, arm_instant(drive, t))


# x, y, z (m), yaw, pitch, and what the spin is ahead of an even one (rad)
Knot = wp.types.vector(length=6, dtype=wp.float64)


@wp.struct
class SampledMotion:
    """A path through samples: cubic pieces between times, the coefficient of the highest power first (SI, radians)."""

    times: wp.array(dtype=wp.float64)  # (n,)
    pieces: wp.array2d(dtype=Knot)  # (n - 1, 4)
    spin_rate: wp.float64


@wp.func
def sampled_rpm_pose(drive: SampledMotion, t: wp.float64) -> RpmPose:
    """Pose of the RPM at time ``t`` (s) on a sampled path; the rotation by eq. (3) from its yaw and pitch."""
    last = drive.times.shape[0] - 2
    i = wp.clamp(wp.lower_bound(drive.times, t) - 1, 0, last)
    s = t - drive.times[i]
    knot = drive.pieces[i, 3] + s * (drive.pieces[i, 2] + s * (drive.pieces[i, 1] + s * drive.pieces[i, 0]))
    spin = drive.spin_rate * t + knot[5]
    pose = RpmPose()
    pose.rotation = rpm_rotation(wp.cos(knot[3]), wp.sin(knot[3]), wp.cos(knot[4]), wp.sin(knot[4]))
    pose.position = wp.vec3d(knot[0], knot[1], knot[2])
    pose.spin = wp.vec2d(wp.cos(spin), wp.sin(spin))
    return pose


@wp.func
def rotation_matrix(state: State) -> wp.mat33d:
    """Matrix that takes body components to lab components, from the quaternion held in ``state[3:7]`` (w, x, y, z)."""
    w = state[3]
    x = state[4]
    y = state[5]
    z = state[6]
    return wp.mat33d(
        ONE - TWO * (y * y + z * z),
        TWO * (x * y - w * z),
        TWO * (x * z + w * y),
        TWO * (x * y + w * z),
        ONE - TWO * (x * x + z * z),
        TWO * (y * z - w * x),
        TWO * (x * z - w * y),
        TWO * (y * z + w * x),
        ONE - TWO * (x * x + y * y),
    )


@wp.func
def state_rates(state: State, velocity: wp.vec3d, body_spin: wp.vec3d) -> State:
    """Rates of a state: lab velocity of the head (m/s); q' = q (0, omega) / 2 with omega in the body frame (rad/s)."""
    w = state[3]
    x = state[4]
    y = state[5]
    z = state[6]
    a = HALF * body_spin[0]
    b = HALF * body_spin[1]
    c = HALF * body_spin[2]
    return State(
        velocity[0],
        velocity[1],
        velocity[2],
        -x * a - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    )


@wp.func
def normalized(state: State) -> State:
    """The same state with its quaternion brought back to unit length."""
    scale = ONE / wp.sqrt(state[3] * state[3] + state[4] * state[4] + state[5] * state[5] + state[6] * state[6])
    return State(state[0], state[1], state[2], scale * state[3], scale * state[4], scale * state[5], scale * state[6])


@wp.func
def attack_angle(state: State) -> wp.float64:
    """Angle of attack (rad): elevation of the long axis above the horizontal; negative points the nose down."""
    return wp.asin(wp.clamp(TWO * (state[4] * state[6] - state[3] * state[5]), -ONE, ONE))


@wp.func
def head_position(state: State) -> wp.vec3d:
    """Centre of the head in the lab frame (m)."""
    return wp.vec3d(state[0], state[1], state[2])
