"""Methods that take one step: DOP853, an explicit Runge-Kutta pair of order 8 with a blend of two error estimates.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, sec. II.10; its
coefficients are SciPy's.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import warp as wp

from helimag.engine import tableau
from helimag.engine.control import Control, scaled_square
from helimag.engine.dense import build_course
from helimag.engine.poses import poses_of
from helimag.engine.stages import STAGES, Stages, weighted_sum
from helimag.engine.system import System, build_rates_at
from helimag.errors import InputError
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import Instant, State, normalized
from helimag.physics.magnetics import FieldSource

LOW_SHARE = wp.constant(wp.float64(0.01))  # of the order-3 estimate in DOP853's blend
WITHIN = 9  # stage in the middle of a step, at 0.6 of it
COMPONENTS = wp.constant(wp.float64(7.0))
ZERO = wp.constant(wp.float64(0.0))
# fewest trial steps on the reference runs (benchmarks/step_control.py)
SAFETY = 0.8
GROWTH = 1.1


@dataclass(frozen=True)
class Method:
    """A way to take one step.

    Attributes
    ----------
    name
        As results give it.
    error_order
        Power of the step with which the error estimate falls.
    build
        ``build(system)`` makes the Warp function ``trial(body, here, drive, magnets, control, now, h, state, k0, kept,
        keep)``: the state after a step of ``h`` (s) from ``state`` at an instant, whose rates are ``k0``; its error in
        units of the tolerance; and a lag vector from the middle, for slips that a long step would pass over. Where it
        is to ``keep`` what ``course`` asks for, it leaves that in ``kept``, an array of states.
    safety
        Share of the step that would just meet the tolerance to try next.
    growth
        By how much a step may be longer than the one before.
    leaps
        Whether runs leap over turns of the magnet where that holds, see :mod:`helimag.engine.leaping`.
    lanes
        Whether ``trial`` is known to be said over lanes, see :mod:`helimag.engine.lanes`.
    course
        ``course(system)`` makes the function that gives the states within a step, see
        :func:`helimag.engine.dense.build_course`; without one, steps end where samples are due.
    """

    name: str
    error_order: int
    build: Callable[[System], wp.Function]
    safety: float = SAFETY
    growth: float = GROWTH
    leaps: bool = False
    lanes: bool = False
    course: Callable[[System], wp.Function] | None = None


@wp.func
def blended_error(low: State, high: State, h: wp.float64, control: Control) -> wp.float64:
    """DOP853's blend of its estimates of order 3 and 5: a root mean square in units of the tolerance."""
    low_sum = scaled_square(low, control)
    high_sum = scaled_square(high, control)
    blend = wp.abs(h) * high_sum / wp.sqrt((high_sum + LOW_SHARE * low_sum) * COMPONENTS)
    return wp.where(high_sum == ZERO, ZERO, blend)


@cache
def build_dop853(system: System) -> wp.Function:
    """Make DOP853's step for a system."""
    rates, drive_type, here_type = build_rates_at(system), system.drive_type, system.medium.here_type
    poses = poses_of(system.pose)
    drive_ahead, pose_at_stage = poses.ahead, poses.at_stage
    argument = [None] + [weighted_sum(tableau.A[i, :i]) for i in range(1, STAGES)]
    times = [wp.float64(float(c)) for c in tableau.C]
    result, low, high = (weighted_sum(weights) for weights in (tableau.B, tableau.E3[:STAGES], tableau.E5[:STAGES]))

    @wp.func
    def trial(
        body: Swimmer,
        here: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        control: Control,
        now: Instant,
        h: wp.float64,
        state: State,
        k0: State,
        kept: wp.array(dtype=State),
        keep: bool,
    ):
        k = Stages()
        k[0] = k0
        ahead = drive_ahead(drive, h)
        lag_within = wp.vec2d()
        for i in range(1, STAGES):
            stage = state + h * wp.static(argument[i])(k)
            pose = pose_at_stage(drive, now, ahead, i, wp.static(times[i]) * h)
            there, lag = rates(body, here, magnets, pose, stage)
            k[i] = there
            if i == WITHIN:
                lag_within = lag
        if keep:
            for i in range(STAGES):
                kept[i] = k[i]
        error = blended_error(low(k), high(k), h, control)
        return normalized(state + h * result(k)), error, lag_within

    return trial


DOP853 = Method("DOP853", 8, build_dop853, lanes=True, course=build_course)
MULTIREVOLUTION = replace(DOP853, name="DOP853, multi-revolution", leaps=True)
METHODS = {"multirevolution": MULTIREVOLUTION, "direct": DOP853}
DEFAULT = "multirevolution"  # benchmarks/random_runs.py says where it holds


def method_named(name: str) -> Method:
    """A method by the name that users give it.

    Returns
    -------
    Method
        The same object each time.

    Raises
    ------
    InputError
        Where there is none of that name.
    """
    if name not in METHODS:
        raise InputError(f"method must be one of {', '.join(METHODS)}; got '{name}'")
    return METHODS[name]
