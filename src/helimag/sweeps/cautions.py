"""What does not hold over the points of a sweep, for its store; of large ones a part is looked at, corners first."""

from collections.abc import Iterator

import numpy as np

from helimag import quantities as q
from helimag.checks import Caution, cautions
from helimag.sweeps.boundary import start_points
from helimag.sweeps.resolved import ResolvedPlan, Value

MOST_CHECKED = 500  # runs: each takes some milliseconds


def sweep_cautions(resolved: ResolvedPlan) -> list[Caution]:
    """Checks of a plan's runs, grouped, up to ``MOST_CHECKED``; of the coarse grid, where points are chosen later."""
    from helimag.sweeps.rounds import scenarios

    points = list(_points(resolved))
    made = [(point, s) for point, s in zip(points, scenarios(resolved, points), strict=True) if s is not None]
    return cautions((scenario for _, scenario in made), lambda run: _shown(resolved, made[run][0]))


def _points(resolved: ResolvedPlan) -> Iterator[dict[str, Value]]:
    wanted = resolved.plan.boundary
    if wanted is None:
        yield from resolved.spread(MOST_CHECKED, corners=True)
        return
    low, high = (np.array([axis.bounds[i] for axis in resolved.axes if axis.bounds]) for i in (0, 1))
    first, second = (axis.count or 2 for axis in resolved.plan.axis)
    for place in low + (high - low) * start_points((first, second), wanted.budget):
        yield {axis.field: float(x) for axis, x in zip(resolved.axes, place, strict=True)}


def _shown(resolved: ResolvedPlan, point: dict[str, Value]) -> str:
    """A point in words, such as ``drive.pitch = 12.7 deg``."""
    parts = []
    for axis in resolved.axes:
        value = point[axis.field]
        if axis.kind is not None and not isinstance(value, str):
            parts.append(f"{axis.field} = {value / q.parse(f'1 {axis.kind.shown}', axis.kind):.4g} {axis.kind.shown}")
        else:
            parts.append(f"{axis.field} = {value}")
    return ", ".join(parts)
