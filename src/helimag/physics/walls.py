"""Drag near a floor or a surface: what they add to a device's mobility, looked up over gap and tilt.

The tables are those of :class:`helimag.hydrodynamics.boundary.WallTable`, turned from resistance to mobility. They hold
the device's *level frame*: the body frame rolled about the long axis until the lab's z axis lies in its x-z plane. What
is the same however the device rolls is kept apart from what leans towards the wall. The latter fades as the long axis
turns upright: between the long axis and across like the cosine c of its tilt, across alone like c squared. The tables
have it over c and c squared, and turning it back with c cos and c sin of the roll, which are two entries of the
rotation as they stand, puts these in again: no root, no division, and nothing that breaks down where c is zero.
"""

import warp as wp

from helimag.physics.balance import Sheet, Swimmer

HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))
UPRIGHT = wp.constant(wp.float64(0.1))  # least cosine of the tilt by which derivatives are divided: it only blunts them
THREE = wp.constant(wp.float64(3.0))
FOUR = wp.constant(wp.float64(4.0))
SIX = wp.constant(wp.float64(6.0))
SIXTH = wp.constant(wp.float64(1.0 / 6.0))
ZERO = wp.constant(wp.float64(0.0))

# of a symmetric 6x6: ``EVEN`` entries, then ``LEANING`` ones, then three that are not used and fill a vector register
Change = Sheet
EVEN = ((0, 0), (0, 3), (1, 1), (1, 4), (1, 5), (3, 3), (4, 4))
LEANING = ((0, 1), (0, 2), (0, 4), (0, 5), (1, 3), (2, 3), (3, 4), (3, 5))  # between the long axis and across
LEANING += ((1, 1), (1, 2), (1, 4), (1, 5), (4, 4), (4, 5))  # across alone, where blocks are symmetric, without trace


@wp.struct
class WallGrid:
    """A floor or surface and the device's table for it."""

    place: wp.float64  # of the wall along z, lab frame, m
    sense: wp.float64  # 1 where the water is above it, -1 where below
    middle: wp.float64  # place along x of the device's middle, m
    least: wp.float64  # gap, m
    low: wp.float64  # its logarithm
    per_gap: wp.float64  # nodes over logarithm
    least_tilt: wp.float64  # rad
    turning: wp.float64  # tilt at which nose and tail are equally near, rad
    per_tilt: wp.vec2d  # nodes per rad, below that and above
    reach: wp.array2d(dtype=wp.float64)  # (2, tilts + 2): how much nearer than the origin the nearest point is, m
    changes: wp.array3d(dtype=Change)  # (2, gaps + 2, tilts + 2): change of mobility times the middle's distance


@wp.struct
class FloorAndSurface:
    """Floor and surface of a run, as far as there are; an array, since it is handed on at every step."""

    grids: wp.array(dtype=WallGrid)


@wp.struct
class NearWalls:
    """What walls add to the mobility around a place: to first order in how far from it the device is."""

    height: wp.float64  # of the place, m
    sine: wp.float64  # of the tilt there
    changes: wp.array(dtype=Change)  # there, and its derivatives by height and sine


@wp.func
def cubic_weights(t: wp.float64) -> wp.vec4d:
    """Weights of four evenly spaced coefficients between the second and third of them: uniform cubic B-splines."""
    u = ONE - t
    return SIXTH * wp.vec4d(
        u * u * u,
        FOUR + t * t * (THREE * t - SIX),
        FOUR + u * u * (THREE * u - SIX),
        t * t * t,
    )


@wp.func
def cubic_slopes(t: wp.float64) -> wp.vec4d:
    """Derivatives of these weights."""
    u = ONE - t
    return HALF * wp.vec4d(-u * u, t * (THREE * t - FOUR), -u * (THREE * u - FOUR), t * t)


@wp.func
def place_on(value: wp.float64, low: wp.float64, density: wp.float64, nodes: int) -> wp.float64:
    """Where a value lies on evenly spaced nodes from ``low`` on, in nodes from the first; inside."""
    return wp.clamp((value - low) * density, ZERO, wp.float64(nodes - 1))


@wp.func
def change_near(grid: WallGrid, distance: wp.float64, tilt: wp.float64, sine: wp.float64, cosine: wp.float64):
    """Change of mobility by a wall ``distance`` (m) from the origin, nose ``tilt`` (rad) away from it.

    With its derivatives by the distance and by the tilt's sine.
    """
    gaps = grid.changes.shape[1] - 2
    tilts = grid.changes.shape[2] - 2
    side = 0
    first = grid.least_tilt
    if tilt > grid.turning:
        side = 1
        first = grid.turning
    at = place_on(tilt, first, grid.per_tilt[side], tilts)
    column = wp.min(int(at), tilts - 2)
    across = cubic_weights(at - wp.float64(column))
    tilting = cubic_slopes(at - wp.float64(column)) * (grid.per_tilt[side] / cosine)
    reach = ZERO
    reaching = ZERO
    for c in range(4):
        reach += across[c] * grid.reach[side, column + c]
        reaching += tilting[c] * grid.reach[side, column + c]
    gap = distance - reach
    opening = ONE
    if gap < grid.least:
        gap = grid.least
        opening = ZERO
    height = place_on(wp.log(gap), grid.low, grid.per_gap, gaps)
    row = wp.min(int(height), gaps - 2)
    inverse = ONE / (gap + reach + grid.middle * sine)
    along = cubic_weights(height - wp.float64(row)) * inverse
    rising = cubic_slopes(height - wp.float64(row)) * (inverse * opening * grid.per_gap / gap)
    if height >= wp.float64(gaps - 1):
        rising = wp.vec4d()
    total = Change()
    by_gap = Change()
    by_sine = Change()
    four = wp.int32(4)  # a loop over a variable is not unrolled, and compiles sooner
    for r in range(four):
        for c in range(4):
            node = grid.changes[side, row + r, column + c]
            total += (along[r] * across[c]) * node
            by_gap += (rising[r] * across[c]) * node
            by_sine += (along[r] * tilting[c]) * node
    by_sine -= reaching * by_gap + (inverse * (reaching * (ONE - opening) + grid.middle)) * total
    return total, by_gap - (inverse * opening) * total, by_sine


@wp.func
def seen_walls(
    surroundings: FloorAndSurface, position: wp.vec3d, rotation: wp.mat33d, sheets: wp.array(dtype=Sheet)
) -> NearWalls:
    """What floor and surface together add to the mobility around a place: each as if the other were not there."""
    sine = wp.clamp(rotation[2, 0], -ONE, ONE)
    tilt = wp.asin(sine)
    cosine = wp.max(wp.sqrt(ONE - sine * sine), UPRIGHT)
    change = Change()
    by_height = Change()
    by_sine = Change()
    for k in range(surroundings.grids.shape[0]):
        grid = surroundings.grids[k]
        sense = grid.sense
        alone, by_distance, by_its_sine = change_near(
            grid, sense * (position[2] - grid.place), sense * tilt, sense * sine, cosine
        )
        change += alone
        by_height += sense * by_distance
        by_sine += sense * by_its_sine
    sheets[0] = change
    sheets[1] = by_height
    sheets[2] = by_sine
    near = NearWalls()
    near.height = position[2]
    near.sine = sine
    near.changes = sheets
    return near


@wp.func
def turned_back(e: Change, k: int, cosine: wp.float64, sine: wp.float64) -> wp.vec2d:
    """The pair of entries from ``k`` on, a vector across the long axis, turned by minus an angle."""
    return wp.vec2d(cosine * e[k] + sine * e[k + 1], cosine * e[k + 1] - sine * e[k])


@wp.func
def change_rolled(e: Change, cosine: wp.float64, sine: wp.float64) -> wp.spatial_matrixd:
    """Change of mobility in the body frame, from the level frame at the roll of which these are c cos and c sin.

    Entries between the long axis and across turn with the roll, those across alone that lean turn twice as far.
    """
    ff = turned_back(e, 7, cosine, sine)  # velocity along with forces across, velocity across with force along
    ft = turned_back(e, 9, cosine, sine)  # velocity along with torques across
    tf = turned_back(e, 11, cosine, sine)  # angular velocity along with forces across
    tt = turned_back(e, 13, cosine, sine)
    cosine_2 = cosine * cosine - sine * sine
    sine_2 = TWO * cosine * sine
    gg = turned_back(e, 15, cosine_2, sine_2)  # velocities and forces across
    gh = turned_back(e, 17, cosine_2, sine_2)
    hh = turned_back(e, 19, cosine_2, sine_2)
    return wp.spatial_matrixd(
        e[0], ff[0], ff[1], e[1], ft[0], ft[1],
        ff[0], e[2] + gg[0], gg[1], tf[0], e[3] + gh[0], gh[1] + e[4],
        ff[1], gg[1], e[2] - gg[0], tf[1], gh[1] - e[4], e[3] - gh[0],
        e[1], tf[0], tf[1], e[5], tt[0], tt[1],
        ft[0], e[3] + gh[0], gh[1] - e[4], tt[0], e[6] + hh[0], hh[1],
        ft[1], gh[1] + e[4], e[3] - gh[0], tt[1], hh[1], e[6] - hh[0],
    )  # fmt: skip


@wp.func
def near_walls(
    body: Swimmer, here: NearWalls, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
) -> wp.spatial_vectord:
    """Velocity (m/s) and angular velocity (rad/s) under a load, body frame, beside floor or surface."""
    risen = position[2] - here.height
    raised = rotation[2, 0] - here.sine
    change = here.changes[0] + risen * here.changes[1] + raised * here.changes[2]
    # symmetric: behind the vector its rows are read one by one
    return load * (body.mobility + change_rolled(change, rotation[2, 2], rotation[2, 1]))
