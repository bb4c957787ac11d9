"""helimag beside other codes: the same equations, the same error, one core, in interleaved rounds of one process.

    python benchmarks/peers [ROUNDS]

Every code's right-hand side is first held against helimag's kernel on random states. Then each gets the loosest
tolerance that brings the head within 1e-6 m and within 1e-8 m of the exact place after 100 s, and is timed over
`paper/fig3c` (1800 s) in CPU seconds; the fastest also over most of the other presets of Fig. 3. The peers give
their last state and nothing else; helimag also samples, gathers extremes, counts slips and watches for events. Peers
that are not installed are named and left out.
Writes benchmarks/results/peers.json, from which benchmarks/peers/figure.py draws.
"""

import importlib.util
import json
import os
import platform
import sys
from collections.abc import Container, Sequence
from pathlib import Path

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core, whatever threads a code starts

import numpy as np
from checks import ROUNDING, difference
from codes import BATCH, LEAPING, PEERS, Code, Floats, helimag_codes
from measure import HORIZON, Tuning, rounds, timed

from helimag.scenario import Scenario, load

PRESET = "paper/fig3c"
OTHERS = {"paper/fig3a": 1250.0, "paper/fig3b": 1200.0}  # s, before the one is drawn in and the other falls
FASTEST = ("heyoka", "numbalsoda")  # of the peers
TARGETS = (1e-6, 1e-8)  # m
EXACT = 1e-12  # tolerance of the run that errors are measured against
ROUNDS = 5
RESULTS = Path(__file__).parent.parent / "results" / "peers.json"


def ready_codes(scenario: Scenario, packages: Container[str] = dict(PEERS)) -> list[Code]:
    """helimag's codes and the peers that can be run and whose equations are the same; the others are named."""
    codes = helimag_codes(scenario)
    for package, make in (peer for peer in PEERS if peer[0] in packages):
        if importlib.util.find_spec(package) is None:
            print(f"{package} is left out: it is not installed (numbalsoda needs a Fortran compiler)")
            continue
        code = make(scenario)
        away = difference(scenario, code.rates)
        if away > ROUNDING:
            raise SystemExit(f"{code.name} does not solve the same equations: its rates differ by {away:.1e}")
        print(f"{code.name}: rates as the kernel's within {away:.0e} of the largest")
        codes.append(code)
    return codes


def tuned(codes: list[Code], exact: Floats) -> dict[str, Tuning]:
    """What error each code makes at which tolerance."""
    found: dict[str, Tuning] = {}
    for code in codes:
        if code.same_as is None:
            found[code.name] = Tuning(code, exact)
            found[code.name].scan(0.5 * min(TARGETS))
    return found


def compared(codes: list[Code], found: dict[str, Tuning], target: float, duration: float, count: int) -> list[dict]:
    """A row a code: times a run, and ratios to helimag's leaping run of the same round."""
    jobs, rows = [], []
    for code in codes:
        tuning = found[code.same_as or code.name]
        tolerance = tuning.tolerance_for(target)
        if not tolerance > 0.0:
            print(f"{code.name} is left out at {target:.0e} m: no tolerance reaches it")
            continue
        jobs.append((code, tolerance))
        rows.append({"code": code.name, "target": target, "tolerance": tolerance, "error": tuning.error(tolerance)})
    seconds = rounds(jobs, duration, count)
    ours = [code.name for code, _ in jobs].index(LEAPING)
    for row, times in zip(rows, seconds.T, strict=True):
        row["seconds"], row["ratios"] = times.tolist(), (times / seconds[:, ours]).tolist()
    return rows


def print_table(rows: list[dict], preset: str, duration: float, target: float) -> None:
    print(
        f"\n{preset}, {duration:g} s, error at {HORIZON:g} s within {target:.0e} m;"
        " CPU time a run, least to most in brackets"
    )
    print(f"{'code':38s} {'tolerance':>9s} {'error':>9s} {'ms a run':>25s} {'times helimag':>21s}")
    for row in rows:
        ms, ratios = 1e3 * np.array(row["seconds"]), np.array(row["ratios"])
        print(
            f"{row['code']:38s} {row['tolerance']:9.1e} {row['error']:7.1e} m"
            f" {np.median(ms):9.1f} ({ms.min():.1f}-{ms.max():.1f})".ljust(84)
            + f" {np.median(ratios):6.2f} ({ratios.min():.2f}-{ratios.max():.2f})"
        )


def curves(codes: list[Code], found: dict[str, Tuning], duration: float) -> list[dict]:
    """Work against precision: a point a tolerance, of codes that make a run at a time or several."""
    points = []
    for code in (code for code in codes if code.runs < BATCH):
        for tolerance, error in found[code.same_as or code.name].errors.items():
            if 1e-10 < error < 1e-4:
                code.run(1.0, tolerance)
                points.append(
                    {"code": code.name, "tolerance": tolerance, "error": error,
                     "seconds": min(timed(code, duration, tolerance) for _ in range(2))}
                )  # fmt: skip
    return points


def cost_model(scenario: Scenario, rows: list[dict]) -> list[dict]:
    """What a run costs at once and a turn, for helimag's codes: a line through the times of three durations."""
    found = []
    durations = np.array([0.25, 0.5, 1.0]) * scenario.run.duration
    for code in (code for code in helimag_codes(scenario) if code.runs == 1):
        tolerance = next(row["tolerance"] for row in rows if row["code"] == code.name)
        seconds = [min(timed(code, float(d), tolerance) for _ in range(3)) for d in durations]
        slope, once = np.polyfit(durations * abs(scenario.drive.frequency), seconds, 1)
        found.append({"code": code.name, "tolerance": tolerance, "once": float(once), "turn": float(slope)})
        print(f"{code.name}: {1e3 * once:.1f} ms and {1e6 * slope:.2f} us a turn of the magnet")
    return found


def tables_of(
    codes: list[Code], found: dict[str, Tuning], preset: str, duration: float, count: int, targets: Sequence[float]
) -> list[dict]:
    """Rows of a preset for each error aimed at, which are printed."""
    tables = []
    for target in targets:
        rows = compared(codes, found, target, duration, count)
        print_table(rows, preset, duration, target)
        tables += rows
    return tables


def exact_place(codes: list[Code]) -> Floats:
    """Where the head is at the horizon of errors."""
    return next(code for code in codes if code.name == "helimag, direct").run(HORIZON, EXACT)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    scenario = load(PRESET)
    codes = ready_codes(scenario)
    found = tuned(codes, exact_place(codes))
    duration = scenario.run.duration
    tables = tables_of(codes, found, PRESET, duration, count, TARGETS)
    for preset, end in OTHERS.items():
        others = ready_codes(load(preset), FASTEST)
        tables_of(others, tuned(others, exact_place(others)), preset, end, count, TARGETS[:1])
    print(f"\nwhat a run costs at {min(TARGETS):.0e} m")
    model = cost_model(scenario, [row for row in tables if row["target"] == min(TARGETS)])
    RESULTS.parent.mkdir(exist_ok=True)
    machine = {"machine": platform.machine(), "python": platform.python_version()}
    RESULTS.write_text(
        json.dumps(
            {"preset": PRESET, "machine": machine, "table": tables, "model": model,
             "curves": curves(codes, found, duration)}, indent=1,
        )
    )  # fmt: skip
    print(f"written to {RESULTS}")


if __name__ == "__main__":
    main()
