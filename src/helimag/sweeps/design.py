"""From a plan to its points: base scenario, axes in SI, dimensions and chunks."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario import Quantity, Scenario, load
from helimag.sweeps.plan import Axis, Plan

Floats = NDArray[np.float64]
Value = float | str

LARGEST_CHUNK = 64  # runs: what a kill may cost, and what is held in memory at once for each worker
SMALLEST_CHUNK = 8
CHUNKS = 16  # aimed at, so that a small sweep uses several cores too
SPEED = "drive.speed"


@dataclass(frozen=True)
class ResolvedAxis:
    """An axis with its values in SI (or text), along one dimension of the sweep; no values where chosen later."""

    field: str
    name: str
    dimension: str
    kind: q.Kind | None
    values: tuple[Value, ...]
    bounds: tuple[float, float] | None = None


@dataclass(frozen=True)
class Design:
    """All points of a sweep: ``shape`` gives the length of each dimension."""

    plan: Plan
    base: Scenario
    axes: tuple[ResolvedAxis, ...]
    shape: dict[str, int]

    @property
    def size(self) -> int:
        """Number of runs (the budget where points are chosen on the way)."""
        return math.prod(self.shape.values())

    @cached_property
    def chunk_shape(self) -> tuple[int, ...]:
        """Runs of a chunk along each dimension: whole rows as far as they fit."""
        left = SMALLEST_CHUNK
        if self.plan.boundary is None:
            left = min(LARGEST_CHUNK, max(SMALLEST_CHUNK, self.size // CHUNKS))
        lengths = []
        for length in reversed(self.shape.values()):
            lengths.append(max(1, min(length, left)))
            left //= lengths[-1]
        return tuple(reversed(lengths))

    @cached_property
    def chunks(self) -> list[tuple[int, ...]]:
        """Index of each chunk along the dimensions, in the order of running."""
        counts = [math.ceil(length / size) for length, size in zip(self.shape.values(), self.chunk_shape, strict=True)]
        return list(product(*(range(count) for count in counts)))

    def block(self, chunk: int) -> tuple[slice, ...]:
        """Where a chunk lies in the arrays."""
        return tuple(
            slice(i * size, min((i + 1) * size, length))
            for i, size, length in zip(self.chunks[chunk], self.chunk_shape, self.shape.values(), strict=True)
        )

    def extent(self, chunk: int) -> tuple[int, ...]:
        """Number of runs of a chunk along each dimension."""
        return tuple(part.stop - part.start for part in self.block(chunk))

    def points(self, chunk: int) -> Iterator[dict[str, Value]]:
        """Values of the axes at each run of a chunk, by field, last dimension fastest."""
        names = list(self.shape)
        for index in product(*(range(part.start, part.stop) for part in self.block(chunk))):
            at = dict(zip(names, index, strict=True))
            yield {axis.field: axis.values[at[axis.dimension]] for axis in self.axes}

    def scenario(self, values: Mapping[str, Value]) -> Scenario:
        """The scenario of one point.

        Raises
        ------
        InputError
            Where the values do not make a scenario.
        """
        changes: dict[str, object] = {field: value for field, value in values.items() if field != SPEED}
        if SPEED in values:
            changes["drive.velocity"] = _velocity(self.base, float(values[SPEED]))
        duration = float(values.get("run.duration", self.base.run.duration))
        changes["run.interval"] = min(self.plan.trajectory or duration / self.plan.samples, duration)
        return self.base.replaced(changes)

    @cached_property
    def identity(self) -> dict[str, Any]:
        """All that decides the runs, flat: dotted name to value. Names and provenance do not."""
        plan = self.plan.model_dump(mode="json", exclude={"name", "base", "changes", "duration"}, exclude_none=True)
        base = self.base.model_dump(mode="json", exclude={"name", "provenance"}, exclude_none=True)
        return dict(_flat({**plan, "scenario": json.loads(json.dumps(base))}))


def resolve(plan: Plan) -> Design:
    """Load the base, apply the changes and turn the axes into SI.

    Raises
    ------
    FileError
        Where the base cannot be loaded.
    InputError
        Where an axis' field or value does not fit.
    """
    changes = dict(plan.changes)
    if plan.duration is not None:
        changes["run.duration"] = plan.duration
    base = load(plan.base) if isinstance(plan.base, str) else plan.base
    base = base.replaced(changes) if changes else base
    names = _names([axis.field for axis in plan.axis])
    if plan.sample is not None or plan.boundary is not None:
        size = plan.sample.count if plan.sample else plan.boundary.budget if plan.boundary else 0
        return Design(plan, base, _spread(plan, base, names), {"point": size})
    axes: list[ResolvedAxis] = []
    shape: dict[str, int] = {}
    for axis, name in zip(plan.axis, names, strict=True):
        kind = kind_of(base, axis.field)
        values = _values(axis, kind)
        dimension = axis.zip or name
        if shape.setdefault(dimension, len(values)) != len(values):
            raise InputError(
                f"axes zipped as '{dimension}' must have as many values each; got {shape[dimension]} and {len(values)}"
            )
        if axis.zip is None and len(set(values)) < len(values):
            raise InputError(f"axis '{axis.field}' must not have a value twice")
        axes.append(ResolvedAxis(axis.field, name, dimension, kind, values))
    if set(shape) & {axis.name for axis in axes if axis.name != axis.dimension}:
        raise InputError("the name of a zip must not be an axis' name")
    return Design(plan, base, tuple(axes), shape)


def _spread(plan: Plan, base: Scenario, names: list[str]) -> tuple[ResolvedAxis, ...]:
    """The axes of a plan whose points are sampled now, or chosen on the way."""
    kinds = [kind_of(base, axis.field) for axis in plan.axis]
    bounds = [
        (_number(axis, "start", kind), _number(axis, "stop", kind)) for axis, kind in zip(plan.axis, kinds, strict=True)
    ]
    for axis, (low, high) in zip(plan.axis, bounds, strict=True):
        if not low < high:
            raise InputError(f"axis '{axis.field}' must have a start below its stop; got {axis.start} and {axis.stop}")
    unit = _unit_points(plan)
    columns = [
        tuple((low + (high - low) * unit[:, i]).tolist()) if unit is not None else ()
        for i, (low, high) in enumerate(bounds)
    ]
    return tuple(
        ResolvedAxis(axis.field, name, "point", kind, column, bound)
        for axis, name, kind, column, bound in zip(plan.axis, names, kinds, columns, bounds, strict=True)
    )


def _unit_points(plan: Plan) -> Floats | None:
    """Sampled points in the unit cube, (count, axes); None where the plan does not sample."""
    if plan.sample is None:
        return None
    from scipy.stats import qmc

    count, dimensions = plan.sample.count, len(plan.axis)
    if plan.sample.method == "latin-hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=plan.sample.seed).random(count))
    # a Sobol sequence is balanced in powers of two; its beginning is still spread evenly
    powers = math.ceil(math.log2(count)) if count > 1 else 0
    return np.asarray(qmc.Sobol(dimensions, rng=plan.sample.seed).random_base2(powers)[:count])


def kind_of(scenario: Scenario, field: str) -> q.Kind | None:
    """The physical kind of a scenario's field; None for a field without a unit.

    Raises
    ------
    InputError
        Where there is no such field, or it is not a single value.
    """
    if field == SPEED:
        return q.VELOCITY
    at: Any = scenario
    *parents, last = field.split(".")
    for step in parents:
        at = getattr(at, step, None) if step in getattr(type(at), "model_fields", {}) else None
        if isinstance(at, tuple) and step == "magnet" and len(at) == 1:
            at = at[0]
    fields = getattr(type(at), "model_fields", {})
    if last not in fields:
        scenario.replaced({field: 0.0})  # its message names what is there instead
        raise InputError(f"'{field}' is not a single field of the scenario")
    marks = [*fields[last].metadata, *(m for arg in get_args(fields[last].annotation) for m in get_args(arg)[1:])]
    found = [mark.kind for mark in marks if isinstance(mark, Quantity)]
    if isinstance(getattr(at, last), tuple) or hasattr(getattr(at, last), "model_fields"):
        raise InputError(f"axis '{field}' must be a single value of the scenario; name one of its parts")
    return found[0] if found else None


def _names(fields: list[str]) -> list[str]:
    """Coordinate names: the drive's own (``pitch``), others with their part (``helix_pitch``)."""
    return [
        field.removeprefix("drive.") if field.startswith("drive.") else "_".join(field.split(".")[1:]) or field
        for field in fields
    ]


def _read(value: Value, kind: q.Kind | None, where: str) -> Value:
    """A value in SI; text stays text in a field without a unit."""
    if kind is None:
        return value
    try:
        if isinstance(value, str):
            return q.parse(value, kind)
    except InputError as error:
        raise InputError(f"{where} {error}") from None
    raise InputError(f"{where} must be {kind.name} written with its unit, such as '{kind.example}'; got {value!r}")


def _number(axis: Axis, part: str, kind: q.Kind | None) -> float:
    value = _read(getattr(axis, part), kind, f"axis '{axis.field}': {part}")
    if isinstance(value, str):
        raise InputError(f"axis '{axis.field}' has no numbers in between; give its values as a list")
    return value


def _values(axis: Axis, kind: q.Kind | None) -> tuple[Value, ...]:
    """What an axis runs through, in SI."""
    if axis.values is not None:
        return tuple(_read(value, kind, f"axis '{axis.field}':") for value in axis.values)
    start, stop = _number(axis, "start", kind), _number(axis, "stop", kind)
    if axis.count is not None:
        return tuple(_clean(value, kind) for value in np.linspace(start, stop, axis.count))
    step = _number(axis, "step", kind)
    if not (step != 0.0 and (stop - start) / step >= 0.0):
        raise InputError(f"axis '{axis.field}' must have a step that leads from start to stop; got {axis.step}")
    count = math.floor((stop - start) / step + 1e-9) + 1
    return tuple(_clean(start + i * step, kind) for i in range(count))


def _clean(value: float, kind: q.Kind | None) -> float:
    """The value as it would be read from text, so that 12.7 deg of a range equals 12.7 deg of a list bit for bit."""
    if kind is None:
        return float(f"{value:.12g}")
    return q.parse(f"{value / q.parse(f'1 {kind.shown}', kind):.12g} {kind.shown}", kind)


def _velocity(base: Scenario, speed: float) -> tuple[float, float, float]:
    x, y, z = base.drive.velocity
    length = math.hypot(x, y, z)
    return (speed, 0.0, 0.0) if length == 0.0 else (x / length * speed, y / length * speed, z / length * speed)


def _flat(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Leaves of nested dictionaries and lists, by dotted path."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _flat(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, (list, tuple)) and any(isinstance(item, Mapping) for item in value):
        for i, item in enumerate(value):
            yield from _flat(item, f"{path}.{i}")
    else:
        yield path, list(value) if isinstance(value, tuple) else value
