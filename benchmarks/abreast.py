"""What a run costs in a batch, whose steps and turns go into the lanes of vector registers, beside the same by itself.

CPU time, user's and system's, of one thread; batches in turn in each round, so that what slows the machine slows all;
the least of the rounds. Batches of 64 are taken in parts of sixteen.
"""

import time
from collections.abc import Sequence

from helimag import load
from helimag.engine import METHODS, advance
from helimag.scenario import Scenario

ROUNDS = 5
SIZES = (1, 2, 4, 8, 16, 64)
TOLERANCES = (1e-4, 3e-7)
SWEPT = 64
SLIPPING, SETTLED = load("paper/fig3b"), load("paper/fig3c")
SWEEP = [
    SLIPPING.replaced({"drive.frequency": 1.0 + 7.0 * i / (SWEPT - 1), "run.duration": 300.0}) for i in range(SWEPT)
]


def spent(runs: Sequence[Scenario], method: str, tolerance: float) -> float:
    """CPU time of a batch (s)."""
    begun = time.process_time()
    advance(runs, method=METHODS[method], tolerance=tolerance, threads=1)
    return time.process_time() - begun


def least(batches: Sequence[Sequence[Sequence[Scenario]]], method: str, tolerance: float) -> list[float]:
    """Time of each of some ways to put runs into batches (s)."""
    times = [[sum(spent(runs, method, tolerance) for runs in way) for way in batches] for _ in range(ROUNDS + 1)]
    return [min(way) for way in zip(*times[1:], strict=True)]


def main() -> int:
    """Print milliseconds a run, by method, tolerance and size of the batch."""
    print(f"ms a run in batches of {', '.join(map(str, SIZES))}: the first over the last")
    for name, run in (("paper/fig3b", SLIPPING), ("paper/fig3c", SETTLED)):
        for method in METHODS:
            for tolerance in TOLERANCES:
                times = least([[[run] * size] for size in SIZES], method, tolerance)
                each = [1e3 * time / size for time, size in zip(times, SIZES, strict=True)]
                told = " ".join(f"{time:6.2f}" for time in each)
                print(
                    f"  {name}, {run.run.duration:4g} s, {method:15s} {tolerance:.0e} {told}: {each[0] / each[-1]:.1f}"
                )
    print(f"{SWEPT} runs of paper/fig3b over 300 s at 1 to 8 Hz: ms a run each by itself, and all at once")
    for method in METHODS:
        for tolerance in TOLERANCES:
            alone, together = (
                1e3 * time / SWEPT for time in least([[[run] for run in SWEEP], [SWEEP]], method, tolerance)
            )
            print(f"  {method:15s} {tolerance:.0e} {alone:6.2f} {together:6.2f}: {alone / together:.1f}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
