"""Samples within a step: DOP853's dense output, a polynomial of order 7 through four stages more.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, sec. II.10; its
coefficients are SciPy's. Where samples are due more often than steps end, landing on each would take steps that
error control does not ask for.
"""

from functools import cache

import warp as wp

from helimag.engine import tableau
from helimag.engine.stages import STAGES, weighted_sum
from helimag.engine.system import System, build_rates
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import State, normalized
from helimag.physics.magnetics import FieldSource

KEPT = tableau.EXTENDED
MORE = KEPT - STAGES
DEGREE = 7
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))

Rows = wp.types.matrix(shape=(DEGREE, 7), dtype=wp.float64)


@wp.struct
class Course:
    """The states within one step."""

    begin: wp.float64  # s
    length: wp.float64  # s
    state: State  # where it begins
    rows: Rows  # what each next power adds, in turn of the share that is behind and of the rest


@cache
def build_course(system: System) -> wp.Function:
    """Make the function that gives the course of a step of ``h`` (s) whose stages were kept."""
    rates, drive_type, here_type = build_rates(system), system.drive_type, system.medium.here_type
    kept_states = wp.array(dtype=State)
    arguments, coefficients = ([weighted_sum(row, kept_states) for row in rows] for rows in (tableau.A_MORE, tableau.D))
    times = [wp.float64(float(c)) for c in tableau.C_MORE]

    @wp.func
    def course(
        body: Swimmer,
        here: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        t: wp.float64,
        h: wp.float64,
        state: State,
        kept: wp.array(dtype=State),
    ) -> Course:
        rows = Rows()
        for i in range(MORE):  # the first is the step's end
            change = h * wp.static(arguments[i])(kept)
            if i == 0:
                rows[0] = change
            kept[STAGES + i] = rates(body, here, drive, magnets, t + wp.static(times[i]) * h, state + change)
        rows[1] = h * kept[0] - rows[0]
        rows[2] = TWO * rows[0] - h * (kept[0] + kept[STAGES])
        for i in range(MORE):
            rows[3 + i] = h * wp.static(coefficients[i])(kept)
        found = Course()
        found.begin = t
        found.length = h
        found.state = state
        found.rows = rows
        return found

    return course


@wp.func
def state_at(course: Course, t: wp.float64) -> State:
    """The state at a time (s) within the step."""
    share = (t - course.begin) / course.length
    change = State()
    degree = wp.int32(DEGREE)  # a loop over a variable is not unrolled
    for i in range(degree):
        change = (change + course.rows[DEGREE - 1 - i]) * wp.where(i % 2 == 0, share, ONE - share)
    return normalized(course.state + change)
