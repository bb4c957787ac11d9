"""From a plan to its points: base scenario, axes in SI, dimensions and chunks."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.engine import DEFAULT
from helimag.ensembles import Devices, noise_of
from helimag.errors import InputError
from helimag.scenario import Input, Parameters, Scenario, check_apart, load, varied
from helimag.sweeps.plan import Axis, EnsembleTable, Plan

Floats = NDArray[np.float64]
Value = float | str

SMALLEST_CHUNK, USUAL_CHUNK, LARGEST_CHUNK = 8, 64, 4096  # runs: what a kill may cost
USUAL_TURNS = 6000.0  # of the magnet in a run, half an hour: where runs are shorter, a chunk holds more of them
MANY_CHUNKS = 250  # beyond which chunks grow with the sweep: each is a file of every variable, looked at when reopened
LARGEST_TRAJECTORIES = 2**26  # bytes of a chunk larger than usual, which each worker holds in memory
MOST_RUNS = 1_000_000  # of one sweep: days of a large machine
MOST_SAMPLES = 10**9  # of all trajectories that a store keeps; 56 GB
CHUNKS = 16  # aimed at, so that a small sweep uses several cores too


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
class ResolvedPlan:
    """All points of a sweep: ``shape`` gives the length of each dimension.

    With ``devices``, the base has the likeliest one, and each point is run with that and with every one that was drawn.
    ``chunking`` is the shape of the chunks of a store that is there already, which may have been made by other rules;
    ``method`` takes the steps of all runs: the plan's, or else that of the store.
    """

    plan: Plan
    base: Scenario
    axes: tuple[ResolvedAxis, ...]
    shape: dict[str, int]
    devices: Devices | None = None
    chunking: tuple[int, ...] | None = None
    method: str = DEFAULT

    @property
    def size(self) -> int:
        """Number of points (the budget where they are chosen on the way)."""
        return math.prod(self.shape.values())

    @property
    def runs_each(self) -> int:
        """Runs of a point."""
        return 1 if self.devices is None else 1 + len(self.devices)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.size * self.runs_each

    @cached_property
    def chunk_shape(self) -> tuple[int, ...]:
        """Points of a chunk along each dimension: whole rows as far as they fit, or even parts of one."""
        if self.chunking is not None:
            return self.chunking
        left, lengths = max(1, self._runs_of_a_chunk() // self.runs_each), []
        for length in reversed(self.shape.values()):
            parts = math.ceil(length / max(1, min(length, left)))
            lengths.append(math.ceil(length / parts))  # even, rather than full ones and a rest
            left //= lengths[-1]
        return tuple(reversed(lengths))

    def _runs_of_a_chunk(self) -> int:
        if self.plan.boundary is not None:
            return SMALLEST_CHUNK
        turns = max(1.0, abs(self.base.drive.frequency) * self.longest)
        most = max(USUAL_CHUNK, min(LARGEST_CHUNK, int(USUAL_CHUNK * USUAL_TURNS / turns)))
        runs = max(SMALLEST_CHUNK, min(most, self.runs // CHUNKS), math.ceil(self.runs / MANY_CHUNKS))
        if self.plan.trajectory is None:
            return runs
        kept = 56.0 * (self.longest / self.plan.trajectory + 1.0)  # bytes a point: places and quaternions
        return min(runs, max(USUAL_CHUNK, int(LARGEST_TRAJECTORIES / kept) * self.runs_each))

    @property
    def longest(self) -> float:
        """Longest duration of a run (s)."""
        durations = [axis.values or axis.bounds or () for axis in self.axes if axis.field == "run.duration"]
        swept = [float(duration) for each in durations for duration in each]
        return max([self.base.run.duration, *swept])

    def spread(self, count: int, *, corners: bool = False) -> Iterator[dict[str, Value]]:
        """Values of the axes at up to ``count`` runs all over a plan on a grid or of samples, always the same ones."""
        names, lengths = list(self.shape), list(self.shape.values())
        chosen = np.random.default_rng(0).permutation(self.size)[:count].tolist()
        if corners and self.size > count:
            ends = zip(*product(*({0, length - 1} for length in lengths)), strict=True)
            chosen = [*np.ravel_multi_index(tuple(ends), lengths).tolist(), *chosen][:count]
        for place in sorted(set(chosen)):
            at = dict(zip(names, np.unravel_index(place, lengths), strict=True))
            yield {axis.field: axis.values[at[axis.dimension]] for axis in self.axes}

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
        """Number of points of a chunk along each dimension."""
        return tuple(part.stop - part.start for part in self.block(chunk))

    def points(self, chunk: int) -> Iterator[dict[str, Value]]:
        """Values of the axes at each point of a chunk, by field, last dimension fastest."""
        names = list(self.shape)
        for index in product(*(range(part.start, part.stop) for part in self.block(chunk))):
            at = dict(zip(names, index, strict=True))
            yield {axis.field: axis.values[at[axis.dimension]] for axis in self.axes}

    def scenario(self, values: Mapping[str, Value]) -> Scenario:
        """The scenario of one point.

        Returns
        -------
        Scenario
            The base with the axes' values.

        Raises
        ------
        InputError
            Where the values do not make a scenario.
        """
        if "run.duration" not in values:
            return varied(self._sampled_base, values)
        return varied(self.base, {**values, "run.interval": self._interval(float(values["run.duration"]))})

    @cached_property
    def _sampled_base(self) -> Scenario:
        """The base with the plan's samples, for points of its duration: their runs are not checked one by one."""
        return varied(self.base, {"run.interval": self._interval(self.base.run.duration)})

    def _interval(self, duration: float) -> float:
        """Time between samples of a run of some duration (s)."""
        return min(self.plan.trajectory or duration / self.plan.samples, duration)

    @cached_property
    def parameters(self) -> Parameters:
        """The axes as a vector within their bounds, of a plan that samples or chooses its points."""
        return Parameters.within(self.base, {axis.field: axis.bounds for axis in self.axes if axis.bounds})

    @cached_property
    def identity(self) -> dict[str, Any]:
        """All that decides the runs, flat: dotted name to value. Names and provenance do not."""
        told = {"name", "base", "changes", "duration", "ensemble", "method"}
        plan = self.plan.model_dump(mode="json", exclude=told, exclude_none=True)
        base = self.base.model_dump(mode="json", exclude={"name", "provenance"}, exclude_none=True)
        drawn = (
            {} if self.devices is None else {"ensemble": {"draws": len(self.devices), "sha256": self.devices.digest}}
        )
        return dict(_flat({**plan, **drawn, "method": self.method, "scenario": json.loads(json.dumps(base))}))


def resolve(plan: Plan) -> ResolvedPlan:
    """Load the base, apply the changes and turn the axes into SI.

    Returns
    -------
    ResolvedPlan
        Whose points can be run.

    Raises
    ------
    FileError
        Where the base or a fit cannot be loaded.
    InputError
        Where an axis' field or value does not fit, or the fit is not of the base's device.
    """
    changes = dict(plan.changes)
    if plan.duration is not None:
        changes["run.duration"] = plan.duration
    base = load(plan.base) if isinstance(plan.base, str) else plan.base
    base = varied(base, changes) if changes else base
    devices = None if plan.ensemble is None else _devices(plan, plan.ensemble, base)
    base = base if devices is None else devices.nominal(base)
    method = plan.method or DEFAULT
    _check_fields(plan, base)
    _check_size(plan, base)
    if plan.sample is not None or plan.boundary is not None:
        size = plan.sample.count if plan.sample else plan.boundary.budget if plan.boundary else 0
        return ResolvedPlan(plan, base, _spread(plan, base), {"point": size}, devices, method=method)
    axes: list[ResolvedAxis] = []
    shape: dict[str, int] = {}
    for axis in plan.axis:
        given = Input(axis.field)
        kind, name = _kind(given, base), given.label
        values = _values(plan, axis, given, base)
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
    resolved = ResolvedPlan(plan, base, tuple(axes), shape, devices, method=method)
    _check_runs(plan, resolved.longest, resolved.size)
    return resolved


def _devices(plan: Plan, table: EnsembleTable, base: Scenario) -> Devices:
    """The devices that a plan's points are run with."""
    from helimag.calibration import Posterior, drawn

    fit = Posterior.load(table.fit)
    noise = noise_of(base, table.noise, table.displacement or 0.0, "ensemble.noise")
    devices = drawn(fit, base, draws=table.draws, noise=noise, seed=table.seed)
    devices.check_apart_from([axis.field for axis in plan.axis], "an axis of the plan")
    return devices


def _check_runs(plan: Plan, duration: float, points: float) -> None:
    """Raise InputError where a plan has more runs, or keeps more samples of them, than a store can hold."""
    runs = points * (1 if plan.ensemble is None else 1 + plan.ensemble.draws)
    if runs > MOST_RUNS:
        raise InputError(
            f"the plan has {runs:.7g} runs, and a sweep at most {MOST_RUNS:.7g}; give its axes fewer values, let "
            "[sample] or [boundary] choose the points, or make several plans of it"
        )
    samples = points * duration / plan.trajectory if plan.trajectory else points
    if samples > MOST_SAMPLES:
        raise InputError(
            f"trajectory keeps {samples:.2g} samples of all runs together, and a store at most {MOST_SAMPLES:.2g}; "
            "make it longer than '" + q.show(plan.trajectory or 0.0, q.TIME) + "', or leave it out"
        )


def _check_size(plan: Plan, base: Scenario) -> None:
    """The same before any of its points is made: an axis' count, a sample's, a budget."""
    counts = [axis.count or 1 for axis in plan.axis]
    if plan.sample is not None:
        counts = [plan.sample.count]
    elif plan.boundary is not None:
        counts.append(plan.boundary.budget)
    _check_runs(plan, base.run.duration, float(min(max(counts), 10**18)))


def _check_fields(plan: Plan, base: Scenario) -> None:
    """Raise InputError where an axis is no input that a sweep can run through, or two change the same field."""
    for axis in plan.axis:
        if axis.field == "run.interval":
            raise InputError("axis 'run.interval' has no effect: the plan's own samples or trajectory decide it")
        if axis.form == "list":
            Input(axis.field).choices(base)
        else:
            Input(axis.field).check(base)
    check_apart({axis.field: axis for axis in plan.axis})


def _kind(given: Input, base: Scenario) -> q.Kind | None:
    return None if given.choices(base) else given.kind(base)


def _spread(plan: Plan, base: Scenario) -> tuple[ResolvedAxis, ...]:
    """The axes of a plan whose points are sampled now, or chosen on the way."""
    bounds: dict[str, tuple[float, float]] = {}
    for axis in plan.axis:
        low, high = (_number(axis, part, Input(axis.field), base) for part in ("start", "stop"))
        if not low < high:
            raise InputError(f"axis '{axis.field}' must have a start below its stop; got {axis.start} and {axis.stop}")
        bounds[axis.field] = low, high
    parameters, unit = Parameters.within(base, bounds), _unit_points(plan)
    points = np.empty((0, len(bounds))) if unit is None else parameters.from_unit(unit)
    return tuple(
        ResolvedAxis(given.path, given.label, "point", given.kind(base), tuple(column), bounds[given.path])
        for given, column in zip(parameters.inputs, points.T.tolist(), strict=True)
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


def _read(value: Value, given: Input, base: Scenario, where: str) -> Value:
    """A value in SI; a word stays one."""
    if given.choices(base):
        return value
    kind = given.kind(base)
    if kind is not None and not isinstance(value, str):
        raise InputError(f"{where} must be {kind.name} written with its unit, such as '{kind.example}'; got {value!r}")
    try:
        return given.parsed(base, value) if isinstance(value, str) else value
    except InputError as error:
        raise InputError(f"{where} {error}") from None


def _number(axis: Axis, part: str, given: Input, base: Scenario) -> float:
    return float(_read(getattr(axis, part), given, base, f"axis '{axis.field}': {part}"))


def _values(plan: Plan, axis: Axis, given: Input, base: Scenario) -> tuple[Value, ...]:
    """What an axis runs through, in SI."""
    if axis.values is not None:
        return tuple(_read(value, given, base, f"axis '{axis.field}':") for value in axis.values)
    kind = given.kind(base)
    start, stop = (_number(axis, part, given, base) for part in ("start", "stop"))
    if axis.count is not None:
        return tuple(_clean(value, kind) for value in np.linspace(start, stop, axis.count))
    step = _number(axis, "step", given, base)
    if not (step != 0.0 and (stop - start) / step >= 0.0):
        raise InputError(f"axis '{axis.field}' must have a step that leads from start to stop; got {axis.step}")
    _check_runs(plan, base.run.duration, (stop - start) / step)
    count = math.floor((stop - start) / step + 1e-9) + 1
    return tuple(_clean(start + i * step, kind) for i in range(count))


def _clean(value: float, kind: q.Kind | None) -> float:
    """The value as it would be read from text, so that 12.7 deg of a range equals 12.7 deg of a list bit for bit."""
    if kind is None:
        return float(f"{value:.12g}")
    return q.parse(f"{value / q.parse(f'1 {kind.shown}', kind):.12g} {kind.shown}", kind)


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
