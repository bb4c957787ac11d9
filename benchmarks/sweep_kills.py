"""Kill a sweep with SIGKILL at random moments, resume it each time, and compare with one that was left alone.

Prints how many runs were begun again after they had been committed (must be 0) and whether every file of the two stores
is the same (must be). Usage: python benchmarks/sweep_kills.py [kills]
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from killing import Killer

PLAN = """
name = "kill me"
base = "nose-first/fig3c"
duration = "{duration}"
samples = 20

[[axis]]
field = "drive.frequency"
values = ["2 Hz", "3 Hz"]

[[axis]]
field = "drive.pitch"
start = "2 deg"
stop = "20 deg"
count = {count}
"""
# a sweep that writes down each run as it begins; argv: plan, store, log
CHILD = """
import os, sys
from helimag import sweep
from helimag.sweeps import engines

log = os.open(sys.argv[3], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
compute = engines.compute

def logged(scenarios, *args, **options):
    os.write(log, "".join(scenario.hash + "\\n" for scenario in scenarios).encode())
    return compute(scenarios, *args, **options)

engines.compute = logged
sweep(sys.argv[1], out=sys.argv[2])
"""


def start(plan: Path, store: Path, log: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", CHILD, str(plan), str(store), str(log)])


def committed(plan: Path, store: Path) -> set[str]:
    """Hashes of the runs whose chunks have their row of checksums."""
    from helimag.sweeps import load_plan, resolve

    design = resolve(load_plan(plan))
    chunks = [int(row.parent.name) for row in (store / "checksum" / "c").glob("*/0")]
    return {design.scenario(values).hash for chunk in chunks for values in design.points(chunk)}


def files(store: Path) -> dict[str, bytes]:
    return {str(path.relative_to(store)): path.read_bytes() for path in sorted(store.rglob("*")) if path.is_file()}


def torture(folder: Path, *, kills: int, count: int, seed: int = 0) -> dict[str, object]:
    """Kill and resume; what came of it."""
    killer = Killer(kills, random.Random(seed))
    plan, store, log = folder / "plan.toml", folder / "killed.zarr", folder / "log"
    plan.write_text(PLAN.format(count=count, duration="60 s"), encoding="utf-8")
    log.touch()
    begun = repeated = 0
    while True:
        known, before = committed(plan, store), len(log.read_text().splitlines())
        child = start(plan, store, log)
        status = killer.end(child, lambda size=before * 65: log.stat().st_size != size, share=0.7, within=0.25)
        ran = log.read_text().splitlines()[before:]
        begun += len(ran)
        repeated += len(known.intersection(ran)) + len(ran) - len(set(ran))
        if status != -signal.SIGKILL:
            break
    if status != 0:
        raise SystemExit(f"the sweep failed: {status}")
    alone = folder / "alone.zarr"
    if start(plan, alone, folder / "log-alone").wait() != 0:
        raise SystemExit("the sweep that was left alone failed")
    return {
        "kills": killer.landed,
        "runs": 2 * count,
        "begun": begun,
        "repeated": repeated,
        "same": files(store) == files(alone),
        "files": len(files(alone)),
    }


def main() -> None:
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    with tempfile.TemporaryDirectory() as folder:
        found = torture(Path(folder), kills=kills, count=600)
    print(
        f"{found['kills']} kills, {found['runs']} runs; {found['begun']} begun, {found['repeated']} of them again "
        f"after their commit; all {found['files']} files {'the same' if found['same'] else 'NOT the same'}"
    )
    if found["repeated"] or not found["same"] or found["kills"] != kills:
        raise SystemExit(1)


if __name__ == "__main__":
    os.environ.setdefault("PYTHONHASHSEED", "0")
    main()
