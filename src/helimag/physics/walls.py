"""Drag near a floor or a surface: what they take from a device's mobility, looked up over gap and tilt.

The tables are those of :class:`helimag.hydrodynamics.boundary.WallTable`, turned from resistance to mobility. They hold
the device's *level frame*: the body frame rolled about the long axis until the lab's z axis lies in its x-z plane.
"""

import warp as wp

from helimag.physics.balance import Swimmer

HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))
THREE = wp.constant(wp.float64(3.0))
FOUR = wp.constant(wp.float64(4.0))
FIVE = wp.constant(wp.float64(5.0))
ZERO = wp.constant(wp.float64(0.0))
TINY = wp.constant(wp.float64(1e-12))

Symmetric = wp.types.vector(length=21, dtype=wp.float64)  # the upper triangle of a symmetric 6x6, row by row


@wp.struct
class WallGrid:
    """One table; without nodes where there is no such wall."""

    middle: wp.float64  # place along x of the device's middle, m
    least: wp.float64  # gap, m
    low: wp.float64  # its logarithm
    high: wp.float64  # and that of the largest
    least_tilt: wp.float64  # rad
    turning: wp.float64  # tilt at which nose and tail are equally near, rad
    most_tilt: wp.float64
    reach: wp.array2d(dtype=wp.float64)  # (2, tilts + 2): how much nearer than the origin the nearest point is, m
    changes: wp.array3d(dtype=Symmetric)  # (2, gaps + 2, tilts + 2): change of mobility times the middle's distance


@wp.struct
class FloorAndSurface:
    """Floor and surface of a run, lab frame."""

    floor: wp.float64  # m
    surface: wp.float64
    near_floor: WallGrid
    near_surface: WallGrid


@wp.struct
class NearWalls:
    """What walls take from the mobility at a place, in the level frame."""

    change: wp.spatial_matrixd


@wp.func
def cubic_weights(t: wp.float64) -> wp.vec4d:
    """Weights of four evenly spaced nodes between the second and third of them: Catmull and Rom's cubic."""
    return wp.vec4d(
        HALF * t * (-ONE + t * (TWO - t)),
        ONE + HALF * t * t * (-FIVE + THREE * t),
        HALF * t * (ONE + t * (FOUR - THREE * t)),
        HALF * t * t * (t - ONE),
    )


@wp.func
def place_on(value: wp.float64, low: wp.float64, high: wp.float64, nodes: int) -> wp.float64:
    """Where a value lies on evenly spaced nodes from ``low`` to ``high``, in nodes from the first; inside."""
    last = wp.float64(nodes - 1)
    return wp.clamp((value - low) / (high - low) * last, ZERO, last)


@wp.func
def change_near(grid: WallGrid, distance: wp.float64, tilt: wp.float64, sine: wp.float64) -> Symmetric:
    """Change of mobility by a wall ``distance`` (m) from the origin, nose ``tilt`` (rad) away from it."""
    gaps = grid.changes.shape[1] - 2
    tilts = grid.changes.shape[2] - 2
    side = 0
    at = place_on(tilt, grid.least_tilt, grid.turning, tilts)
    if tilt > grid.turning:
        side = 1
        at = place_on(tilt, grid.turning, grid.most_tilt, tilts)
    column = wp.min(int(at), tilts - 2)
    across = cubic_weights(at - wp.float64(column))
    reach = ZERO
    for c in range(4):
        reach += across[c] * grid.reach[side, column + c]
    gap = wp.max(distance - reach, grid.least)
    height = place_on(wp.log(gap), grid.low, grid.high, gaps)
    row = wp.min(int(height), gaps - 2)
    along = cubic_weights(height - wp.float64(row)) * (ONE / (gap + reach + grid.middle * sine))
    total = Symmetric()
    for r in range(4):
        for c in range(4):
            total += (along[r] * across[c]) * grid.changes[side, row + r, column + c]
    return total


@wp.func
def full_matrix(upper: Symmetric) -> wp.spatial_matrixd:
    """A symmetric 6x6 from its upper triangle."""
    matrix = wp.spatial_matrixd()
    k = 0
    for i in range(6):
        for j in range(i, 6):
            matrix[i, j] = upper[k]
            matrix[j, i] = upper[k]
            k += 1
    return matrix


@wp.func
def seen_walls(surroundings: FloorAndSurface, position: wp.vec3d, rotation: wp.mat33d) -> NearWalls:
    """What floor and surface together take from the mobility at a place: each as if the other were not there."""
    sine = wp.clamp(rotation[2, 0], -ONE, ONE)
    tilt = wp.asin(sine)
    change = Symmetric()
    if surroundings.near_floor.changes.shape[1] > 0:
        change += change_near(surroundings.near_floor, position[2] - surroundings.floor, tilt, sine)
    if surroundings.near_surface.changes.shape[1] > 0:
        change += change_near(surroundings.near_surface, surroundings.surface - position[2], -tilt, -sine)
    near = NearWalls()
    near.change = full_matrix(change)
    return near


@wp.func
def near_walls(
    body: Swimmer, here: NearWalls, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
) -> wp.spatial_vectord:
    """Velocity (m/s) and angular velocity (rad/s) under a load, body frame, beside floor or surface."""
    across = wp.sqrt(rotation[2, 1] * rotation[2, 1] + rotation[2, 2] * rotation[2, 2])
    cosine = ONE
    sine = ZERO
    if across > TINY:
        cosine = rotation[2, 2] / across
        sine = rotation[2, 1] / across
    level = here.change * wp.spatial_vectord(
        load[0],
        cosine * load[1] - sine * load[2],
        sine * load[1] + cosine * load[2],
        load[3],
        cosine * load[4] - sine * load[5],
        sine * load[4] + cosine * load[5],
    )
    return body.mobility * load + wp.spatial_vectord(
        level[0],
        cosine * level[1] + sine * level[2],
        -sine * level[1] + cosine * level[2],
        level[3],
        cosine * level[4] + sine * level[5],
        -sine * level[4] + cosine * level[5],
    )
