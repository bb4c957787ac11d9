"""How near an orbit comes to anything that ends a run, enclosed: walls, floor, surface, magnets, and the fall limit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from helimag.engine import FALL_LIMIT
from helimag.proof.balls import exact, flint, lower
from helimag.proof.bounds import Span
from helimag.proof.exact import Inputs
from helimag.proof.jets import Jet
from helimag.proof.motion import LENGTH, Swimming
from helimag.proof.tube import Tube, reached

if TYPE_CHECKING:
    from flint import arb

SLACK = 2.0**-48  # relative, of lengths that are floats here: they stand for decimals and for sums of some


def clearance(inputs: Inputs, tube: Tube, spans: Sequence[Span]) -> float:
    """A lower bound (m) of the distance that all motion in the tube's region keeps, for all time, from what ends a run.

    A drive that moves on leads into no wall and does not sink (``require_provable``): what it leaves behind is nearest
    as it starts.
    """
    motion = Swimming(inputs.constants())
    return min(_over_span(inputs, motion, tube, span) for span in spans)


def _over_span(inputs: Inputs, motion: Swimming, tube: Tube, span: Span) -> float:
    scenario, unit = inputs.scenario, exact(LENGTH)
    device = scenario.device
    place, frame = motion.pose(
        span.straight.curve, [Jet(value) for value in reached(tube, span.straight.chart, tube.region)]
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
    gaps.append(head[2] - fall_limit(inputs))
    low, high = scenario.workspace.box
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


def fall_limit(inputs: Inputs) -> "arb":
    """Height (m) of the head at which a run ends as fallen: so many gaps to the arm's tool below its start."""
    pitch, start = inputs.read("drive.pitch"), inputs.read("drive.start.z")
    return start - exact(FALL_LIMIT) * abs(inputs.arm(pitch.cos(), pitch.sin())[2] - start)


def _length(value: float) -> "arb":
    return exact(value) * flint().arb(1, SLACK)
