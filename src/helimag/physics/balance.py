"""Quasi-static balance of force and torque on the device (eq. 4): loads in, velocities out."""

import warp as wp

from helimag.physics.kinematics import State, rotation_matrix

ZERO = wp.constant(wp.float64(0.0))

# what a medium may write down of what is around a device: memory of the kernel, SHEETS of these. A structure as large
# would be copied at every stage of a step
Sheet = wp.types.vector(length=8, dtype=wp.float64)
SHEETS = wp.constant(13)


@wp.struct
class Swimmer:
    """A device as the kernels see it: SI, body frame, origin at the centre of the head, x towards the nose."""

    magnetic_moment: wp.float64  # A m^2, along the body's y axis
    net_weight: wp.float64  # N, weight less buoyancy, positive down
    weight_moment: wp.float64  # N m, net weight times the place along x where it acts (eq. 8 from parts)
    mobility: wp.spatial_matrixd  # inverse of the 6x6 resistance: (force, torque) to (velocity, angular velocity)


@wp.func
def moment_of(body: Swimmer, state: State) -> wp.vec3d:
    """Magnetic moment of the device in the lab frame (A m^2): along the body's y axis."""
    rotation = rotation_matrix(state)
    return body.magnetic_moment * wp.vec3d(rotation[0, 1], rotation[1, 1], rotation[2, 1])


@wp.func
def magnetic_torque(magnetic_moment: wp.float64, field: wp.vec3d) -> wp.vec3d:
    """Torque (N m) of a ``field`` (T) on the device's moment (A m^2), body frame: m x B of eq. (4), m along y."""
    return wp.vec3d(magnetic_moment * field[2], ZERO, -magnetic_moment * field[0])


@wp.func
def gravity_torque(up: wp.vec3d, weight_moment: wp.float64) -> wp.vec3d:
    """Torque (N m) of weight less buoyancy about the body origin (eq. 8); ``up`` is the lab's z axis, body frame."""
    return wp.vec3d(ZERO, weight_moment * up[2], -weight_moment * up[1])


@wp.func
def load_on(body: Swimmer, rotation: wp.mat33d, force: wp.vec3d, field: wp.vec3d) -> wp.spatial_vectord:
    """Force (N) and torque (N m) on the device, body frame, but for drag: the left-hand side of eq. (4).

    From the magnetic ``force`` (N) and ``field`` (T), both in lab components; the magnetic torque m x B and gravity are
    added here. ``rotation`` takes body components to lab components.
    """
    to_body = wp.transpose(rotation)
    up = wp.vec3d(rotation[2, 0], rotation[2, 1], rotation[2, 2])
    load = to_body * force - body.net_weight * up
    torque = magnetic_torque(body.magnetic_moment, to_body * field) + gravity_torque(up, body.weight_moment)
    return wp.spatial_vectord(load[0], load[1], load[2], torque[0], torque[1], torque[2])


@wp.struct
class OpenWater:
    """Surroundings without anything near: nothing to know of them."""


@wp.func
def nothing_near(
    surroundings: OpenWater, position: wp.vec3d, rotation: wp.mat33d, sheets: wp.array(dtype=Sheet)
) -> OpenWater:
    """What is around the device in open water: the same everywhere."""
    return surroundings


@wp.func
def nothing_again(
    surroundings: OpenWater,
    position: wp.vec3d,
    rotation: wp.mat33d,
    sheets: wp.array2d(dtype=Sheet),
    look: int,
    known: int,
) -> OpenWater:
    """The same, for one who may have looked before."""
    return surroundings


@wp.func
def open_water(
    body: Swimmer, here: OpenWater, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
) -> wp.spatial_vectord:
    """Velocity (m/s) and angular velocity (rad/s) under a load, body frame, far from all walls: eq. (4) solved."""
    return body.mobility * load
