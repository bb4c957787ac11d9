"""Contact with floor, surface and side walls that hold: unilateral, frictionless, in the quasi-static balance.

The device touches with its *hull*, the convex hull of two balls: the head's, of its radius, and one of the coil's outer
radius at the rear end of the axis. A plane meets such a hull at one of the two balls, so that two points a plane are
all. The coil is smooth there: it does not roll along a wall, as it would by friction.

A wall pushes a ball where it would otherwise close its gap g faster than ``rate * g``, just so much that it does not:
complementarity of pushes L >= 0 and W L + c >= 0, where W is the mobility of the touching points along the normals and
c the speed at which each ball parts from its wall without pushes, plus ``rate * g``. A gap that is open stays open
(g' >= -rate * g), a ball at rest on a wall has g = 0 and no normal speed, and pushes only take power (L g' <= 0).

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, sec. 4.2 (K. G. Murty's
principal pivoting by least index, which ends for every positive definite W).
"""

import warp as wp

from helimag.physics.kinematics import State, head_position, rotation_matrix

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))
COMPLIANCE = wp.constant(wp.float64(1e-10))  # of the mean mobility: pushes are unique where balls block each other
ROUNDING = wp.constant(wp.float64(1e-12))  # of the largest closing speed
SETTLED = wp.constant(wp.float64(1e-9))  # m/s above the least speed that a wall allows: a wall pushes below it
PULL_REACH = wp.constant(wp.float64(0.1))  # of a ball's radius: how far a surface's hold reaches
MOST_PIVOTS = wp.constant(128)  # twice all sets of touching points

Six = wp.types.vector(length=6, dtype=wp.float64)  # head along x, y, z, then tail
SixBySix = wp.types.matrix(shape=(6, 6), dtype=wp.float64)


@wp.struct
class Tank:
    """Walls that hold, lab frame, and what of the device touches them; infinite where nothing is there."""

    low: wp.vec3d  # m
    high: wp.vec3d
    tail: wp.float64  # from the head's centre back to the end of the helix, m
    head_radius: wp.float64  # m
    tail_radius: wp.float64
    rate: wp.float64  # 1/s: a ball comes to a wall no faster than this times the gap
    pull: wp.float64  # N, with which the surface holds a ball that touches it


@wp.struct
class Gaps:
    """Each ball's distance (m) to the nearer wall along each axis, and which way that wall pushes: 1 from below."""

    gap: Six
    way: Six


@wp.func
def radius_of(tank: Tank, ball: int) -> wp.float64:
    """Radius (m) of the head's ball (0) or the tail's (1)."""
    if ball == 0:
        return tank.head_radius
    return tank.tail_radius


@wp.func
def behind(tank: Tank, ball: int) -> wp.float64:
    """How far behind the origin the head's ball (0) or the tail's (1) has its centre, m."""
    if ball == 0:
        return ZERO
    return tank.tail


@wp.func
def gaps_in(tank: Tank, position: wp.vec3d, rotation: wp.mat33d) -> Gaps:
    """Gaps of a device whose head is at ``position`` (m)."""
    found = Gaps()
    axis = wp.vec3d(rotation[0, 0], rotation[1, 0], rotation[2, 0])
    for ball in range(2):
        centre = position - behind(tank, ball) * axis
        for i in range(3):
            below = centre[i] - radius_of(tank, ball) - tank.low[i]
            above = tank.high[i] - radius_of(tank, ball) - centre[i]
            found.gap[3 * ball + i] = wp.min(below, above)
            found.way[3 * ball + i] = wp.where(below <= above, ONE, -ONE)
    return found


@wp.func
def unit_push(tank: Tank, rotation: wp.mat33d, k: int, way: wp.float64) -> wp.spatial_vectord:
    """Force and torque about the origin, body frame, of a push of one newton on place ``k`` of :class:`Gaps`."""
    i = k % 3
    normal = way * wp.vec3d(rotation[i, 0], rotation[i, 1], rotation[i, 2])
    torque = wp.cross(wp.vec3d(-behind(tank, k / 3), ZERO, ZERO), normal)
    return wp.spatial_vectord(normal[0], normal[1], normal[2], torque[0], torque[1], torque[2])


@wp.func
def surface_pull(pull: wp.float64, gap: wp.float64, reach: wp.float64) -> wp.float64:
    """Force (N) with which the surface holds a ball: all of ``pull`` where it touches, none from ``reach`` (m) on."""
    share = wp.clamp(ONE - gap / reach, ZERO, ONE)
    return pull * share * share


@wp.func
def surface_load(tank: Tank, position: wp.vec3d, rotation: wp.mat33d) -> wp.spatial_vectord:
    """What the surface's hold on the balls adds to the load, body frame; two that are one are held once."""
    load = wp.spatial_vectord()
    for ball in range(2):
        radius = radius_of(tank, ball)
        pull = wp.where(ball == 0 or tank.tail > ZERO, tank.pull, ZERO)
        gap = tank.high[2] - radius - position[2] + behind(tank, ball) * rotation[2, 0]
        load += surface_pull(pull, gap, PULL_REACH * radius) * unit_push(tank, rotation, 3 * ball + 2, ONE)
    return load


@wp.func
def solved_among(matrix: SixBySix, right: Six, active: int) -> Six:
    """Solution of the equations whose bits are set in ``active``; the other unknowns are zero."""
    a = matrix
    x = Six()
    six = wp.int32(6)  # loops over a variable are not unrolled, and compile sooner
    for i in range(six):
        if (active >> i) & 1 == 1:
            x[i] = right[i]
    for i in range(six):
        if (active >> i) & 1 == 1:
            for j in range(i + 1, six):
                if (active >> j) & 1 == 1:
                    factor = a[j, i] / a[i, i]
                    for c in range(i, six):
                        a[j, c] = a[j, c] - factor * a[i, c]
                    x[j] = x[j] - factor * x[i]
    for back in range(six):
        i = 5 - back
        if (active >> i) & 1 == 1:
            for j in range(i + 1, six):
                if (active >> j) & 1 == 1:
                    x[i] = x[i] - a[i, j] * x[j]
            x[i] = x[i] / a[i, i]
    return x


@wp.func
def least_pushes(mobility: SixBySix, parting: Six) -> Six:
    """Pushes L (N) with L >= 0, w = ``mobility`` L + ``parting`` >= 0 (m/s) and L w = 0, place by place."""
    matrix = mobility
    least = ZERO
    active = wp.int32(0)
    for k in range(6):
        matrix[k, k] = mobility[k, k] + COMPLIANCE * wp.trace(mobility) / wp.float64(6.0)
        least = wp.min(least, parting[k])
        if parting[k] < ZERO:
            active = active | (1 << k)
    pushes = Six()
    wrong = wp.int32(0)
    pivots = wp.int32(0)
    while wrong >= 0 and pivots < MOST_PIVOTS:
        pushes = solved_among(matrix, -parting, active)
        wrong = wp.int32(-1)
        for back in range(6):
            k = 5 - back
            speed = parting[k]
            for j in range(6):
                speed += matrix[k, j] * pushes[j]
            if (active >> k) & 1 == 1:
                speed = pushes[k] * matrix[k, k]
            if speed < ROUNDING * least:
                wrong = k
        if wrong >= 0:
            active = active ^ (1 << wrong)
        pivots += 1
    return pushes


@wp.func
def walls_touched(tank: Tank, state: State, rates: State) -> int:
    """Which walls push the device, whose state has these rates: bits by the numbers of ``outcomes.Limit``."""
    rotation = rotation_matrix(state)
    near = gaps_in(tank, head_position(state), rotation)
    # rate of the long axis, the first column of the rotation, from those of the quaternion
    axis_rate = wp.float64(2.0) * wp.vec3d(
        -wp.float64(2.0) * (state[5] * rates[5] + state[6] * rates[6]),
        state[4] * rates[5] + rates[4] * state[5] + state[3] * rates[6] + rates[3] * state[6],
        state[4] * rates[6] + rates[4] * state[6] - state[3] * rates[5] - rates[3] * state[5],
    )
    touched = wp.int32(0)
    for k in range(6):
        i = k % 3
        speed = rates[i] - behind(tank, k / 3) * axis_rate[i]
        if near.way[k] * speed + tank.rate * near.gap[k] < SETTLED:
            touched = touched | (1 << (2 * ((i + 1) % 3) + wp.where(near.way[k] > ZERO, 0, 1)))
    return touched
