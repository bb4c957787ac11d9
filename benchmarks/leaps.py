"""Leaps over turns of the magnet: work against precision beside direct steps (`random_runs.py` has runs of all kinds).

    python benchmarks/leaps.py [--order 8]

Orders are the turns that a leap's polynomial goes through before it; another than the engine's own is compiled first.
Times are user CPU seconds of one core, the least of several, the methods in turn. Errors are against direct steps at a
tolerance of 1e-11, after 100 s and over the whole run, at samples.
"""

import argparse
import math
import resource

import numpy as np

from helimag.engine import DOP853, MULTIREVOLUTION, History, Method, advance, leaping, leaps
from helimag.scenario import Scenario, load

MIRRORED = {  # the other handedness, so that the device swims and is carried the other way along x
    "device.helix.handedness": "right",
    "drive.yaw_rate": math.radians(-1.8),
    "drive.pitch": math.radians(-12.7),
}
REPEATS = 6


def user() -> float:
    """User CPU time of this process (s)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def timed(run: Scenario, method: Method, tolerance: float) -> tuple[History, float]:
    """A run and the time it took (s)."""
    begun = user()
    (history,) = advance([run], method=method, tolerance=tolerance, threads=1)
    return history, user() - begun


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


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--order", type=int, default=leaps.ORDER, choices=range(2, leaps.ORDER + 2))
    leaps.ORDER = leaping.ORDER = parser.parse_args().order
    preset = load("paper/fig3c")
    work_and_precision("paper/fig3c", preset)
    work_and_precision("nose-first/fig3c", load("nose-first/fig3c"))
    work_and_precision("the mirror image of paper/fig3c", preset.replaced(MIRRORED))


if __name__ == "__main__":
    main()
