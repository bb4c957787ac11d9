"""Step control: how large a run's steps may be, and the next one from the error of the last."""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.structures import structs
from helimag.physics.kinematics import State
from helimag.scenario import Device, Scenario

SHRINK = wp.constant(wp.float64(0.2))
TINY = wp.constant(wp.float64(1e-9))


@wp.struct
class Control:
    """What steps of one run must keep to."""

    longest: wp.float64  # s
    tolerance: wp.float64  # of one step, in quaternion components and in positions over ``length``
    length: wp.float64  # m


def pack_controls(scenarios: Sequence[Scenario], tolerance: float, longest: float) -> NDArray[np.void]:
    """Step control of each run as the kernels take it; no step is longer than ``longest`` turns of the magnet."""
    return structs(
        Control,
        [
            {"longest": _longest_step(scenario, longest), "tolerance": tolerance, "length": _length(scenario.device)}
            for scenario in scenarios
        ],
    )


def _length(device: Device) -> float:
    """What positions are measured against (m)."""
    return device.length if device.helix is None else device.helix.length


def _longest_step(scenario: Scenario, turns: float) -> float:
    """So many turns of the magnet and of its yaw, and no step that leaps over a sample of the path (s)."""
    drive = scenario.drive
    part = turns / max(abs(drive.frequency), abs(drive.yaw_rate) / (2.0 * math.pi))
    return part if drive.path is None else min(part, 2.0 * drive.path.duration / (len(drive.path.position) - 1))


@wp.func
def scaled_square(error: State, control: Control) -> wp.float64:
    """Sum of the squares of an error's components, in units of the tolerance."""
    places = error[0] * error[0] + error[1] * error[1] + error[2] * error[2]
    turns = error[3] * error[3] + error[4] * error[4] + error[5] * error[5] + error[6] * error[6]
    return (places / (control.length * control.length) + turns) / (control.tolerance * control.tolerance)


@cache
def build_rescaled(error_order: int, safety: float) -> wp.Function:
    """Make the function that gives the step that would just meet the tolerance, for an error of this order in it."""
    exponent = wp.constant(wp.float64(-1.0 / error_order))
    margin = wp.constant(wp.float64(safety))

    @wp.func
    def rescaled(step: wp.float64, error: wp.float64) -> wp.float64:
        # a fifth where the error is not a number
        if not wp.isfinite(error):
            return SHRINK * step
        return step * wp.max(margin * wp.pow(wp.max(error, TINY), exponent), SHRINK)

    return rescaled
