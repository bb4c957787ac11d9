"""What `sweep --dry-run` says that a sweep takes, beside what it took, for five different plans.

Both by the CPU time of one thread, so that other work on the machine makes little difference; what is left of it is in
the spread of the ratio over a few times, whose median is held to a quarter. Disk in whole blocks.
"""

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from helimag import sweep
from helimag.sweeps import Axis, Plan, Sampling, estimate, trial

WITHIN = 0.25
REPEATS = 3


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


@dataclass(frozen=True)
class Held:
    """An estimate beside the sweep: seconds and bytes told, and those taken."""

    told: tuple[float, float]
    took: tuple[float, float]

    @property
    def ratios(self) -> tuple[float, float]:
        """Told over taken."""
        return self.told[0] / self.took[0], self.told[1] / self.took[1]


def held(plan: Plan) -> Held:
    """Estimate a sweep, and make it."""
    told = estimate(plan, threads=1)
    with tempfile.TemporaryDirectory() as folder:
        begun = time.process_time()
        sweep(plan, out=Path(folder) / "s.zarr", threads=1)
        took = time.process_time() - begun
        used = sum(path.lstat().st_blocks * 512 for path in (Path(folder) / "s.zarr").rglob("*"))
    return Held((told.seconds, told.bytes), (took, used))


def main() -> int:
    """Print each plan's ratios; whether all are within a quarter."""
    trial.time = SimpleNamespace(perf_counter=time.process_time)
    found: dict[str, list[Held]] = {name: [] for name in PLANS}
    for _ in range(REPEATS):
        for name, plan in PLANS.items():
            found[name].append(held(plan))
    off = 0.0
    for name, times in found.items():
        times.sort(key=lambda each: each.ratios[0])
        middle = times[len(times) // 2]
        (told, size), (took, used), (ratio, room) = middle.told, middle.took, middle.ratios
        off = max(off, abs(ratio - 1.0), abs(room - 1.0))
        print(
            f"{name:20s} told {told:5.2f} s, took {took:5.2f} s, ratio {ratio:.2f} ({times[0].ratios[0]:.2f} to "
            f"{times[-1].ratios[0]:.2f}); told {size / 1e6:.1f} MB, used {used / 1e6:.1f} MB, ratio {room:.2f}"
        )
    return 0 if off <= WITHIN else 1


if __name__ == "__main__":
    raise SystemExit(main())
