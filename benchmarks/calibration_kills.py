"""Kill a calibration with SIGKILL at random moments, resume it each time, and compare with one that was left alone.

After each kill only whole files may lie under the names that a user knows: no fit yet, and what has been computed so
far, which the next one reads. Prints whether the fit is the same bit for bit (must be).
Usage: python benchmarks/calibration_kills.py [kills]
"""

import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from killing import Killer

from helimag.calibration import calibrate

PLAN = """
particles = {particles}
[[run]]
name = "row1"
base = "paper/table1-row1"
changes = {{ "device.hydrodynamics.model" = "lighthill", workspace = {{}}, "run.duration" = "8 s" }}
[[run.observed]]
what = "rise"
value = "-0.38 mm"
sd = "0.1 mm"
source = "made up"
[[free]]
input = "device.weight.net_weight"
prior = "uniform"
low = "40 uN"
high = "60 uN"
[[free]]
input = "fluid.viscosity"
prior = "normal"
mean = "1 Pa s"
sd = "0.1 Pa s"
low = "0.5 Pa s"
"""
CHILD = "import sys; from helimag.calibration import calibrate; calibrate(sys.argv[1], output=sys.argv[2])"


def start(plan: Path, fit: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", CHILD, str(plan), str(fit)])


def state(path: Path) -> tuple[int, int] | None:
    """What tells whether a file has been written anew; None where there is none."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return found.st_mtime_ns, found.st_ino


def torture(folder: Path, *, kills: int, particles: int, seed: int = 0) -> dict[str, object]:
    """Kill and resume; what came of it."""
    killer = Killer(kills, random.Random(seed))
    plan, fit, kept = folder / "plan.toml", folder / "killed.nc", folder / "killed.nc.partial"
    plan.write_text(PLAN.format(particles=particles), encoding="utf-8")
    resumed, odd = 0, set[str]()
    while True:
        before = state(kept)
        child = start(plan, fit)
        status = killer.end(child, lambda before=before: state(kept) != before, share=0.8, within=0.05)
        resumed += before is not None
        odd |= {path.name for path in folder.iterdir() if not path.name.startswith(".")} - {
            plan.name,
            kept.name,
            fit.name,
        }
        if status != -signal.SIGKILL:
            break
    alone = folder / "alone.nc"
    if status != 0:
        raise SystemExit(f"the calibration failed: {status}")
    calibrate(plan, output=alone)
    left = sorted(path.name for path in folder.iterdir() if path not in (plan, fit, alone))
    return {
        "kills": killer.landed,
        "resumed": resumed,
        "same": fit.read_bytes() == alone.read_bytes(),
        "odd": sorted(odd),
        "left": left,
    }


def main() -> None:
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    with tempfile.TemporaryDirectory() as folder:
        found = torture(Path(folder), kills=kills, particles=128)
    print(
        f"{found['kills']} kills, {found['resumed']} times gone on from what was kept; the fit is "
        f"{'the same' if found['same'] else 'NOT the same'} bit for bit; odd files on the way: "
        f"{found['odd'] or 'none'}; left at the end: {found['left'] or 'nothing'}"
    )
    if found["kills"] != kills or not found["same"] or found["odd"] or found["left"]:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
