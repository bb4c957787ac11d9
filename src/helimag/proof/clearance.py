"""How near an orbit comes to anything that would end a run, enclosed: walls, floor, surface and magnets."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from helimag.orbits import open_water
from helimag.proof.balls import exact, flint, lower
from helimag.proof.jets import Jet
from helimag.proof.motion import LENGTH, Swimming
from helimag.proof.tube import Span, Tube, deviations
from helimag.scenario import Scenario

if TYPE_CHECKING:
    from flint import arb

SLACK = 2.0**-48  # relative, of lengths that are floats here: they stand for decimals and for sums of some


def clearance(scenario: Scenario, motion: Swimming, tube: Tube, spans: Sequence[Span]) -> float:
    """A lower bound (m) of the distance that all motion in the tube's region keeps from what ends a run.

    As in a search for orbits, walls that a drive moves along or into in the end are not counted.
    """
    return min(_over_span(scenario, motion, tube, span) for span in spans)


def _over_span(scenario: Scenario, motion: Swimming, tube: Tube, span: Span) -> float:
    device, unit = scenario.device, exact(LENGTH)
    place, frame = motion.pose(
        span.straight.curve, [Jet(value) for value in deviations(tube, span.straight.frame, tube.region)]
    )
    head = [component.v * unit for component in place]
    tail = [h - frame[i][0].v * _length(device.tail_length) for i, h in enumerate(head)]
    ends = [(head, _length(device.head_radius)), (tail, _length(device.tail_radius))]
    gaps: list[Any] = []
    # a run ends as near to any magnet as the largest one reaches
    reach = max(magnet.reach for magnet in scenario.magnet)
    for source in motion.constants.sources:
        away = [h - p * unit for h, p in zip(head, source.place, strict=True)]
        square = sum((a * a for a in away), exact(0))
        gaps.append(square.sqrt() - _length(reach) - _length(device.head_radius))
    low, high = open_water(scenario).workspace.box
    round_trip = scenario.drive.yaw_rate != 0.0
    for axis in range(3):
        for point, radius in ends:
            least, most = point[axis], point[axis]
            if round_trip and axis < 2:
                most = (point[0] * point[0] + point[1] * point[1]).sqrt()
                least = -most
            gaps += [least - radius - _length(low[axis])] if abs(low[axis]) < float("inf") else []
            gaps += [_length(high[axis]) - most - radius] if abs(high[axis]) < float("inf") else []
    return min(lower(gap) for gap in gaps)


def _length(value: float) -> "arb":
    return exact(value) * flint().arb(1, SLACK)
