"""A real dask scheduler with worker processes on loopback: same result as threads, also when a worker is killed."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from distributed import Future

import helimag
from helimag import FileError
from helimag.sweeps import engines, parse_plan
from helimag.sweeps.run import sweep

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))
import sweep_kills

PLAN = sweep_kills.PLAN.format(count=60, duration="400 s")


@pytest.fixture
def cluster(tmp_path):
    """Scheduler address and two worker processes; only these are ended."""
    started = []

    def start(*command):
        log = (tmp_path / f"log{len(started)}").open("wb")
        with log:
            started.append(subprocess.Popen([sys.executable, "-m", *command], stdout=log, stderr=log))
        return started[-1]

    where = tmp_path / "scheduler.json"
    options = ("--host", "127.0.0.1", "--no-dashboard")
    start("distributed.cli.dask_scheduler", *options, "--port", "0", "--scheduler-file", str(where))
    until = time.monotonic() + 60.0
    while not where.exists() or not where.read_text():
        assert time.monotonic() < until, (tmp_path / "log0").read_text()
        time.sleep(0.1)
    address = json.loads(where.read_text())["address"]
    assert address.startswith("tcp://127.0.0.1:")
    worker = ("distributed.cli.dask_worker", address, *options, "--nthreads", "1", "--no-nanny")
    workers = [start(*worker) for _ in range(2)]
    yield address, workers
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    store = tmp_path_factory.mktemp("alone") / "s.zarr"
    helimag.sweep(parse_plan(PLAN), out=store)
    return sweep_kills.files(store)


def test_two_workers_give_what_threads_give_also_when_one_is_killed(cluster, alone, tmp_path):
    address, workers = cluster
    helimag.sweep(parse_plan(PLAN), out=tmp_path / "whole.zarr", scheduler=address)
    assert sweep_kills.files(tmp_path / "whole.zarr") == alone
    killed = []

    def kill(progress):
        if progress.done >= 16 and not killed:
            workers[0].send_signal(signal.SIGKILL)
            killed.append(progress.done)

    sweep(parse_plan(PLAN), out=tmp_path / "killed.zarr", scheduler=address, progress=kill)
    assert 16 <= killed[0] < 120
    assert workers[0].wait() == -signal.SIGKILL
    assert sweep_kills.files(tmp_path / "killed.zarr") == alone


def test_a_result_that_is_lost_before_it_is_fetched_is_waited_for_again(cluster, alone, tmp_path, monkeypatch):
    """As where a worker dies just then: the scheduler has others compute it once more."""
    address, _ = cluster
    known, told = Future.status.fget, ["lost", "pending"]

    def status(future):
        asked_by = sys._getframe(1).f_globals["__name__"]
        return told.pop() if asked_by == engines.__name__ and told else known(future)

    monkeypatch.setattr(Future, "status", property(status))
    helimag.sweep(parse_plan(PLAN), out=tmp_path / "s.zarr", scheduler=address)
    assert told == []
    assert sweep_kills.files(tmp_path / "s.zarr") == alone


def test_no_scheduler_is_one_clear_line(tmp_path, monkeypatch):
    monkeypatch.setattr("helimag.sweeps.engines.CONNECT_SECONDS", 1)
    with pytest.raises(FileError, match=r"no dask scheduler answers at 'tcp://127\.0\.0\.1:9'"):
        helimag.sweep(parse_plan(PLAN), out=tmp_path / "s.zarr", scheduler="tcp://127.0.0.1:9")
    assert list(tmp_path.iterdir()) == []  # no store that nothing was computed for
