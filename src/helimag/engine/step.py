"""One step: loads of all magnets, right-hand side, and a DOP853 step with its error.

The magnet model is chosen when a function is built, not by a branch in the loop.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import warp as wp

from helimag.engine import tableau as tab
from helimag.physics.balance import Body, balance_rates, moment_of
from helimag.physics.kinematics import RpmPose, State, head_position, normalized
from helimag.physics.magnetics import Magnet, phased_axis

ZERO = wp.constant(wp.float64(0.0))
COMPONENTS = wp.constant(wp.float64(7.0))
LOW_SHARE = wp.constant(wp.float64(0.01))  # of the order-3 estimate in DOP853's blend
SAFETY = wp.constant(
    wp.float64(0.8)
)  # with GROW: fewest trial steps on the reference runs (benchmarks/step_control.py)
GROW = wp.constant(wp.float64(1.1))
SHRINK = wp.constant(wp.float64(0.2))
EXPONENT = wp.constant(wp.float64(-0.125))  # the error estimate scales as h^8
TINY = wp.constant(wp.float64(1e-9))


@wp.struct
class Clock:
    """Times (s) and tolerance of one run."""

    interval: wp.float64
    duration: wp.float64
    longest: wp.float64
    tolerance: wp.float64  # of one step, in quaternion components and in positions over ``length``
    length: wp.float64  # m


@wp.func
def error_norm(low: State, high: State, h: wp.float64, clock: Clock) -> wp.float64:
    """DOP853's blend of its two error estimates: a root mean square in units of the tolerance."""
    low_sum = wp.float64(0.0)
    high_sum = wp.float64(0.0)
    for i in range(7):
        unit = clock.tolerance
        if i < 3:
            unit = clock.tolerance * clock.length
        low_sum += (low[i] / unit) * (low[i] / unit)
        high_sum += (high[i] / unit) * (high[i] / unit)
    if high_sum == ZERO:
        return ZERO
    return wp.abs(h) * high_sum / wp.sqrt((high_sum + LOW_SHARE * low_sum) * COMPONENTS)


@cache
def build_load(magnet_model: Callable[..., Any]) -> wp.Function:
    """Make the function that sums field (T) and force (N) of all magnets on a moment ``m`` at ``head``."""

    @wp.func
    def load(magnets: wp.array(dtype=Magnet), pose: RpmPose, head: wp.vec3d, m: wp.vec3d):
        field = wp.vec3d()
        force = wp.vec3d()
        rotation_axis = wp.vec3d(pose.rotation[0, 0], pose.rotation[1, 0], pose.rotation[2, 0])
        for j in range(magnets.shape[0]):
            r = head - pose.position - pose.rotation * magnets[j].offset
            axis = phased_axis(magnets[j], pose.moment_axis, rotation_axis)
            field_j, force_j = magnet_model(magnets[j], r, axis, m)
            field += field_j
            force += force_j
        return field, force

    return load


@cache
def build_rates(load: wp.Function, pose_model: wp.Function) -> wp.Function:
    """Make the right-hand side of the equations of motion for this magnet model and this kind of path."""
    drive_type = pose_model.input_types["drive"]

    @wp.func
    def rates(body: Body, drive: drive_type, magnets: wp.array(dtype=Magnet), t: wp.float64, state: State) -> State:
        field, force = load(magnets, pose_model(drive, t), head_position(state), moment_of(body, state))
        return balance_rates(body, state, force, field)

    return rates


@cache
def build_trial(rates: wp.Function) -> wp.Function:
    """Make the function that tries one step: new state, and its error in units of the tolerance."""
    drive_type = rates.input_types["drive"]

    @wp.func
    def trial(
        body: Body,
        drive: drive_type,
        magnets: wp.array(dtype=Magnet),
        clock: Clock,
        t: wp.float64,
        h: wp.float64,
        state: State,
        k0: State,
    ):
        k1 = rates(body, drive, magnets, t + tab.C1 * h, state + h * (tab.A1_0 * k0))
        k2 = rates(body, drive, magnets, t + tab.C2 * h, state + h * (tab.A2_0 * k0 + tab.A2_1 * k1))
        k3 = rates(body, drive, magnets, t + tab.C3 * h, state + h * (tab.A3_0 * k0 + tab.A3_2 * k2))
        k4 = rates(body, drive, magnets, t + tab.C4 * h, state + h * (tab.A4_0 * k0 + tab.A4_2 * k2 + tab.A4_3 * k3))
        k5 = rates(body, drive, magnets, t + tab.C5 * h, state + h * (tab.A5_0 * k0 + tab.A5_3 * k3 + tab.A5_4 * k4))
        k6 = rates(
            body,
            drive,
            magnets,
            t + tab.C6 * h,
            state + h * (tab.A6_0 * k0 + tab.A6_3 * k3 + tab.A6_4 * k4 + tab.A6_5 * k5),
        )
        k7 = rates(
            body,
            drive,
            magnets,
            t + tab.C7 * h,
            state + h * (tab.A7_0 * k0 + tab.A7_3 * k3 + tab.A7_4 * k4 + tab.A7_5 * k5 + tab.A7_6 * k6),
        )
        k8 = rates(
            body,
            drive,
            magnets,
            t + tab.C8 * h,
            state + h * (tab.A8_0 * k0 + tab.A8_3 * k3 + tab.A8_4 * k4 + tab.A8_5 * k5 + tab.A8_6 * k6 + tab.A8_7 * k7),
        )
        k9 = rates(
            body,
            drive,
            magnets,
            t + tab.C9 * h,
            state
            + h
            * (
                tab.A9_0 * k0
                + tab.A9_3 * k3
                + tab.A9_4 * k4
                + tab.A9_5 * k5
                + tab.A9_6 * k6
                + tab.A9_7 * k7
                + tab.A9_8 * k8
            ),
        )
        k10 = rates(
            body,
            drive,
            magnets,
            t + tab.C10 * h,
            state
            + h
            * (
                tab.A10_0 * k0
                + tab.A10_3 * k3
                + tab.A10_4 * k4
                + tab.A10_5 * k5
                + tab.A10_6 * k6
                + tab.A10_7 * k7
                + tab.A10_8 * k8
                + tab.A10_9 * k9
            ),
        )
        k11 = rates(
            body,
            drive,
            magnets,
            t + tab.C11 * h,
            state
            + h
            * (
                tab.A11_0 * k0
                + tab.A11_3 * k3
                + tab.A11_4 * k4
                + tab.A11_5 * k5
                + tab.A11_6 * k6
                + tab.A11_7 * k7
                + tab.A11_8 * k8
                + tab.A11_9 * k9
                + tab.A11_10 * k10
            ),
        )
        new = state + h * (
            tab.B0 * k0
            + tab.B5 * k5
            + tab.B6 * k6
            + tab.B7 * k7
            + tab.B8 * k8
            + tab.B9 * k9
            + tab.B10 * k10
            + tab.B11 * k11
        )
        low = (
            tab.L0 * k0
            + tab.L5 * k5
            + tab.L6 * k6
            + tab.L7 * k7
            + tab.L8 * k8
            + tab.L9 * k9
            + tab.L10 * k10
            + tab.L11 * k11
        )
        high = (
            tab.H0 * k0
            + tab.H5 * k5
            + tab.H6 * k6
            + tab.H7 * k7
            + tab.H8 * k8
            + tab.H9 * k9
            + tab.H10 * k10
            + tab.H11 * k11
        )
        return normalized(new), error_norm(low, high, h, clock)

    return trial


@wp.func
def rescaled(step: wp.float64, error: wp.float64) -> wp.float64:
    """The step that would just meet the tolerance, with a margin; a fifth where the error is not a number."""
    if not wp.isfinite(error):
        return SHRINK * step
    return step * wp.max(SAFETY * wp.pow(wp.max(error, TINY), EXPONENT), SHRINK)
