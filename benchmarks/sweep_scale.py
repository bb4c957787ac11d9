"""What many runs cost beside the runs themselves: time a run, files, reopening, memory.

    python benchmarks/sweep_scale.py [RUNS ...]

Runs of one second are nearly all overhead. Told apart are what a sweep costs once (the libraries of its store, an empty
one with checks of some points) and, of the user CPU time that each run adds, what the kernel's launches take: the rest
is Python's. Then trajectories are kept: how far the peak of memory rises above that of a small sweep, beside the data
that the store holds.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

CHILD = """
import resource, sys, time
import warp
from pathlib import Path
import helimag
from helimag.sweeps import Axis, Plan
count, out, kept = int(sys.argv[1]), Path(sys.argv[2]), sys.argv[3] == "kept"
plan = Plan(
    base="paper/fig3c", duration="60 s" if kept else "1 s", samples=20, trajectory="0.1 s" if kept else None,
    axis=(
        Axis(field="drive.frequency", start="2 Hz", stop="3 Hz", count=count // 50),
        Axis(field="drive.pitch", start="2 deg", stop="20 deg", count=50),
    ),
)
from helimag.engine import advance
from helimag.sweeps import resolve
from helimag.sweeps.store import Store
resolved = resolve(plan)
scenarios = [resolved.scenario(values) for values in resolved.points(0)]
advance(scenarios[:1], threads=1)  # loads the kernel
launch, launched = warp.launch, []
def timed(*given, **named):
    begun = time.thread_time()
    launch(*given, **named)
    launched.append(time.thread_time() - begun)
warp.launch = timed
user = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_utime
once = -user()
with Store.opened(out, resolved):
    pass
once += user()
spent = -user()
helimag.sweep(plan, out=out, threads=1)
spent, kernel = spent + user(), sum(launched)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
files = [path for path in out.rglob("*") if path.is_file()]
begun = time.process_time()
helimag.sweep(plan, out=out, threads=1)
reopened = time.process_time() - begun
data = helimag.load_sweep(out).nbytes / 2**20
print(once, 1e3 * (spent - kernel) / count, 1e3 * kernel / count, len(files), reopened, peak, data)
"""


def measured(count: int, kept: str = "none") -> list[float]:
    """Time once (s), Python's and the kernel's a run (ms), files, reopening (s), peak and data (MiB): one process."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", CHILD, str(count), str(Path(folder) / "s.zarr"), kept]
        found = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return [float(word) for word in found]


def main() -> None:
    for count in [int(word) for word in sys.argv[1:]] or [1000, 10_000, 100_000]:
        once, python, kernel, files, reopened, peak, data = measured(count)
        print(
            f"{count:7d} runs of 1 s: {once:.2f} s once, and each {python:.2f} ms of Python and {kernel:.2f} of the "
            f"kernel; {files:.0f} files, reopened in {reopened:.2f} s, peak {peak:.0f} MiB for {data:.0f} MiB of data"
        )
    *_, small, _ = measured(100, "kept")
    for count in (1000, 4000):
        *_, files, _, peak, data = measured(count, "kept")
        print(
            f"{count:7d} runs of 60 s with trajectories: {data:.0f} MiB of data in {files:.0f} files, "
            f"peak {peak - small:.0f} MiB above that of 100 runs"
        )


if __name__ == "__main__":
    main()
