"""Time of half-hour runs in a sweep, extrapolated to the 2,000 of Fig. 4 at both resolutions.

Usage: python benchmarks/sweep_fig4.py [runs]
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import helimag
from helimag.sweeps import Axis, Plan

FIG4 = 2000
LIMIT = 360.0  # s on two cores


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 160
    plan = Plan(
        base="nose-first/fig3c",
        duration="1800 s",
        axis=(
            Axis(field="drive.frequency", values=("2 Hz", "2.5 Hz", "3 Hz", "3.3 Hz")),
            Axis(field="drive.pitch", start="0 deg", stop="24 deg", count=count // 4),
        ),
    )
    before, begun = os.times(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        helimag.sweep(plan, out=Path(folder) / "s.zarr", threads=2)
    wall, after = time.perf_counter() - begun, os.times()
    cpu = after.user + after.system - before.user - before.system
    runs = 4 * (count // 4)
    print(
        f"{runs} runs of 1800 s on two threads: {wall:.1f} s, {cpu:.1f} s of processor; for {FIG4} runs "
        f"{wall / runs * FIG4:.0f} s here now, {cpu / runs * FIG4 / 2:.0f} s on two cores of their own"
    )
    if cpu / runs * FIG4 / 2 > LIMIT:
        raise SystemExit(f"more than {LIMIT:.0f} s")


if __name__ == "__main__":
    main()
