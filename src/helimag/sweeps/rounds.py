"""Which chunks to compute next: all of a plan at once, or round after round where the verdict changes."""

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import Verdict
from helimag.scenario import Scenario
from helimag.sweeps.boundary import ROUND, Seen, next_points, start_points
from helimag.sweeps.compute import Rows
from helimag.sweeps.engines import Job
from helimag.sweeps.plan import Boundary
from helimag.sweeps.resolved import ResolvedPlan, Value
from helimag.sweeps.store import Store


def planned(resolved: ResolvedPlan, store: Store) -> Iterator[tuple[list[Job], dict[int, Rows]]]:
    """All chunks that are not in the store, at once."""
    left = [chunk for chunk in range(len(resolved.chunks)) if chunk not in store.done]
    yield [(chunk, partial(_scenarios_of, resolved, chunk)) for chunk in left], {}


def chosen(resolved: ResolvedPlan, store: Store, wanted: Boundary) -> Iterator[tuple[list[Job], dict[int, Rows]]]:
    """Round after round of points near the change of verdict; what is stored already decides as if it had just come."""
    unit = start_points((resolved.plan.axis[0].count or 2, resolved.plan.axis[1].count or 2), wanted.budget)
    size = resolved.chunk_shape[0]
    while True:
        chunks = range(math.ceil(len(unit) / size))
        jobs: list[Job] = []
        columns: dict[int, Rows] = {}
        for chunk in chunks:
            if chunk in store.done:
                continue
            part = resolved.parameters.from_unit(unit[resolved.block(chunk)[0]])
            lost = resolved.extent(chunk)[0] - len(part)  # the last round may end within a chunk
            filled = np.concatenate([part, np.full((lost, 2), np.nan)])
            columns[chunk] = {axis.name: filled[:, i] for i, axis in enumerate(resolved.axes)}
            values: list[dict[str, Value]] = [
                {axis.field: float(x) for axis, x in zip(resolved.axes, row, strict=True)} for row in part
            ]
            jobs.append((chunk, partial(scenarios, resolved, values)))
        if jobs:
            yield jobs, columns
        if len(unit) >= wanted.budget:
            return
        new = next_points(
            _seen(resolved, store, wanted, unit), min(ROUND, wanted.budget - len(unit)), wanted.resolution
        )
        new = new[: len(new) - len(new) % size] if len(unit) + len(new) < wanted.budget else new
        if len(new) == 0:
            return
        unit = np.concatenate([unit, new])


def _seen(resolved: ResolvedPlan, store: Store, wanted: Boundary, unit: NDArray[np.float64]) -> Seen:
    """Results at the points run so far."""
    chunks = range(math.ceil(len(unit) / resolved.chunk_shape[0]))
    names = ("verdict", "height_change", "escape_time", "end_time")
    found = {name: np.concatenate([store.read(chunk, name) for chunk in chunks])[: len(unit)] for name in names}
    lost = np.asarray(found["escape_time"], dtype=float)
    held = np.where(np.isnan(lost), 1.0, lost / resolved.base.run.duration)
    return Seen(
        points=unit,
        inside=np.asarray(found["verdict"] == Verdict.of(wanted.verdict)),
        rises=np.asarray(found["height_change"] > 0.0),
        held=held,
    )


def _scenarios_of(resolved: ResolvedPlan, chunk: int) -> list[Scenario | None]:
    return scenarios(resolved, list(resolved.points(chunk)))


def scenarios(resolved: ResolvedPlan, points: Sequence[dict[str, Value]]) -> list[Scenario | None]:
    """One scenario a point; None where the values make no valid one."""
    made: list[Scenario | None] = []
    for values in points:
        try:
            made.append(resolved.scenario(values))
        except InputError:
            made.append(None)
    return made


def check_first(resolved: ResolvedPlan) -> None:
    """Raise InputError where no point of the first and last chunk makes a scenario: then the plan is wrong."""
    if resolved.plan.boundary is not None:
        bounds = (resolved.parameters.low, resolved.parameters.high)
        points: list[dict[str, Value]] = [
            dict(zip(resolved.parameters.paths, row.tolist(), strict=True)) for row in bounds
        ]
    else:
        points = list(resolved.points(0)) + list(resolved.points(len(resolved.chunks) - 1))
    if all(made is None for point in points for made in scenarios(resolved, [point])):  # up to the first that is one
        resolved.scenario(points[0])
