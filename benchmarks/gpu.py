"""Batches on a GPU beside the same on all cores of the CPU: wall time a run, and how far apart they end.

Run: python benchmarks/gpu.py [COUNTS], on a machine with a CUDA device. The runs are a minute of paper/fig3c at
frequencies near 3 Hz, so that all keep in step, with leaps and directly; kernels are compiled before the clock starts.
"""

import sys
import time

import numpy as np
import warp as wp

from helimag.engine import DOP853, MULTIREVOLUTION, History, Method, advance
from helimag.scenario import Scenario, load

COUNTS = (1, 64, 1024, 16384)
MOST_ON_CPU = 1024
METHODS = (MULTIREVOLUTION, DOP853)


def batch(count: int) -> list[Scenario]:
    """Runs of a minute, all different."""
    run = load("paper/fig3c").replaced({"run.duration": 60.0, "run.interval": 1.0})
    return [run.replaced({"drive.frequency": f}) for f in np.linspace(2.9, 3.1, count)]


def timed(runs: list[Scenario], method: Method, device: str) -> tuple[float, list[History]]:
    """Wall time (s), and what came out."""
    begun = time.perf_counter()
    found = advance(runs, method=method, device=device)
    return time.perf_counter() - begun, found


def apart(one: list[History], other: list[History]) -> float:
    """Largest distance (m) between two batches of runs, at any sample."""
    pairs = zip(one, other, strict=True)
    return max(float(np.linalg.norm(a.states[:, :3] - b.states[:, :3], axis=1).max()) for a, b in pairs)


def main() -> None:
    """Print a line a method and count."""
    counts = [int(argument) for argument in sys.argv[1:]] or COUNTS
    gpu = wp.get_device("cuda")
    print(f"{gpu.name}; {wp.get_device('cpu').name}")
    for method in METHODS:
        for device in ("cpu", "cuda"):
            for count in (1, 2):
                timed(batch(count), method, device)
        for count in counts:
            runs = batch(count)
            on_gpu, there = timed(runs, method, "cuda")
            line = f"{method.name:26s} {count:6d} runs: {1e3 * on_gpu / count:9.3f} ms a run on the GPU"
            if count <= MOST_ON_CPU:
                on_cpu, here = timed(runs, method, "cpu")
                line += f", {1e3 * on_cpu / count:9.3f} on the CPU; {apart(there, here):.1e} m apart"
            print(line, flush=True)


if __name__ == "__main__":
    main()
