"""What direct steps take where samples are closer together than they are: dense output beside steps to each sample.

    python benchmarks/short_intervals.py

Runs of 20 s. Times are those of the kernel, CPU of one core, the least of several, both in turn. Errors are
against steps to each sample at a tolerance of 1e-11, at all samples of 5 s: of the head's place, and of the quaternion.
"""

import math
import time
from dataclasses import replace

import numpy as np

from helimag.engine import DOP853, History, Method, advance, start_state, system_of
from helimag.engine.batch import Batch, Stepping, started
from helimag.scenario import Scenario, load

LANDING = replace(DOP853, name="DOP853, to each sample", course=None)
PRESETS = ("paper/fig3c", "nose-first/fig3b", "paper/table1-row3")
INTERVALS = (1.0, 0.1, 0.02, 0.015, 0.01, 0.007, 0.005, 0.003, 0.002, 0.001)  # s
REPEATS = 12
BUDGET = 1_000_000  # steps of a launch


def launched(run: Scenario, method: Method) -> tuple[float, History]:
    """Time in the kernel of a run (s), and the run."""
    system = system_of(run)
    batch = Batch(system, [run], started(system, [run], np.array([start_state(run)])), Stepping(method))
    begun = time.thread_time()
    while batch.running:
        batch.launch(BUDGET)
    return time.thread_time() - begun, batch.histories()[0]


def compared(run: Scenario) -> str:
    """Trials and time by dense output, and by steps to each sample."""
    best = {DOP853: math.inf, LANDING: math.inf}
    trials = {}
    for _ in range(REPEATS):
        for method in best:
            took, history = launched(run, method)
            best[method] = min(best[method], took)
            trials[method] = history.steps + history.rejected
    told = "  ".join(f"{trials[method]:6d} {1e3 * best[method]:6.2f} ms" for method in (LANDING, DOP853))
    return f"{told}  {best[DOP853] / best[LANDING]:.2f}"


def errors(run: Scenario) -> tuple[float, float]:
    """Largest error of a place (m), and of a quaternion's component, at any sample."""
    (exact,), (dense,) = (advance([run], method=m, tolerance=t) for m, t in ((LANDING, 1e-11), (DOP853, 3e-7)))
    away = np.abs(dense.states - exact.states)
    return float(away[:, :3].max()), float(away[:, 3:].max())


def main() -> None:
    """Print a table a preset."""
    for name in PRESETS:
        base = load(name).replaced({"run.duration": 20.0})
        print(f"{name}: interval; trial steps and time, to each sample; the same by dense output; ratio of times")
        for interval in INTERVALS:
            print(f"  {1e3 * interval:6.0f} ms  {compared(base.replaced({'run.interval': interval}))}")
        place, turn = errors(base.replaced({"run.duration": 5.0, "run.interval": 0.002}))
        print(f"  samples each 2 ms are within {place:.1e} m, and {turn:.1e} of a quaternion's component")


if __name__ == "__main__":
    main()
