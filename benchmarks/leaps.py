"""Leaps over turns of the magnet: work against precision beside direct steps (`random_runs.py` has runs of all kinds).

    python benchmarks/leaps.py [--order 8]

Orders are the turns that a leap's polynomial goes through before it; another than the engine's own is compiled first.
Times are CPU seconds, user's and system's, of one core, the least of several, the methods in turn. Errors are against
direct steps at a tolerance of 1e-11, after 100 s and over the whole run, at samples. Last comes from how many turns on
leaps pay: the time of their kernel over that of direct steps, where all runs leap, however short.
"""

import argparse
import math
import time

import numpy as np

from helimag.engine import DOP853, MULTIREVOLUTION, History, Method, advance, leaping, leaps, start_state, system_of
from helimag.engine.batch import FEWEST_TURNS, Batch, Stepping, started
from helimag.scenario import Scenario, load

MIRRORED = {  # the other handedness, so that the device swims and is carried the other way along x
    "device.helix.handedness": "right",
    "drive.yaw_rate": math.radians(-1.8),
    "drive.pitch": math.radians(-12.7),
}
REPEATS = 6
SHORT = (
    "paper/fig3c",
    "paper/fig3a",
    "nose-first/fig3c",
    "nose-first/fig3b",
    "paper/table1-row3",
    "nose-first/table1-row6",
)
PITCHES = np.linspace(0.8, 1.2, 10)  # of the preset's
BUDGET = 1_000_000  # steps of a launch


def timed(run: Scenario, method: Method, tolerance: float) -> tuple[History, float]:
    """A run and the time it took (s)."""
    begun = time.process_time()
    (history,) = advance([run], method=method, tolerance=tolerance, threads=1)
    return history, time.process_time() - begun


def distances(one: History, other: History) -> np.ndarray:
    """Distances (m) between two runs at the samples that both came to."""
    count = min(one.time.size, other.time.size)
    return np.asarray(np.linalg.norm(one.states[:count, :3] - other.states[:count, :3], axis=1))


def work_and_precision(name: str, run: Scenario) -> None:
    """Print a table of tolerances for one run."""
    exact, _ = timed(run, DOP853, 1e-11)
    print(f"{name}, {run.run.duration:g} s: method, tolerance, time, turns followed, error at 100 s, largest error")
    tolerances = (3e-6, 3e-7, 3e-8)
    best = {(method.name, t): math.inf for method in (DOP853, MULTIREVOLUTION) for t in tolerances}
    kept = {}
    for _ in range(REPEATS):
        for method in (DOP853, MULTIREVOLUTION):
            for tolerance in tolerances:
                history, seconds = timed(run, method, tolerance)
                key = (method.name, tolerance)
                best[key], kept[key] = min(best[key], seconds), history
    for (method_name, tolerance), seconds in best.items():
        history = kept[method_name, tolerance]
        away, followed = distances(history, exact), int(history.progress["leap"]["followed"])
        early = away[history.time[: away.size] <= 100.0].max()
        errors = f"{early:.1e} m {away.max():.1e} m"
        print(f"  {method_name:24s} {tolerance:.0e} {1e3 * seconds:7.1f} ms {followed:5d} {errors}")


def launched(runs: list[Scenario], method: Method) -> float:
    """Time in the kernel of a few runs by one method, however many turns they have (s)."""
    states, system = np.array([start_state(run) for run in runs]), system_of(runs[0])
    batch = Batch(system, runs, started(system, runs, states), Stepping(method))
    begun = time.thread_time()
    while batch.running:
        batch.launch(BUDGET)
    return time.thread_time() - begun


def short_runs(turns: int) -> list[float]:
    """Time of leaps over that of direct steps, by preset, for runs of so many turns."""
    found = []
    for base in map(load, SHORT):
        duration = turns / base.drive.frequency
        times = {"run.duration": duration, "run.interval": duration / 20.0}
        runs = [base.replaced(times | {"drive.pitch": share * base.drive.pitch}) for share in PITCHES]
        pairs = [(launched(runs, DOP853), launched(runs, MULTIREVOLUTION)) for _ in range(REPEATS)]
        direct, leaping_time = (min(times) for times in zip(*pairs, strict=True))
        found.append(leaping_time / direct)
    return found


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--order", type=int, default=leaps.ORDER, choices=range(2, leaps.ORDER + 2))
    leaps.ORDER = leaping.ORDER = parser.parse_args().order
    preset = load("paper/fig3c")
    work_and_precision("paper/fig3c", preset)
    work_and_precision("nose-first/fig3c", load("nose-first/fig3c"))
    work_and_precision("the mirror image of paper/fig3c", preset.replaced(MIRRORED))
    print(f"runs of few turns, time of leaps over that of direct steps (runs leap from {FEWEST_TURNS:g} turns on):")
    print(f"  turns {', '.join(SHORT)}: geometric mean")
    for turns in (5, 10, 20, 30, 36, 40, 50, 80):
        found = short_runs(turns)
        print(
            f"  {turns:5d} {' '.join(f'{ratio:5.2f}' for ratio in found)}: {math.prod(found) ** (1 / len(found)):.2f}"
        )


if __name__ == "__main__":
    main()
