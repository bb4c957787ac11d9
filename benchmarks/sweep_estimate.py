"""What `sweep --dry-run` says that a sweep takes, beside what it took, for five different plans.

Both by the CPU time of one thread, so that other work on the machine makes no difference; disk in whole blocks.
"""

import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

from helimag import sweep
from helimag.sweeps import Axis, Plan, Sampling, estimate, trial

WITHIN = 0.25


def axis(name: str, start: str, stop: str, count: int | None = None) -> Axis:
    return Axis(field=f"drive.{name}", start=start, stop=stop, count=count)


PLANS = {
    "a grid of a minute": Plan(
        base="nose-first/fig3c",
        duration="60 s",
        samples=20,
        axis=(axis("frequency", "2 Hz", "3 Hz", 20), axis("pitch", "2 deg", "20 deg", 30)),
    ),
    "half hours": Plan(
        base="paper/fig3c",
        duration="1800 s",
        axis=(axis("frequency", "2 Hz", "4 Hz", 10), axis("distance", "120 mm", "180 mm", 12)),
    ),
    "runs of a second": Plan(
        base="paper/fig3c",
        duration="1 s",
        samples=20,
        axis=(axis("frequency", "2 Hz", "3 Hz", 60), axis("pitch", "2 deg", "20 deg", 60)),
    ),
    "trajectories": Plan(
        base="nose-first/fig3a",
        duration="300 s",
        trajectory="0.5 s",
        axis=(axis("frequency", "1 Hz", "5 Hz", 15), axis("pitch", "2 deg", "20 deg", 16)),
    ),
    "samples, many lost": Plan(
        base="nose-first/fig3b",
        duration="900 s",
        axis=(axis("frequency", "1 Hz", "5 Hz"), axis("distance", "100 mm", "200 mm")),
        sample=Sampling(method="sobol", count=150),
    ),
}


def main() -> int:
    trial.time = SimpleNamespace(perf_counter=time.process_time)
    off = 0.0
    for name, plan in PLANS.items():
        told = estimate(plan, threads=1)
        with tempfile.TemporaryDirectory() as folder:
            begun = time.process_time()
            sweep(plan, out=Path(folder) / "s.zarr", threads=1)
            took = time.process_time() - begun
            used = sum(path.lstat().st_blocks * 512 for path in (Path(folder) / "s.zarr").rglob("*"))
        ratios = told.seconds / took, told.bytes / used
        off = max(off, *(abs(ratio - 1.0) for ratio in ratios))
        print(
            f"{name:20s} {told.runs:5d} runs: told {told.seconds:6.2f} s, took {took:6.2f} s, ratio {ratios[0]:.2f}; "
            f"told {told.bytes / 1e6:.1f} MB, used {used / 1e6:.1f} MB, ratio {ratios[1]:.2f}"
        )
    return 0 if off <= WITHIN else 1


if __name__ == "__main__":
    raise SystemExit(main())
