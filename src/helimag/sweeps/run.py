"""The sweep itself: chunk after chunk into the store, and on from where it stopped."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import Verdict
from helimag.sweeps.compute import Kept, Rows
from helimag.sweeps.engines import Engine, Job, engine
from helimag.sweeps.export import load_sweep
from helimag.sweeps.plan import Plan, load_plan
from helimag.sweeps.resolved import resolve
from helimag.sweeps.rounds import check_first, chosen, planned
from helimag.sweeps.store import Store, check_names, kept_of

if TYPE_CHECKING:
    import xarray


@dataclass
class SweepProgress:
    """How a sweep stands: runs in all, runs in the store, the same with what is under way, and points by verdict."""

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
    progress: Callable[[SweepProgress], None] | None = None,
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
    resolved = resolve(plan if isinstance(plan, Plan) else load_plan(plan))
    check_names(resolved)
    check_first(resolved)
    place = Path(out)
    with ExitStack() as opened:
        # a scheduler that does not answer must not leave a store behind that nothing was computed for
        where = None if place.exists() else opened.enter_context(engine(scheduler, threads))
        store = opened.enter_context(Store.opened(place, resolved))
        resolved, kept = store.resolved, kept_of(store.resolved)
        state = SweepProgress(total=resolved.runs)
        for chunk in sorted(store.done):
            _count(state, np.asarray(store.read(chunk, "verdict")), resolved.runs_each)
        state.found, state.worked = state.done, state.done
        if len(store.done) < len(resolved.chunks):
            where = where or opened.enter_context(engine(scheduler, threads))
            wanted = resolved.plan.boundary
            rounds = chosen(resolved, store, wanted) if wanted else planned(resolved, store)
            for jobs, columns in rounds:
                _run(where, jobs, columns, store, kept, state, progress)
    return load_sweep(place)


def _run(
    where: Engine,
    jobs: Sequence[Job],
    columns: dict[int, Rows],
    store: Store,
    kept: Kept,
    state: SweepProgress,
    progress: Callable[[SweepProgress], None] | None,
) -> None:
    """Compute jobs, commit each as it comes, and report."""
    begun = time.monotonic() - state.seconds
    runs = state.total / len(store.resolved.chunks)

    def report(under_way: float) -> None:
        state.seconds = time.monotonic() - begun
        state.worked = state.done + under_way * runs
        if progress is not None:
            progress(state)

    for chunk, rows in where.results(jobs, kept, report):
        store.commit(chunk, {**rows, **columns.get(chunk, {})})
        _count(state, np.asarray(rows["verdict"]), store.resolved.runs_each)
        report(0.0)


def _count(state: SweepProgress, verdicts: NDArray[np.generic], runs_each: int) -> None:
    known = verdicts[verdicts != Verdict.NOT_COMPUTED]
    state.done += known.size * runs_each
    flags, counts = np.unique(known, return_counts=True)
    state.counts.update({str(Verdict.of(flag)): int(count) for flag, count in zip(flags, counts, strict=True)})
