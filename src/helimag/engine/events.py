"""Events: where a run ends, and which end that is."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.packing import initial_gap
from helimag.engine.structures import alike, structs
from helimag.outcomes import End
from helimag.physics.kinematics import RpmPose, State, head_position, rotation_matrix
from helimag.physics.magnetics import FieldSource
from helimag.scenario import Scenario

FALL_LIMIT = 2.0  # of the initial gap: a device this far below its start is not followed further
DEPTH_LIMIT = 1e-6  # m: a device this deep in a wall that holds was put there, or squeezed between two
CONTACT, FALL, FLOOR, SURFACE, WALL = (
    wp.constant(end.flag) for end in (End.CONTACT, End.FALL, End.FLOOR, End.SURFACE, End.WALL)
)


@wp.struct
class Bounds:
    """Where a run ends, lab frame, m; infinite where nothing is there."""

    contact: wp.float64  # between the centres of head and magnet
    fall: wp.float64  # height of the head
    low: wp.vec3d
    high: wp.vec3d
    tail: wp.float64  # from the head's centre back to the end of the helix
    head_radius: wp.float64
    tail_radius: wp.float64
    pull_reach: wp.float64  # how near a surface that holds begins to pull


def pack_bounds(scenarios: Sequence[Scenario]) -> NDArray[np.void]:
    """Where each run ends, as the kernels take it."""
    firsts, which = alike([(scenario.device, scenario.workspace, *scenario.magnet) for scenario in scenarios])
    bounds: Any = structs(Bounds, [_around(scenarios[run]) for run in firsts])[which]
    bounds["fall"] = [scenario.drive.start[2] - FALL_LIMIT * initial_gap(scenario) for scenario in scenarios]
    return np.asarray(bounds)


def _around(scenario: Scenario) -> dict[str, object]:
    """Where a run ends, but for its fall."""
    workspace, device = scenario.workspace, scenario.device
    low, high = workspace.box
    deeper = DEPTH_LIMIT if workspace.holds else 0.0
    return {
        "contact": scenario.contact_distance,
        "low": [at - deeper for at in low],
        "high": [at + deeper for at in high],
        "tail": device.tail_length,
        "head_radius": device.head_radius,
        "tail_radius": device.tail_radius,
        "pull_reach": _pull_reach(scenario),
    }


def _pull_reach(scenario: Scenario) -> float:
    """How near a surface that holds begins to pull (m)."""
    if not scenario.workspace.surface_pull:
        return 0.0
    from helimag.physics.contact import PULL_REACH

    return float(PULL_REACH) * max(scenario.device.head_radius, scenario.device.tail_radius)


@wp.func
def clearance(bounds: Bounds, magnets: wp.array(dtype=FieldSource), pose: RpmPose, state: State):
    """Least distance (m) to anything that ends the run, and the number of the End that would be, as lanes hold it."""
    head = head_position(state)
    rotation = rotation_matrix(state)
    tail = head - bounds.tail * wp.vec3d(rotation[0, 0], rotation[1, 0], rotation[2, 0])
    least = head[2] - bounds.fall
    kind = wp.float64(FALL)
    for j in range(magnets.shape[0]):
        gap = wp.length(head - pose.position - pose.rotation * magnets[j].offset) - bounds.contact
        kind = wp.where(gap < least, wp.float64(CONTACT), kind)
        least = wp.where(gap < least, gap, least)
    for i in range(3):
        below = wp.min(head[i] - bounds.head_radius, tail[i] - bounds.tail_radius) - bounds.low[i]
        above = bounds.high[i] - wp.max(head[i] + bounds.head_radius, tail[i] + bounds.tail_radius)
        kind = wp.where(below < least, wp.float64(wp.where(i == 2, FLOOR, WALL)), kind)
        least = wp.where(below < least, below, least)
        kind = wp.where(above < least, wp.float64(wp.where(i == 2, SURFACE, WALL)), kind)
        least = wp.where(above < least, above, least)
    return least, kind
