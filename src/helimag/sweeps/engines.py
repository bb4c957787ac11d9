"""Where chunks are computed: threads on this machine, or a dask.distributed cluster. Same chunks, same numbers."""

import gc
import math
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any, Protocol

from helimag.errors import FileError, MissingExtra, RunError
from helimag.scenario import Scenario
from helimag.sweeps.compute import Kept, Rows, compute

Job = tuple[int, Callable[[], Sequence[Scenario | None]]]  # chunk, and what makes its scenarios
CONNECT_SECONDS = 10
AHEAD = 2  # jobs sent for each worker thread: one that runs, one that waits
OBJECTS = 50_000  # made between searches for cycles: what runs are made of is gone sooner, and would be gone through
UNDER_WAY = ("lost", "pending")  # of a future that had finished: it will again


class Stopped(Exception):
    """Ends the jobs that still run when the sweep is given up."""


class Engine(Protocol):
    """Computes jobs and yields each as it is done, in any order; holds only a few at a time."""

    def results(
        self,
        jobs: Sequence[Job],
        kept: Kept,
        report: Callable[[float], None],
    ) -> Iterator[tuple[int, Rows]]: ...


class Threads:
    """As many chunks at once as there are cores; a single chunk uses them all."""

    def __init__(self, threads: int | None = None) -> None:
        self.threads = threads or os.cpu_count() or 1

    def results(self, jobs: Sequence[Job], kept: Kept, report: Callable[[float], None]) -> Iterator[tuple[int, Rows]]:
        """Compute on this machine; ``report`` gets the number of chunks' worth of work under way that is done."""
        stop = threading.Event()
        under_way: dict[int, float] = {}
        at_once = min(self.threads, len(jobs))

        def work(job: Job) -> Rows:
            chunk, make = job

            def seen(done: float) -> None:
                under_way[chunk] = done
                if stop.is_set():
                    raise Stopped

            seen(0.0)
            return compute(make(), kept, threads=math.ceil(self.threads / at_once), progress=seen)

        pool = ThreadPoolExecutor(max(1, at_once))
        waiting = iter(jobs)
        pending: dict[Future[Rows], int] = {}
        thresholds = gc.get_threshold()
        gc.set_threshold(max(OBJECTS, thresholds[0]), *thresholds[1:])

        def send(count: int) -> None:
            for _, job in zip(range(count), waiting, strict=False):
                pending[pool.submit(work, job)] = job[0]

        try:
            send(at_once)
            while pending:
                finished, _ = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in finished:
                    chunk = pending.pop(future)
                    under_way.pop(chunk, None)
                    yield chunk, future.result()
                send(len(finished))
                report(math.fsum(list(under_way.values())))
        finally:
            gc.set_threshold(*thresholds)
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


class Cluster:
    """A dask.distributed cluster that is running already, by its scheduler's address."""

    def __init__(self, client: Any) -> None:
        self.client = client

    def results(self, jobs: Sequence[Job], kept: Kept, report: Callable[[float], None]) -> Iterator[tuple[int, Rows]]:
        """Compute on the cluster, a chunk a worker thread; a chunk whose worker dies goes to another one."""
        from distributed import as_completed

        waiting = iter(jobs)
        sent: dict[Any, int] = {}

        def send(count: int) -> list[Any]:
            new = []
            for _, (chunk, make) in zip(range(count), waiting, strict=False):
                # impure: what an abandoned sweep of the same plan left behind must not answer for this one
                future = self.client.submit(compute, make(), kept, threads=1, pure=False)
                sent[future] = chunk
                new.append(future)
            return new

        ahead = AHEAD * max(1, sum(self.client.nthreads().values()))
        done = as_completed(send(ahead), loop=self.client.loop, raise_errors=False)
        try:
            for future in done:
                if future.status in UNDER_WAY:  # its worker died with the result, which is computed again elsewhere
                    done.add(future)
                    continue
                if future.status != "finished":
                    why = future.exception() if future.status == "error" else future.status
                    raise RunError(
                        f"the cluster gave a chunk up: {type(why).__name__} {why}; see the workers' logs, then run the "
                        "same command again"
                    )
                rows = future.result()
                yield sent.pop(future), rows
                future.release()
                done.update(send(1))
                report(0.0)
        finally:
            self.client.cancel(list(sent))


@contextmanager
def engine(scheduler: str | None, threads: int | None = None) -> Iterator[Engine]:
    """The cluster at an address, or threads.

    Raises
    ------
    FileError
        Where no scheduler answers at the address.
    MissingExtra
        Where dask.distributed is not installed.
    """
    if scheduler is None:
        yield Threads(threads)
        return
    try:
        from distributed import Client
    except ImportError:
        raise MissingExtra.of("a cluster", "distributed", "cluster") from None
    try:
        client = Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise FileError(f"no dask scheduler answers at '{scheduler}' (such as tcp://127.0.0.1:8786): {error}") from None
    try:
        yield Cluster(client)
    finally:
        client.close()
