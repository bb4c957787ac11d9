"""Long searches tell how far they are, to the end, and stop at once where the caller wants them to."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import helimag as hm
from helimag import orbits
from helimag.design import design
from helimag.orbits.strobe import Problem, Watch

PATHS = "drive.pitch", "drive.frequency"
SOON = 5.0  # s; a second on a free machine, and tests run beside each other
Report = Callable[[float], None]


class StopSearch(Exception):
    """What a caller raises who wants no more."""


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    return hm.find_orbit(hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"}))


def mapped(scenario: hm.Scenario, nodes: int, progress: Report | None = None) -> orbits.StabilityMap:
    pitches, frequencies = np.radians(np.linspace(4.0, 20.0, nodes)), np.linspace(2.0, 3.5, nodes)
    return orbits.stability_map(scenario, (PATHS[0], pitches), (PATHS[1], frequencies), progress=progress)


def box(orbit: hm.Orbit, reach: float) -> dict[str, np.ndarray]:
    return {"low": orbit.position - reach, "high": orbit.position + reach}


# each reports many times when it is let be
LONG_SEARCHES: dict[str, Callable[[hm.Orbit, Report], object]] = {
    "find_orbit": lambda o, p: orbits.find_orbit(o.scenario.replaced({"drive.distance": "1 m"}), progress=p),
    "list_orbits": lambda o, p: orbits.list_orbits(o.scenario, shape=(21, 21, 21), progress=p),
    "stability_map": lambda o, p: mapped(o.scenario, 30, p),
    "boundary_of": lambda o, p: orbits.boundary_of(mapped(o.scenario, 4), progress=p),
    "survey": lambda o, p: orbits.survey(o.scenario, "drive.pitch", 0.05, 0.4, progress=p),
    "slow_flow": lambda o, p: orbits.slow_flow(o, progress=p),
    "basin": lambda o, p: orbits.basin(o, **box(o, 0.05), shape=(9, 9, 9), progress=p),
    "basin_by_flow": lambda o, p: orbits.basin_by_flow(o, **box(o, 0.05), progress=p),
    "design": lambda o, p: design(o.scenario, speed=4.5e-4, progress=p),
}


@pytest.mark.parametrize("name", LONG_SEARCHES)
def test_a_caller_stops_a_search(name: str, orbit: hm.Orbit) -> None:
    """From a thread of its own, as a page or a notebook would run it: it asks often, and ends where it is told to."""
    before = set(threading.enumerate())
    told: list[float] = []
    ended: list[float] = []

    def progress(_: float) -> None:
        told.append(time.perf_counter())
        if len(told) == 3:
            raise StopSearch

    def search() -> None:
        try:
            LONG_SEARCHES[name](orbit, progress)
        except StopSearch:
            ended.append(time.perf_counter())

    thread = threading.Thread(target=search)
    thread.start()
    thread.join(60.0)
    assert ended, "the search went on"
    assert max(np.diff([*told, *ended])) < SOON
    assert not [left for left in set(threading.enumerate()) - before if not left.daemon]


SCRIPT = """
import threading, time
import helimag as hm
from helimag.orbits import list_orbits
scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
hm.find_orbit(scenario)  # with kernels compiled
print("under way", flush=True)
try:
    while True:
        list_orbits(scenario, shape=(9, 9, 9))
except KeyboardInterrupt:
    print([thread.name for thread in threading.enumerate() if not thread.daemon], flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_stops_a_search() -> None:
    with subprocess.Popen([sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "under way\n"
        time.sleep(1.0)
        asked = time.perf_counter()
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "['MainThread']\n"
        assert time.perf_counter() - asked < SOON
        assert process.wait(30.0) == 0


def short_searches(orbit: hm.Orbit) -> dict[str, Callable[[Report], object]]:
    scenario, low, high = orbit.scenario, orbit.position - 0.02, orbit.position + 0.02
    known = mapped(scenario, 4)
    flow = orbits.slow_flow(orbit, low=low, high=high, shape=(5, 5, 5))
    box = {"low": low, "high": high, "shape": (2, 2, 2)}
    return {
        "find_orbit": lambda p: orbits.find_orbit(scenario, progress=p),
        "near": lambda p: orbits.find_orbit(scenario, near=orbit, progress=p),
        "list_orbits": lambda p: orbits.list_orbits(scenario, shape=(2, 2, 2), progress=p),
        "find_orbits": lambda p: orbits.find_orbits([scenario], orbit.state[None], progress=p),
        "follow": lambda p: orbits.follow(orbit, "drive.pitch", 0.2, 0.25, progress=p),
        "stable_interval": lambda p: orbits.stable_interval(orbit, "drive.pitch", 0.2, 0.25, progress=p),
        "stability_map": lambda p: mapped(scenario, 4, p),
        "boundary_of": lambda p: orbits.boundary_of(known, progress=p),
        "all_branches": lambda p: orbits.all_branches(orbit, "drive.pitch", 0.2, 0.25, progress=p),
        "slow_flow": lambda p: orbits.slow_flow(orbit, low=low, high=high, shape=(5, 5, 5), progress=p),
        "fixed_points": lambda p: orbits.fixed_points(flow, progress=p),
        "averaging_errors": lambda p: orbits.averaging_errors(flow, orbit, progress=p),
        "basin": lambda p: orbits.basin(orbit, **box, duration=60.0, progress=p),
        "basin by a flow": lambda p: orbits.basin(orbit, **box, flow=flow, progress=p),
        "explain": lambda p: orbits.explain(hm.simulate(scenario, duration=60.0), progress=p),
    }


def test_progress_goes_up_to_one(orbit: hm.Orbit) -> None:
    for name, search in short_searches(orbit).items():
        told: list[float] = []
        search(told.append)
        assert told == sorted(told), name
        assert told[0] >= 0.0, name
        assert told[-1] == 1.0, name


def test_a_watch_tells_shares_of_shares_and_never_less_than_before() -> None:
    told: list[float] = []
    watch = Watch(told.append)
    half = watch.part(0.5, 1.0)
    half.turn(1, 4)(0.5)
    half(0.0)
    half(2.0)
    assert told == [0.6875, 0.6875, 1.0]
    watch.unmeasured()(0.3)
    assert told[-1] == 1.0
    Watch()(0.5)


def test_a_pulse_comes_only_where_nothing_was_told_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[float] = []
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    watch = Watch(told.append)
    watch(0.25)
    watch.pulse()
    assert told == [0.25]
    clock[0] += 0.11
    watch.pulse()
    watch.pulse()
    assert told == [0.25, 0.25]


def test_magnets_of_different_fields_share_a_batch(orbit: hm.Orbit) -> None:
    """Each state goes the way that it goes alone, to the last bit, whatever the order."""
    dipole, cylinder = (orbit.scenario.replaced({"magnet.field": field}) for field in ("dipole", "cylinder"))
    states = np.repeat(orbit.state[None], 6, axis=0) + 1e-3 * np.arange(6.0)[:, None] * np.eye(7)[0]
    which = np.array([1, 0, 0, 1, 1, 0])
    together = Problem([dipole, cylinder]).map(which, states)
    for number, scenario in enumerate((dipole, cylinder)):
        mine = which == number
        alone = Problem([scenario]).map(np.zeros(3, dtype=np.int64), states[mine])
        for a, b in zip(alone, together, strict=True):
            assert np.array_equal(a, b[mine])
    assert not np.array_equal(together[0][0], Problem([dipole]).map(which[1:2], states[:1])[0][0])
    nothing = Problem([dipole]).map(which[:0], states[:0])
    assert [part.shape for part in nothing] == [(0, 7), (0,)]


def test_launches_are_short_whatever_the_steps(orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut into launches of a few steps or not, the map is the same to the last bit."""
    from helimag.orbits.strobe import problem

    states = np.repeat(orbit.state[None], 40, axis=0) + 1e-4 * np.arange(40.0)[:, None] * np.eye(7)[1]
    which = np.zeros(40, dtype=np.int64)
    whole = Problem([orbit.scenario]).map(which, states)
    counts: list[int] = []
    launch = Problem._launch
    monkeypatch.setattr(Problem, "_launch", lambda *args: (counts.append(len(args[4][args[-1]])), launch(*args)))
    monkeypatch.setattr(problem, "LAUNCH_STEPS", 100)
    cut = Problem([orbit.scenario]).map(which, states)
    steps = int(Problem([orbit.scenario]).steps(which, states).max())
    assert sum(counts) == 40
    assert max(counts) <= math.ceil(100 / steps) + 1 < 40
    for a, b in zip(whole, cut, strict=True):
        assert np.array_equal(a, b)


def test_threads_give_the_same_and_none_is_left(orbit: hm.Orbit, monkeypatch: pytest.MonkeyPatch) -> None:
    states = np.repeat(orbit.state[None], 200, axis=0) + 1e-5 * np.arange(200.0)[:, None] * np.eye(7)[2]
    which = np.zeros(200, dtype=np.int64)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    alone = Problem([orbit.scenario]).map(which, states)
    monkeypatch.setattr(os, "cpu_count", lambda: 3)
    together = Problem([orbit.scenario]).map(which, states)
    for a, b in zip(alone, together, strict=True):
        assert np.array_equal(a, b)

    names: set[str] = set()

    def stop(_: float) -> None:
        names.update(thread.name for thread in threading.enumerate())
        raise StopSearch

    many, numbers = np.tile(states, (50, 1)), np.zeros(10_000, dtype=np.int64)
    with pytest.raises(StopSearch):
        Problem([orbit.scenario], watch=Watch(stop)).map(numbers, many)
    assert any(name.startswith("helimag-orbits") for name in names)
    assert not any(thread.name.startswith("helimag-orbits") for thread in threading.enumerate())
