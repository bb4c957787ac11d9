"""Drag near a floor or a surface: what they add to a device's mobility, looked up over gap and tilt.

The tables are those of :class:`helimag.hydrodynamics.boundary.WallTable`, turned from resistance to mobility. They hold
the device's *level frame*: the body frame rolled about the long axis until the lab's z axis lies in its x-z plane. What
is the same however the device rolls is kept apart from what leans towards the wall. The latter fades as the long axis
turns upright: between the long axis and across like the cosine c of its tilt, across alone like c squared. The tables
have it over c and c squared, and turning it back with c cos and c sin of the roll, which are two entries of the
rotation as they stand, puts these in again: no root, no division, and nothing that breaks down where c is zero.

Entries lie on sheets of eight, and each formula goes over a whole sheet: that is what makes it swift.
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

# Entries of a symmetric 6x6 on three sheets: what is the same however the device rolls, where (4, 5) is none; what
# leans between the long axis and across; and what leans across alone, where blocks are symmetric and have no trace
EVEN = ((1, 1), (3, 3), (1, 4), (1, 5), (4, 4), (4, 5), (0, 0), (0, 3))
LEANING = ((0, 1), (0, 2), (0, 4), (0, 5), (1, 3), (2, 3), (3, 4), (3, 5))
TWICE = ((1, 1), (1, 2), (1, 4), (1, 5), (4, 4), (4, 5))
PARTS = wp.constant(3)
Cubics = wp.types.matrix(shape=(4, 8), dtype=wp.float64)  # of a sheet's entries, one coefficient a row
NOW = wp.constant(9)  # first of the kernel's sheets for the mobility of the moment, behind what was looked up
PLACE = wp.constant(12)  # the sheet that has where that was


@wp.struct
class WallGrid:
    """A floor or surface and the device's table for it."""

    place: wp.float64  # of the wall along z, lab frame, m
    sense: wp.float64  # 1 where the water is above it, -1 where below
    middle: wp.float64  # place along x of the device's middle, m
    least: wp.float64  # gap, m
    near: wp.float64  # the two lengths by which gaps are stretched, m
    far: wp.float64
    per_gap: wp.float64  # rows over stretched gap
    low: wp.float64  # the least gap, in these rows
    rows: wp.int32
    turning: wp.float64  # tilt at which nose and tail are equally near, by the tangent of its half
    first: wp.vec2d  # tangent of half the tilt of the first column, below that and above
    per_tilt: wp.vec2d  # columns over it
    columns: wp.int32
    reach: wp.array(dtype=wp.vec4d)  # how much nearer than the origin the nearest point is (m): cubic of each column
    changes: wp.array(dtype=Cubics)  # change of mobility times the middle's distance, see ``change_near``


@wp.struct
class FloorAndSurface:
    """Floor and surface of a run, as far as there are; an array, since it is handed on at every step."""

    grids: wp.array(dtype=WallGrid)
    alone: wp.array(dtype=Sheet)  # mobility in open water, on three sheets as ``mobility_now`` has it


@wp.struct
class NearWalls:
    """What walls add to the mobility around a place: to first order in how far from it the device is."""

    height: wp.float64  # of the place, m
    sine: wp.float64  # of the tilt there
    alone: wp.array(dtype=Sheet)  # mobility in open water, of which what follows is a change
    changes: wp.array(dtype=Sheet)  # three sheets there, three of the derivative by height and three of that by sine


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
def cell_of(place: wp.float64, cells: int) -> wp.float64:
    """The cell that a place on evenly spaced nodes is in, the last for its far end: a whole number."""
    cell = wp.floor(place)
    last = wp.float64(cells - 1)
    if cell > last:
        cell = last
    return cell


@wp.func
def summed(grid: WallGrid, first: int, y: wp.float64, along: wp.vec4d, upwards: wp.vec4d):
    """A sheet in a column of the table, ``y`` of its width from the edge, from the four rows from ``first`` on.

    With weights of the rows ``along`` and with those ``upwards``; and its derivative by ``y`` with the former. Between
    the edges of a column the table is a cubic, whose coefficients are together, and from row to row a spline: half the
    sums that a spline both ways takes. Each goes over one sheet, which compilers make one or two instructions of.
    """
    total = Sheet()
    by_gap = Sheet()
    by_half = Sheet()
    node = first
    for r in range(4):
        cubic = grid.changes[node]
        bending = y * cubic[3]
        across = bending + cubic[2]
        bending = y * (bending + across)
        across = y * across + cubic[1]
        bending += across
        across = y * across + cubic[0]
        total += along[r] * across
        by_gap += upwards[r] * across
        by_half += along[r] * bending
        node += PARTS
    return total, by_gap, by_half


@wp.func
def add_change(
    grid: WallGrid,
    distance: wp.float64,
    half: wp.float64,
    slope: wp.float64,
    sine: wp.float64,
    sheets: wp.array(dtype=Sheet),
):
    """Add to the sheets the change of mobility by a wall ``distance`` (m) from the origin, nose tilted away from it.

    ``half`` is the tangent of half the tilt, ``slope`` its derivative by the tilt's ``sine``. Gaps are stretched as
    :mod:`helimag.hydrodynamics.boundary.lookup` has it. Derivatives of the change by height and sine are added too.
    """
    side = 0
    if half > grid.turning:
        side = 1
    at = (half - grid.first[side]) * grid.per_tilt[side]
    edge = cell_of(at, grid.columns)
    y = at - edge
    column = int(edge) + side * grid.columns
    turning = slope * grid.per_tilt[side]
    end = grid.reach[column]
    reach = (end[3] * y + end[2]) * (y * y) + (end[1] * y + end[0])
    reaching = (THREE * end[3] * (y * y) + (TWO * end[2] * y + end[1])) * turning
    gap = distance - reach
    opening = ONE
    if gap < grid.least:
        gap = grid.least
        opening = ZERO
    inverse = ONE / (gap + reach + grid.middle * sine)
    apart = grid.per_gap / ((gap + grid.near) * (gap + grid.far))
    height = gap * (gap + gap + (grid.near + grid.far)) * apart - grid.low
    near = (gap + grid.far) * apart
    far = (gap + grid.near) * apart
    rising = inverse * opening * (grid.near * near * near + grid.far * far * far) / grid.per_gap
    last = wp.float64(grid.rows - 1)
    if height > last:
        height = last
        rising = ZERO
    foot = cell_of(height, grid.rows - 1)
    x = height - foot
    along = cubic_weights(x) * inverse
    upwards = cubic_slopes(x) * (grid.sense * rising)
    turned_over = grid.sense * turning
    along_gap = grid.sense * (inverse * opening)
    lowering = grid.sense * inverse * (reaching * (ONE - opening) + grid.middle)
    first = (column * (grid.rows + 2) + int(foot)) * PARTS
    three = wp.int32(3)  # a loop over a variable is not unrolled
    for part in range(three):
        total, by_gap, by_half = summed(grid, first + part, y, along, upwards)
        sheets[part] += total
        sheets[PARTS + part] += by_gap - along_gap * total
        sheets[2 * PARTS + part] += turned_over * by_half - reaching * by_gap - lowering * total


@wp.func
def seen_walls(
    surroundings: FloorAndSurface, position: wp.vec3d, rotation: wp.mat33d, sheets: wp.array(dtype=Sheet)
) -> NearWalls:
    """What floor and surface together add to the mobility around a place: each as if the other were not there."""
    sine = wp.clamp(rotation[2, 0], -ONE, ONE)
    cosine = wp.sqrt(ONE - sine * sine)
    share = ONE / (ONE + cosine)
    half = sine * share
    slope = share / wp.max(cosine, UPRIGHT)
    for part in range(NOW):
        sheets[part] = Sheet()
    for k in range(surroundings.grids.shape[0]):
        grid = surroundings.grids[k]
        sense = grid.sense
        add_change(grid, sense * (position[2] - grid.place), sense * half, slope, sense * sine, sheets)
    near = NearWalls()
    near.height = position[2]
    near.sine = sine
    near.alone = surroundings.alone
    near.changes = sheets
    return near


@wp.func
def walls_again(
    surroundings: FloorAndSurface,
    position: wp.vec3d,
    rotation: wp.mat33d,
    sheets: wp.array2d(dtype=Sheet),
    look: int,
    known: int,
) -> NearWalls:
    """The same, on the sheets of one look of many, where it stays; where it is known from before, what is there."""
    if known == 0:
        seen = seen_walls(surroundings, position, rotation, sheets[look])
        sheets[look, PLACE] = Sheet(seen.height, seen.sine, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO)
    near = NearWalls()
    near.height = sheets[look, PLACE][0]
    near.sine = sheets[look, PLACE][1]
    near.alone = surroundings.alone
    near.changes = sheets[look]
    return near


@wp.func
def followed(here: NearWalls, part: int, risen: wp.float64, raised: wp.float64) -> Sheet:
    """A sheet of the change, to first order in how far the device is from where it was looked up."""
    return here.changes[part] + risen * here.changes[PARTS + part] + raised * here.changes[2 * PARTS + part]


@wp.func
def turned_back(e: Sheet, cosine: wp.float64, sine: wp.float64) -> Sheet:
    """Pairs of entries, vectors across the long axis, turned by minus an angle."""
    return Sheet(
        cosine * e[0] + sine * e[1],
        cosine * e[1] - sine * e[0],
        cosine * e[2] + sine * e[3],
        cosine * e[3] - sine * e[2],
        cosine * e[4] + sine * e[5],
        cosine * e[5] - sine * e[4],
        cosine * e[6] + sine * e[7],
        cosine * e[7] - sine * e[6],
    )


@wp.func
def near_walls(
    body: Swimmer, here: NearWalls, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
) -> wp.spatial_vectord:
    """Velocity (m/s) and angular velocity (rad/s) under a load, body frame, beside floor or surface.

    The change is turned back from the level frame at a roll of which c cos and c sin are entries of the rotation. The
    mobility of the moment is written down, so that a compiler works on whole sheets, and read again: a symmetric 6x6.
    """
    risen = position[2] - here.height
    raised = rotation[2, 0] - here.sine
    cosine = rotation[2, 2]
    sine = rotation[2, 1]
    even = followed(here, 0, risen, raised)
    twice = turned_back(followed(here, 2, risen, raised), cosine * cosine - sine * sine, TWO * cosine * sine)
    here.changes[NOW] = here.alone[0] + (even + twice)
    here.changes[NOW + 1] = here.alone[1] + (even - twice)
    here.changes[NOW + 2] = here.alone[2] + turned_back(followed(here, 1, risen, raised), cosine, sine)
    return moved(here.changes[NOW], here.changes[NOW + 1], here.changes[NOW + 2], load)


@wp.func
def moved(p: Sheet, n: Sheet, b: Sheet, load: wp.spatial_vectord) -> wp.spatial_vectord:
    """Motion under a load by a mobility on three sheets.

    ``p`` has entries of ``EVEN`` and ``n`` those beside them: (2, 2), (2, 5), less (2, 4), (5, 5). The second of each
    is (3, 3), with (1, 2) added or taken away. ``b`` has those of ``LEANING``.
    """
    rolling = HALF * (p[1] + n[1])
    crossed = HALF * (p[1] - n[1])
    x = load
    return wp.spatial_vectord(
        p[6] * x[0] + b[0] * x[1] + b[1] * x[2] + (p[7] * x[3] + b[2] * x[4] + b[3] * x[5]),
        b[0] * x[0] + p[0] * x[1] + crossed * x[2] + (b[4] * x[3] + p[2] * x[4] + p[3] * x[5]),
        b[1] * x[0] + crossed * x[1] + n[0] * x[2] + (b[5] * x[3] - n[3] * x[4] + n[2] * x[5]),
        p[7] * x[0] + b[4] * x[1] + b[5] * x[2] + (rolling * x[3] + b[6] * x[4] + b[7] * x[5]),
        b[2] * x[0] + p[2] * x[1] - n[3] * x[2] + (b[6] * x[3] + p[4] * x[4] + p[5] * x[5]),
        b[3] * x[0] + p[3] * x[1] + n[2] * x[2] + (b[7] * x[3] + p[5] * x[4] + n[4] * x[5]),
    )
