"""Peak memory of a sweep of 100 and of 10,000 short runs, each in its own process: it must not grow with the number.

Usage: python benchmarks/sweep_memory.py [runs ...]
"""

import subprocess
import sys
import tempfile

GROWTH = 1.15  # of the peak, allowed from the first to the last
CHILD = """
import resource, sys, time
import helimag
from helimag.sweeps import Axis, Plan
count = int(sys.argv[1])
plan = Plan(base="nose-first/fig3c", duration="2 s", samples=20, axis=(
    Axis(field="drive.frequency", start="2 Hz", stop="3 Hz", count=10),
    Axis(field="drive.pitch", start="2 deg", stop="20 deg", count=count // 10),
))
begun = time.perf_counter()
helimag.sweep(plan, out=sys.argv[2])
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
print(peak, time.perf_counter() - begun)
"""


def peak(count: int) -> tuple[float, float]:
    """Peak resident memory (MiB) and time (s)."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", CHILD, str(count), f"{folder}/s.zarr"]
        found = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return float(found[0]), float(found[1])


def main() -> None:
    peaks = []
    for count in [int(word) for word in sys.argv[1:]] or [100, 10_000]:
        memory, seconds = peak(count)
        peaks.append(memory)
        print(f"{count:6d} runs of 2 s: peak {memory:6.1f} MiB, {seconds:6.1f} s")
    if peaks[-1] > GROWTH * peaks[0]:
        raise SystemExit("memory grows with the number of runs")


if __name__ == "__main__":
    main()
