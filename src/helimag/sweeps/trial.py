"""What a sweep will take, measured by a short trial: some of its runs, and an empty store with two chunks of noise."""

import math
import os
import tempfile
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from helimag.engine import advancing, method_named
from helimag.errors import InputError
from helimag.scenario import Scenario
from helimag.sweeps.boundary import start_points
from helimag.sweeps.compute import Kept, compute, empty_rows
from helimag.sweeps.engines import Job, Threads
from helimag.sweeps.plan import Plan, load_plan
from helimag.sweeps.resolved import ResolvedPlan, Value, resolve
from helimag.sweeps.rounds import check_first, scenarios
from helimag.sweeps.store import Store, check_names, kept_of

FEWEST_RUNS, MOST_RUNS = 8, 400  # of a trial: for each core that steps runs abreast, and in all
TRIAL_SECONDS = 3.0  # of whole runs, where so many can be made
SHORT_SHARE = 0.05  # of the duration of a run that is only begun, but at least ...
SHORT_SECONDS = 60.0  # ... this long, as far as the runs are


@dataclass(frozen=True)
class Estimate:
    """What a sweep will take: runs, seconds and bytes, from a trial of some runs, ``whole`` or only begun."""

    runs: int
    seconds: float
    bytes: int
    trial_runs: int
    trial_seconds: float
    whole: bool


def estimate(plan: Plan | str | Path, *, threads: int | None = None) -> Estimate:
    """Make some runs of a sweep as it would, and extrapolate to all.

    Whole runs, where a few seconds suffice for :data:`FEWEST_RUNS`; otherwise as many for each thread are begun for a
    twentieth of their duration, and ends before their time, which make runs cheaper, are not seen.

    Returns
    -------
    Estimate
        Runs, seconds and bytes.

    Raises
    ------
    FileError, InputError
        As for :func:`sweep`.
    """
    resolved = resolve(plan if isinstance(plan, Plan) else load_plan(plan))
    check_names(resolved)
    check_first(resolved)
    cores = threads or os.cpu_count() or 1
    first = scenarios(resolved, _spread_points(resolved, min(MOST_RUNS, FEWEST_RUNS * cores)))
    valid = [scenario for scenario in first if scenario is not None]
    if not valid:
        raise InputError("none of the plan's points that were tried makes a valid scenario")
    lengths = [scenario.run.duration for scenario in valid]
    trials = [min(length, max(SHORT_SECONDS, SHORT_SHARE * length)) for length in lengths]
    short = [scenario.replaced({"run.duration": trial}) for scenario, trial in zip(valid, trials, strict=True)]
    short = short[: max(1, len(first) // resolved.runs_each)]  # a point with devices is many runs
    compute(short[:1], Kept(method=resolved.method), threads=1)  # imports where that is still to be done
    _compile(short, resolved)
    _compile(valid, resolved)
    took, tried = _seconds(short, resolved, cores), math.fsum(trials[: len(short)])
    each, count, whole = took * math.fsum(lengths) / tried / len(first), len(short), False
    if each * min(FEWEST_RUNS, resolved.size) <= TRIAL_SECONDS:
        points = _spread_points(resolved, min(MOST_RUNS, max(len(first), int(TRIAL_SECONDS / each))))
        begun = time.perf_counter()
        made = scenarios(resolved, points)
        making = time.perf_counter() - begun
        took = making + _seconds(made, resolved, cores)
        each, count, whole = took / len(made), len(made), True
    size, writing = _store(resolved)
    runs = count * resolved.runs_each
    return Estimate(resolved.runs, each * resolved.size + writing, size, runs, took, whole)


def _compile(runs: Sequence[Scenario], resolved: ResolvedPlan) -> None:
    """Have the kernels there that runs take beside others and by themselves; none is run."""
    for batch in (runs, runs[:1]):
        with closing(advancing(batch, method=method_named(resolved.method), threads=1)):  # type: ignore[type-var]
            pass


def _seconds(made: Sequence[Scenario | None], resolved: ResolvedPlan, cores: int) -> float:
    """How long runs take (s), as many at once as in the sweep: chunks of neighbours, of its size or evenly smaller."""
    parts = min(len(made), cores * math.ceil(len(made) / (cores * math.prod(resolved.chunk_shape))))
    ends = [len(made) * part // parts for part in range(parts + 1)]
    jobs: list[Job] = [(part, partial(list, made[ends[part] : ends[part + 1]])) for part in range(parts)]
    begun = time.perf_counter()
    for _ in Threads(cores).results(jobs, kept_of(resolved), lambda _: None):
        pass
    return time.perf_counter() - begun


def _spread_points(resolved: ResolvedPlan, count: int) -> list[dict[str, Value]]:
    """Points all over a plan."""
    if resolved.plan.boundary is not None:
        rows = resolved.parameters.from_unit(start_points((4, 4), count)).tolist()
        return [dict(zip(resolved.parameters.paths, row, strict=True)) for row in rows]
    return list(resolved.spread(count))


def _store(resolved: ResolvedPlan) -> tuple[int, float]:
    """Bytes of the finished store on disk, and how long it takes to write (s): two chunks of noise are written."""
    kept = kept_of(resolved)
    noise = np.random.default_rng(0)
    sizes, clocks = [], [time.perf_counter()]
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "trial.zarr"
        with Store.opened(place, resolved) as store:
            clocks.append(time.perf_counter())
            for chunk in range(min(2, len(resolved.chunks))):
                count = math.prod(resolved.extent(chunk))
                rows = empty_rows(count, kept)
                for name, values in rows.items():
                    if values.dtype == np.float64:
                        rows[name] = noise.normal(size=values.shape)
                rows |= {axis.name: np.zeros(count) for axis in resolved.axes if not axis.values}
                before = time.perf_counter()
                store.commit(chunk, rows)
                clocks.append(time.perf_counter() - before)
                sizes.append(_size(place))
        folder_size = len(store.names) * _blocks(place / store.names[0] / "c")
    begun, opened, *commits = clocks
    first, second, every = (_folders(resolved.chunks[:count]) for count in (1, 2, len(resolved.chunks)))
    more = sizes[-1] - sizes[0] - folder_size * (second - first)
    size = sizes[0] + more * (len(resolved.chunks) - 1) + folder_size * (every - first)
    return size, opened - begun + commits[-1] * len(resolved.chunks)


def _folders(chunks: Sequence[tuple[int, ...]]) -> int:
    """How many folders of a variable hold chunks of several rows."""
    return len({index[:depth] for index in chunks for depth in range(1, len(index))})


def _size(folder: Path) -> int:
    """Bytes that a folder takes on disk."""
    return sum(map(_blocks, folder.rglob("*")))


def _blocks(path: Path) -> int:
    """Bytes that a file or a folder by itself takes on disk, in whole blocks."""
    found = path.lstat()
    return getattr(found, "st_blocks", found.st_size // 512) * 512
