"""Field, force and torque between the rotating permanent magnet and the device (eqs 4 and 9), and axis maps."""

import math

import warp as wp

MU0_OVER_4PI = wp.constant(wp.float64(1e-7))  # T m / A, the value before 2019; today's differs by 5.5e-10 of it
ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
THREE = wp.constant(wp.float64(3.0))
FIVE = wp.constant(wp.float64(5.0))

HIGHEST_ORDER = wp.constant(19)  # of the multipoles kept for a cylinder
Multipoles = wp.types.vector(length=10, dtype=wp.float64)  # of the odd orders 1, 3 ... 19, A m^(order + 1)


def slices_of(radius: float, height: float) -> int:
    """How many slices a cylinder is cut into: none thicker than wide, so that its multipoles converge."""
    return math.ceil(height / (2.0 * radius))


@wp.struct
class FieldSource:
    """One magnet on the arm."""

    offset: wp.vec3d  # m, from the RPM's centre, in the arm's turning frame
    moment: wp.float64  # A m^2
    cos_phase: wp.float64  # of what the moment is ahead of the spin
    sin_phase: wp.float64
    slices: wp.int32  # along the axis, each with the multipoles below; a long cylinder is cut into several
    thickness: wp.float64  # m, of a slice
    multipoles: Multipoles  # axial multipole moments of a slice; order 1 is its moment


@wp.func
def dipole_field(r: wp.vec3d, moment: wp.vec3d) -> wp.vec3d:
    """Flux density (T) at ``r`` (m) from a point dipole ``moment`` (A m^2) at the origin: eq. (9)."""
    inverse = ONE / wp.length(r)  # one division for all that distance divides
    axis = inverse * r
    return (MU0_OVER_4PI * inverse * inverse * inverse) * (THREE * wp.dot(axis, moment) * axis - moment)


@wp.func
def dipole_force(r: wp.vec3d, moment: wp.vec3d, m: wp.vec3d) -> wp.vec3d:
    """Force (N) on a dipole ``m`` at ``r`` (m) from a dipole ``moment`` at the origin: the gradient of m . B.

    The closed form of (m . grad) B in eq. (4); Yung, Landecker and Villani, Magn. Electr. Sep. 9 (1998) 39.
    """
    inverse = ONE / wp.length(r)
    axis = inverse * r
    along_m = wp.dot(axis, m)
    along_moment = wp.dot(axis, moment)
    square = inverse * inverse
    scale = THREE * MU0_OVER_4PI * (square * square)
    return scale * (along_m * moment + along_moment * m + (wp.dot(m, moment) - FIVE * along_m * along_moment) * axis)


@wp.func
def axial_field_and_force(r: wp.vec3d, axis: wp.vec3d, multipoles: Multipoles, m: wp.vec3d):
    """Flux density (T) at ``r`` (m) from axisymmetric multipoles along ``axis`` at the origin, and force (N) on ``m``.

    Exterior solution of Laplace's equation: the potential of order n is q_n P_n(cos) / r^(n+1) (Jackson, Classical
    Electrodynamics, 3rd ed., sec. 3.3), its gradient (P_n' axis - P_(n+1)' r_hat) / r^(n+2). Converges outside the
    sphere around the magnet; only odd orders are summed, a uniform cylinder has no others.
    """
    inverse = ONE / wp.length(r)
    r_hat = inverse * r
    cosine = wp.dot(r_hat, axis)
    along_m = wp.dot(r_hat, m)
    axis_m = wp.dot(axis, m)
    across = axis - cosine * r_hat
    field = wp.vec3d()
    force = wp.vec3d()
    # Legendre polynomial of this order with two derivatives, and the previous polynomial
    p_before = ONE
    p = cosine
    dp = ONE
    ddp = wp.float64(0.0)
    power = inverse * inverse * inverse
    for order in range(1, HIGHEST_ORDER + 1):
        n = wp.float64(order)
        p_next = ((n + n + ONE) * cosine * p - n * p_before) / (n + ONE)
        dp_next = (n + ONE) * p + cosine * dp
        ddp_next = (n + ONE + ONE) * dp + cosine * ddp
        if order % 2 == 1:
            scale = MU0_OVER_4PI * multipoles[order // 2] * power
            field += scale * (dp_next * r_hat - dp * axis)
            radial = (n + ONE + ONE) * (dp_next * along_m - dp * axis_m)
            force += (scale * inverse) * (
                (ddp_next * along_m - ddp * axis_m) * across + dp_next * (m - along_m * r_hat) - radial * r_hat
            )
        p_before = p
        p = p_next
        dp = dp_next
        ddp = ddp_next
        power = power * inverse
    return field, force


@wp.func
def point_dipole(magnet: FieldSource, r: wp.vec3d, axis: wp.vec3d, m: wp.vec3d):
    """Field and force of a magnet taken as a point dipole (``field = "dipole"`` in a scenario)."""
    return dipole_field(r, magnet.moment * axis), dipole_force(r, magnet.moment * axis, m)


@wp.func
def cylinder(magnet: FieldSource, r: wp.vec3d, axis: wp.vec3d, m: wp.vec3d):
    """Field and force of a cylinder magnetised along its own axis (``field = "cylinder"`` in a scenario).

    The sum over slices of the axis, each short enough for its multipoles to converge a diameter away.
    """
    field = wp.vec3d()
    force = wp.vec3d()
    lowest = HALF * wp.float64(magnet.slices - 1) * magnet.thickness
    for k in range(magnet.slices):
        at = wp.float64(k) * magnet.thickness - lowest
        field_k, force_k = axial_field_and_force(r - at * axis, axis, magnet.multipoles, m)
        field += field_k
        force += force_k
    return field, force


@wp.func
def moment_axis(magnet: FieldSource, rotation: wp.mat33d, spin: wp.vec2d) -> wp.vec3d:
    """Direction of a magnet's moment, R_a (0, cos, sin) of the spin's angle and the magnet's own phase ahead of it."""
    along = magnet.cos_phase * spin[0] - magnet.sin_phase * spin[1]
    ahead = magnet.sin_phase * spin[0] + magnet.cos_phase * spin[1]
    # by columns: the arm frame's x component is zero
    return wp.vec3d(
        along * rotation[0, 1] + ahead * rotation[0, 2],
        along * rotation[1, 1] + ahead * rotation[1, 2],
        along * rotation[2, 1] + ahead * rotation[2, 2],
    )


@wp.func
def field_axis_for(rpm_axis: wp.vec3d, direction: wp.vec3d) -> wp.vec3d:
    """Unit axis about which the field turns at a device seen from the RPM along the unit vector ``direction``.

    A dipole spinning about ``rpm_axis`` gives B = H M with H = 3 p p^T - I; the field stays in the plane with normal
    H^-1 rpm_axis (Mahoney and Abbott, IEEE Trans. Robot. 30 (2014) 411), and H^-1 = (3 p p^T - 2 I) / 2.
    """
    return wp.normalize(THREE * HALF * wp.dot(direction, rpm_axis) * direction - rpm_axis)


@wp.func
def rpm_axis_for(device_axis: wp.vec3d, direction: wp.vec3d) -> wp.vec3d:
    """Unit RPM axis that makes the field turn about ``device_axis`` at a device seen along ``direction``."""
    return wp.normalize(THREE * wp.dot(direction, device_axis) * direction - device_axis)
