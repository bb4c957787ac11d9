"""Runs under way: batches on threads, in launches short enough to report, to be stopped and to be gone on with."""

import logging
import math
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from helimag.engine.batch import TOLERANCE, Batch, Stepping, build_kernel, fits_lanes, goes_abreast, method_for, started
from helimag.engine.history import History
from helimag.engine.kernels import check_device, ready
from helimag.engine.methods import MULTIREVOLUTION, Method
from helimag.engine.packing import pack_bodies
from helimag.engine.start import start_state
from helimag.engine.system import System, system_of
from helimag.errors import InputError
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

LAUNCH_SECONDS = 0.1  # how long a launch may take before the host gets a word in
FIRST_BUDGET = 128_000  # steps of a first launch, all runs together
MOST_FIRST_STEPS = 1000  # of one run
MOST_RUNS_PER_BATCH = 16  # of long runs: twice what a vector register holds, so that it is full most often
SHORT_RUNS_PER_BATCH = 1024  # at most: what a batch costs by itself would be most of a few short runs' time
SHORT = 100.0  # turns of the magnet
LOG = logging.getLogger(__name__)
UNIT = 1e-15  # of a quaternion's length: one as near to 1 stays, so that a run from where another began has its bits
PATIENCE = 0.1  # s between looks at what is under way


def next_budget(budget: int, stepping: float, reading: float) -> int:
    """Steps of a next launch, from what one of ``budget`` took for its steps, and for reading them off the device (s).

    Launches are short, but not so short that reading what runs remember, gigabytes of a large batch on a GPU, takes
    longer than their steps.
    """
    wanted = max(LAUNCH_SECONDS, reading)
    return max(1, int(budget * min(4.0, wanted / max(stepping, 1e-6))))


@dataclass
class _Job:
    """Some runs with the same formulas and method: their places among all, and what is known of them."""

    system: System
    method: Method
    places: list[int]
    scenarios: list[Scenario]
    progress: NDArray[np.void]
    records: list[NDArray[np.void]]
    memories: list[dict[str, Floats]]
    batch: Batch | None = None

    def kernel(self, settings: Stepping) -> tuple[System, Method, bool, bool]:
        """What its kernel is built from."""
        settings = replace(settings, method=self.method)
        lanes, abreast = (fits(self.system, self.scenarios, settings) for fits in (fits_lanes, goes_abreast))
        return self.system, self.method, lanes, abreast

    def advance(self, settings: Stepping, stop: threading.Event) -> None:
        """Take the runs to their ends, or to where they are when told to stop."""
        settings = replace(settings, method=self.method)
        self.batch = Batch(self.system, self.scenarios, self.progress, settings, self.records, self.memories)
        budget = min(MOST_FIRST_STEPS, FIRST_BUDGET // len(self.scenarios) + 1)
        while self.batch.running and not stop.is_set():
            budget = next_budget(budget, *self.batch.launch(budget))


@dataclass(frozen=True)
class Underway:
    """A batch of runs on its way; what it says is as of now."""

    total: float
    _jobs: list[_Job] = field(repr=False)

    @property
    def fraction(self) -> float:
        """Share of the simulated time that is behind."""
        return math.fsum(job.batch.done for job in self._jobs if job.batch is not None) / self.total

    def histories(self) -> list[History | None]:
        """What has been recorded of each run so far, in order; None where it has not begun."""
        found: list[History | None] = [None] * sum(len(job.places) for job in self._jobs)
        for job in self._jobs:
            if job.batch is not None:
                for place, history in zip(job.places, job.batch.histories(), strict=True):
                    found[place] = history if history.time.size else None
        return found


def advancing(
    scenarios: Sequence[Scenario],
    *,
    initial_states: Floats | None = None,
    after: Sequence[History | None] | None = None,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    system: Callable[[Scenario], System] = system_of,
    device: str = "cpu",
    threads: int | None = None,
) -> Iterator[Underway]:
    """Run a batch and give a look at it some times a second; closing the iterator stops the runs where they are.

    Parameters
    ----------
    scenarios
        At least one. They may differ in everything; runs with the same formulas share launches.
    initial_states
        (runs, 7): head position (m) and quaternion w, x, y, z (normalised here). Default: each scenario's start.
    after
        What was recorded of these runs before they were stopped (:meth:`Underway.histories`): they go on from there,
        to the same numbers as if they had not been stopped.
    tolerance
        Of one step, in quaternion components and in positions over the helix' length.
    method
        What takes the steps; default leaps over turns of the magnet where they hold, and direct steps elsewhere: from
        the start where a run has too few turns for leaps to pay.
    system
        Which formulas a scenario is run with.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    threads
        CPU threads; default one a core.

    Yields
    ------
    Underway
        At least once, and last when all runs have ended.

    Raises
    ------
    InputError
        Where the batch is empty, or its states, its histories or the tolerance do not fit.
    """
    if not scenarios:
        raise InputError("scenarios must hold at least one; got none")
    if not tolerance > 0.0:
        raise InputError(f"tolerance must be greater than zero; got {tolerance}")
    check_device(device)
    states = _checked_states(scenarios, initial_states)
    pack_bodies(scenarios)  # a device that cannot be is refused before anything is compiled
    formulas = [system(scenario) for scenario in scenarios]
    kinds = [(of, method_for(of, scenario, method)) for of, scenario in zip(formulas, scenarios, strict=True)]
    workers = (threads or os.cpu_count() or 1) if device == "cpu" else 1
    size = _batch_size(scenarios, workers) if device == "cpu" else len(scenarios)
    jobs = _jobs(scenarios, kinds, states, _checked_histories(scenarios, after), size)
    for job in jobs:
        job.system.medium.pack(job.scenarios, device)  # tables are made here, where Ctrl-C is heard, and kept
    settings = Stepping(method, tolerance, device)
    for kernel in {job.kernel(settings): None for job in jobs}:
        ready(partial(build_kernel, *kernel), device)
    total = math.fsum(scenario.run.duration for scenario in scenarios)
    told = "1 run" if len(scenarios) == 1 else f"{len(scenarios)} runs"
    LOG.info("%s of %.6g s in all by the method '%s' on %s, %d threads", told, total, method.name, device, workers)
    return _watched(Underway(total, jobs), jobs, settings, workers)


def _watched(underway: Underway, jobs: list[_Job], settings: Stepping, workers: int) -> Iterator[Underway]:
    """Advance jobs on threads and look in now and then; the first failure is raised at once."""
    stop = threading.Event()
    with ThreadPoolExecutor(workers, thread_name_prefix="helimag-runs") as pool:
        pending: set[Future[None]] = {pool.submit(job.advance, settings, stop) for job in jobs}
        try:
            while pending:
                done, pending = wait(pending, timeout=PATIENCE, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
                yield underway
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


def advance(
    scenarios: Sequence[Scenario],
    *,
    initial_states: Floats | None = None,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    system: Callable[[Scenario], System] = system_of,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[History]:
    """Run a batch to its end and return the raw histories, in order. A run that breaks down has status ``NOT_FINITE``.

    Parameters
    ----------
    scenarios, initial_states, tolerance, method, system, device, threads
        As for :func:`advancing`.
    progress
        Called in this thread with the fraction done, some times a second; an exception raised there stops the runs.

    Returns
    -------
    list of History
        One for each scenario.

    Raises
    ------
    InputError
        As for :func:`advancing`.
    """
    looks = advancing(
        scenarios,
        initial_states=initial_states,
        tolerance=tolerance,
        method=method,
        system=system,
        device=device,
        threads=threads,
    )
    histories: list[History | None] = []
    with closing(looks):  # type: ignore[type-var]
        for underway in looks:
            if progress is not None:
                progress(underway.fraction)
        histories = underway.histories()
    return [history for history in histories if history is not None]


def _jobs(
    scenarios: Sequence[Scenario],
    kinds: Sequence[tuple[System, Method]],
    states: Floats,
    after: Sequence[History | None],
    size: int,
) -> list[_Job]:
    """The runs by their formulas and method, in parts of up to ``size`` that a launch takes."""
    alike: dict[tuple[System, Method], list[int]] = {}
    for place, kind in enumerate(kinds):
        alike.setdefault(kind, []).append(place)
    jobs = []
    for (system, method), places in alike.items():
        for begin in range(0, len(places), size):
            part = places[begin : begin + size]
            batch = [scenarios[place] for place in part]
            progress = started(system, batch, states[part])
            known = [after[place] for place in part]
            for run, history in enumerate(known):
                if history is not None:
                    progress[run] = history.progress
            records = [np.zeros(0, np.void) if history is None else history.records for history in known]
            memories = [{} if history is None else history.memory for history in known]
            jobs.append(_Job(system, method, part, batch, progress, records, memories))
    return jobs


def _batch_size(scenarios: Sequence[Scenario], workers: int) -> int:
    """How many runs a launch takes on a CPU, so that there are some for each worker; results do not depend on it."""
    turns = math.fsum(abs(scenario.drive.frequency) * scenario.run.duration for scenario in scenarios)
    most = MOST_RUNS_PER_BATCH if turns >= SHORT * len(scenarios) else SHORT_RUNS_PER_BATCH
    return min(most, math.ceil(len(scenarios) / workers))


def _checked_states(scenarios: Sequence[Scenario], given: Floats | None) -> Floats:
    if given is None:
        return np.array([start_state(scenario) for scenario in scenarios])
    try:
        states = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"initial_states must be numbers of shape ({len(scenarios)}, 7); got {given!r}") from None
    if states.shape != (len(scenarios), 7) or not np.all(np.isfinite(states)):
        raise InputError(f"initial_states must be finite numbers of shape ({len(scenarios)}, 7); got {states.shape}")
    lengths = np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
    if not np.all(lengths > 0.0):
        raise InputError("initial_states must have quaternions that are not zero")
    states[:, 3:] /= np.where(np.abs(lengths - 1.0) > UNIT, lengths, 1.0)
    return states


def _checked_histories(
    scenarios: Sequence[Scenario], after: Sequence[History | None] | None
) -> Sequence[History | None]:
    """The histories to go on from, each of its own scenario and of a run that had not ended."""
    if after is None:
        return [None] * len(scenarios)
    if len(after) != len(scenarios):
        raise InputError(f"after must hold a history (or None) for each of {len(scenarios)} runs; got {len(after)}")
    for scenario, history in zip(scenarios, after, strict=True):
        if history is not None and history.scenario != scenario:
            raise InputError(f"after must hold histories of the same scenarios; '{history.scenario.title}' differs")
    return after
