"""What a sweep will take, measured by a short trial."""

import math
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from helimag.errors import InputError
from helimag.sweeps.boundary import start_points
from helimag.sweeps.compute import Kept, compute, empty_rows
from helimag.sweeps.plan import Plan, load_plan
from helimag.sweeps.resolved import ResolvedPlan, Value, resolve
from helimag.sweeps.rounds import check_first, scenarios
from helimag.sweeps.store import Store, check_names, sample_times

TRIAL_RUNS = 8
TRIAL_SHARE = 0.05  # of the duration, but at least ...
TRIAL_SECONDS = 60.0  # ... this long, as far as the runs are


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
    resolved = resolve(plan if isinstance(plan, Plan) else load_plan(plan))
    check_names(resolved)
    check_first(resolved)
    cores = threads or os.cpu_count() or 1
    points = _spread_points(resolved, max(TRIAL_RUNS, cores))
    valid = [scenario for scenario in scenarios(resolved, points) if scenario is not None]
    if not valid:
        raise InputError("none of the plan's points that were tried makes a valid scenario")
    lengths = [scenario.run.duration for scenario in valid]
    trials = [min(length, max(TRIAL_SECONDS, TRIAL_SHARE * length)) for length in lengths]
    short = [scenario.replaced({"run.duration": trial}) for scenario, trial in zip(valid, trials, strict=True)]
    compute(short[:1], threads=1)  # compiles where that is still to be done
    begun = time.perf_counter()
    compute(short, threads=1)
    took = time.perf_counter() - begun
    seconds = took * math.fsum(lengths) / math.fsum(trials) / len(valid) * resolved.runs / min(cores, resolved.runs)
    return Estimate(resolved.runs, seconds, _disk(resolved), len(short), took)


def _spread_points(resolved: ResolvedPlan, count: int) -> list[dict[str, Value]]:
    """Points all over a plan."""
    if resolved.plan.boundary is not None:
        rows = resolved.parameters.from_unit(start_points((4, 4), count)).tolist()
        return [dict(zip(resolved.parameters.paths, row, strict=True)) for row in rows]
    chosen = np.unique(np.linspace(0, len(resolved.chunks) - 1, count).astype(int))
    each = math.ceil(count / len(chosen))
    return [point for chunk in chosen for point in list(resolved.points(int(chunk)))[:: max(1, 64 // each)][:each]]


def _disk(resolved: ResolvedPlan) -> int:
    """Bytes on disk of the finished store: chunks of noise are written and measured, the first with its folders."""
    kept = Kept(sample_times(resolved), resolved.devices)
    noise = np.random.default_rng(0)
    sizes = []
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "trial.zarr"
        with Store.opened(place, resolved) as store:
            for chunk in range(min(2, len(resolved.chunks))):
                count = math.prod(resolved.extent(chunk))
                rows = empty_rows(count, kept)
                for name, values in rows.items():
                    if values.dtype == np.float64:
                        rows[name] = noise.normal(size=values.shape)
                rows |= {axis.name: np.zeros(count) for axis in resolved.axes if not axis.values}
                store.commit(chunk, rows)
                sizes.append(_size(place))
    return sizes[0] + (sizes[-1] - sizes[0]) * (len(resolved.chunks) - 1)


def _size(folder: Path) -> int:
    """Bytes that a folder takes on disk, in whole blocks."""
    return sum(getattr(s, "st_blocks", s.st_size // 512) * 512 for s in (p.lstat() for p in folder.rglob("*")))
