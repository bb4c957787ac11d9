"""The sweep itself: chunk after chunk into the store, and on from where it stopped."""

import math
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.scenario import Scenario
from helimag.sweeps.boundary import ROUND, Seen, next_points, start_points
from helimag.sweeps.compute import Outcome, Rows, compute, empty_rows, label
from helimag.sweeps.design import Design, Value, resolve
from helimag.sweeps.engines import Engine, Job, engine
from helimag.sweeps.export import load_sweep
from helimag.sweeps.plan import Plan, load_plan
from helimag.sweeps.store import Store, sample_times

if TYPE_CHECKING:
    import xarray

TRIAL_RUNS = 8
TRIAL_SHARE = 0.05  # of the duration, but at least ...
TRIAL_SECONDS = 60.0  # ... this long, as far as the runs are


@dataclass
class Progress:
    """How a sweep stands: runs in all, runs in the store, the same with what is under way, and counts by verdict."""

    total: int
    done: int = 0
    worked: float = 0.0
    found: int = 0  # in the store already when this sweep began
    seconds: float = 0.0
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def rate(self) -> float:
        """Runs per second since this sweep began."""
        return (self.worked - self.found) / self.seconds if self.seconds > 0.0 else 0.0


def sweep(
    plan: Plan | str | Path,
    *,
    out: str | Path,
    scheduler: str | None = None,
    threads: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> "xarray.Dataset":
    """Run a plan into a store, or go on with it where the store is there already.

    Parameters
    ----------
    plan
        A plan, or the path of a plan's TOML file.
    out
        The store: a zarr directory.
    scheduler
        Address of a dask.distributed scheduler to send the chunks to; default threads on this machine.
    threads
        How many threads; default one a core.
    progress
        Called some times a second.

    Returns
    -------
    xarray.Dataset
        Labelled, SI (angles in radians), read from the store when used. Failed runs are in it, flagged.

    Raises
    ------
    FileError
        Where the store cannot be made, read or written, is damaged or in use, or no scheduler answers.
    InputError
        Where the plan does not fit, or is not the store's.
    """
    design = resolve(plan if isinstance(plan, Plan) else load_plan(plan))
    _check_first(design)
    place = Path(out)
    times = sample_times(design)
    with Store.opened(place, design) as store:
        state = Progress(total=design.size)
        for chunk in sorted(store.done):
            _count(state, np.asarray(store.read(chunk, "verdict")))
        state.found, state.worked = state.done, state.done
        if len(store.done) < len(design.chunks):
            with engine(scheduler, threads) as where:
                rounds = _chosen(design, store) if design.plan.boundary else _planned(design, store)
                for jobs, columns in rounds:
                    _run(where, jobs, columns, store, times, state, progress)
    return load_sweep(place)


def _run(
    where: Engine,
    jobs: Sequence[Job],
    columns: dict[int, Rows],
    store: Store,
    times: NDArray[np.float64] | None,
    state: Progress,
    progress: Callable[[Progress], None] | None,
) -> None:
    """Compute jobs, commit each as it comes, and report."""
    begun = time.monotonic() - state.seconds
    runs = state.total / len(store.design.chunks)

    def report(under_way: float) -> None:
        state.seconds = time.monotonic() - begun
        state.worked = state.done + under_way * runs
        if progress is not None:
            progress(state)

    for chunk, rows in where.results(jobs, times, report):
        store.commit(chunk, {**rows, **columns.get(chunk, {})})
        _count(state, np.asarray(rows["verdict"]))
        report(0.0)


def _planned(design: Design, store: Store) -> Iterator[tuple[list[Job], dict[int, Rows]]]:
    """All chunks that are not in the store, at once."""
    left = [chunk for chunk in range(len(design.chunks)) if chunk not in store.done]
    yield [(chunk, partial(_scenarios_of, design, chunk)) for chunk in left], {}


def _chosen(design: Design, store: Store) -> Iterator[tuple[list[Job], dict[int, Rows]]]:
    """Round after round of points near the change of verdict; what is stored already decides as if it had just come."""
    wanted = design.plan.boundary
    assert wanted is not None
    low, high = (np.array([axis.bounds[i] for axis in design.axes if axis.bounds]) for i in (0, 1))
    unit = start_points((design.plan.axis[0].count or 2, design.plan.axis[1].count or 2), wanted.budget)
    size = design.chunk_shape[0]
    while True:
        chunks = range(math.ceil(len(unit) / size))
        jobs: list[Job] = []
        columns: dict[int, Rows] = {}
        for chunk in chunks:
            if chunk in store.done:
                continue
            part = low + (high - low) * unit[design.block(chunk)[0]]
            lost = design.extent(chunk)[0] - len(part)  # the last round may end within a chunk
            filled = np.concatenate([part, np.full((lost, 2), np.nan)])
            columns[chunk] = {axis.name: filled[:, i] for i, axis in enumerate(design.axes)}
            values: list[dict[str, Value]] = [
                {axis.field: float(x) for axis, x in zip(design.axes, row, strict=True)} for row in part
            ]
            jobs.append((chunk, partial(_scenarios, design, values)))
        if jobs:
            yield jobs, columns
        if len(unit) >= wanted.budget:
            return
        new = next_points(_seen(design, store, unit), min(ROUND, wanted.budget - len(unit)), wanted.resolution)
        new = new[: len(new) - len(new) % size] if len(unit) + len(new) < wanted.budget else new
        if len(new) == 0:
            return
        unit = np.concatenate([unit, new])


def _seen(design: Design, store: Store, unit: NDArray[np.float64]) -> Seen:
    """Results at the points run so far."""
    chunks = range(math.ceil(len(unit) / design.chunk_shape[0]))
    names = ("verdict", "height_change", "escape_time", "end_time")
    found = {name: np.concatenate([store.read(chunk, name) for chunk in chunks])[: len(unit)] for name in names}
    wanted = design.plan.boundary
    assert wanted is not None
    lost = np.asarray(found["escape_time"], dtype=float)
    held = np.where(np.isnan(lost), 1.0, lost / design.base.run.duration)
    return Seen(
        points=unit,
        inside=np.asarray(found["verdict"] == Outcome[wanted.verdict.upper().replace("-", "_")]),
        rises=np.asarray(found["height_change"] > 0.0),
        held=held,
    )


def _scenarios_of(design: Design, chunk: int) -> list[Scenario | None]:
    return _scenarios(design, list(design.points(chunk)))


def _scenarios(design: Design, points: Sequence[dict[str, Value]]) -> list[Scenario | None]:
    """One scenario a point; None where the values make no valid one."""
    made: list[Scenario | None] = []
    for values in points:
        try:
            made.append(design.scenario(values))
        except InputError:
            made.append(None)
    return made


def _check_first(design: Design) -> None:
    """Raise InputError where no point of the first and last chunk makes a scenario: then the plan is wrong."""
    if design.plan.boundary is not None:
        points: list[dict[str, Value]] = [
            {axis.field: axis.bounds[i] for axis in design.axes if axis.bounds} for i in (0, 1)
        ]
    else:
        points = list(design.points(0)) + list(design.points(len(design.chunks) - 1))
    if all(scenario is None for scenario in _scenarios(design, points)):
        design.scenario(points[0])


def _count(state: Progress, verdicts: NDArray[np.generic]) -> None:
    known = verdicts[verdicts != Outcome.NOT_COMPUTED]
    state.done += known.size
    state.counts.update(label(Outcome(int(flag))) for flag in known)


@dataclass(frozen=True)
class Estimate:
    """What a sweep will take: runs, seconds and bytes, both extrapolated from a trial."""

    runs: int
    seconds: float
    bytes: int
    trial_runs: int
    trial_seconds: float


def estimate(plan: Plan | str | Path, *, threads: int | None = None) -> Estimate:
    """Measure a few runs for a twentieth of their duration, and extrapolate. Runs that end early take less.

    Raises
    ------
    FileError, InputError
        As for :func:`sweep`.
    """
    design = resolve(plan if isinstance(plan, Plan) else load_plan(plan))
    _check_first(design)
    cores = threads or os.cpu_count() or 1
    points = _spread_points(design, max(TRIAL_RUNS, cores))
    valid = [scenario for scenario in _scenarios(design, points) if scenario is not None]
    if not valid:
        raise InputError("none of the plan's points that were tried makes a valid scenario")
    lengths = [scenario.run.duration for scenario in valid]
    trials = [min(length, max(TRIAL_SECONDS, TRIAL_SHARE * length)) for length in lengths]
    short = [scenario.replaced({"run.duration": trial}) for scenario, trial in zip(valid, trials, strict=True)]
    compute(short[:1], threads=1)  # compiles where that is still to be done
    begun = time.perf_counter()
    compute(short, threads=1)
    took = time.perf_counter() - begun
    seconds = took * math.fsum(lengths) / math.fsum(trials) / len(valid) * design.size / min(cores, design.size)
    return Estimate(design.size, seconds, _disk(design), len(short), took)


def _spread_points(design: Design, count: int) -> list[dict[str, Value]]:
    """Points all over a plan."""
    if design.plan.boundary is not None:
        unit = start_points((4, 4), count)
        bounds = [axis.bounds or (0.0, 0.0) for axis in design.axes]
        return [
            {
                axis.field: low + (high - low) * float(x)
                for axis, (low, high), x in zip(design.axes, bounds, row, strict=True)
            }
            for row in unit
        ]
    chosen = np.unique(np.linspace(0, len(design.chunks) - 1, count).astype(int))
    each = math.ceil(count / len(chosen))
    return [point for chunk in chosen for point in list(design.points(int(chunk)))[:: max(1, 64 // each)][:each]]


def _disk(design: Design) -> int:
    """Bytes on disk of the finished store: chunks of noise are written and measured, the first with its folders."""
    times = sample_times(design)
    noise = np.random.default_rng(0)
    sizes = []
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "trial.zarr"
        with Store.opened(place, design) as store:
            for chunk in range(min(2, len(design.chunks))):
                count = math.prod(design.extent(chunk))
                rows = empty_rows(count, times)
                for name, values in rows.items():
                    if values.dtype == np.float64:
                        rows[name] = noise.normal(size=values.shape)
                rows |= {axis.name: np.zeros(count) for axis in design.axes if not axis.values}
                store.commit(chunk, rows)
                sizes.append(_size(place))
    return sizes[0] + (sizes[-1] - sizes[0]) * (len(design.chunks) - 1)


def _size(folder: Path) -> int:
    """Bytes that a folder takes on disk, in whole blocks."""
    return sum(getattr(s, "st_blocks", s.st_size // 512) * 512 for s in (p.lstat() for p in folder.rglob("*")))
