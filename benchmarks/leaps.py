"""Leaps over turns of the magnet: work against precision beside direct steps, and random runs beside exact ones.

Times are user CPU seconds of one core, the least of several, the methods in turn. Errors are against direct steps at a
tolerance of 1e-11, after 100 s and over the whole run, at samples.
"""

import math
import resource

import numpy as np

from helimag.engine import DOP853, MULTIREVOLUTION, History, Method, advance
from helimag.scenario import Scenario, load

MIRRORED = {  # the other handedness, so that the device swims and is carried the other way along x
    "device.helix.handedness": "right",
    "drive.yaw_rate": math.radians(-1.8),
    "drive.pitch": math.radians(-12.7),
}
REPEATS = 6
RANDOM_RUNS = 40


def user() -> float:
    """User CPU time of this process (s)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def timed(run: Scenario, method: Method, tolerance: float) -> tuple[History, float]:
    """A run and the time it took (s)."""
    begun = user()
    (history,) = advance([run], method=method, tolerance=tolerance, threads=1)
    return history, user() - begun


def distances(one: History, other: History) -> np.ndarray:
    """Distances (m) between two runs at the samples that both came to."""
    count = min(one.time.size, other.time.size)
    return np.asarray(np.linalg.norm(one.states[:count, :3] - other.states[:count, :3], axis=1))


def work_and_precision(name: str, run: Scenario) -> None:
    """Print a table of tolerances for one run."""
    exact, _ = timed(run, DOP853, 1e-11)
    print(f"{name}, {run.run.duration:g} s: method, tolerance, time, turns followed, error at 100 s, largest error")
    tolerances = (3e-6, 3e-7, 3e-8)
    best = {(method.name, t): math.inf for method in (DOP853, MULTIREVOLUTION) for t in tolerances}
    kept = {}
    for _ in range(REPEATS):
        for method in (DOP853, MULTIREVOLUTION):
            for tolerance in tolerances:
                history, seconds = timed(run, method, tolerance)
                key = (method.name, tolerance)
                best[key], kept[key] = min(best[key], seconds), history
    for (method_name, tolerance), seconds in best.items():
        history = kept[method_name, tolerance]
        away, followed = distances(history, exact), int(history.progress["leap"]["followed"])
        early = away[history.time[: away.size] <= 100.0].max()
        errors = f"{early:.1e} m {away.max():.1e} m"
        print(f"  {method_name:24s} {tolerance:.0e} {1e3 * seconds:7.1f} ms {followed:5d} {errors}")


def random_run(generator: np.random.Generator) -> Scenario:
    """A run in step, losing step, slipping, attracted or falling, with or without walls."""
    mirrored = generator.random() < 0.5
    sign = -1.0 if mirrored else 1.0
    changes = {
        "run.duration": 400.0,
        "drive.pitch": sign * math.radians(generator.uniform(8.0, 17.0)),
        "drive.distance": generator.uniform(0.09, 0.2),
        "drive.yaw_rate": sign * math.radians(generator.uniform(0.5, 3.0)),
        "drive.frequency": generator.uniform(1.0, 4.5),
    }
    if generator.random() < 0.3:
        changes |= {"workspace.floor": -0.05, "workspace.surface": 0.03}
    return load("paper/fig3c").replaced((MIRRORED if mirrored else {}) | changes)


def predictable(one: History, other: History) -> bool:
    """Whether two runs at close tolerances are the same run."""
    same = one.status is other.status and one.slips[-1] == other.slips[-1]
    return bool(same and distances(one, other).max() < 1e-6 and one.judge().verdict is other.judge().verdict)


def main() -> None:
    """Print all tables."""
    preset = load("paper/fig3c")
    work_and_precision("paper/fig3c", preset)
    work_and_precision("its mirror image", preset.replaced(MIRRORED))
    generator = np.random.default_rng(1)
    runs = [random_run(generator) for _ in range(RANDOM_RUNS)]
    rough, exact = (advance(runs, tolerance=tolerance) for tolerance in (1e-10, 1e-11))
    leaping, direct = advance(runs, method=MULTIREVOLUTION), advance(runs)
    for name, histories in (("multi-revolution", leaping), ("direct", direct)):
        known = [(h, e) for h, r, e in zip(histories, rough, exact, strict=True) if predictable(r, e)]
        verdicts = sum(h.judge().verdict is e.judge().verdict for h, e in known)
        times = max(abs(h.time[-1] - e.time[-1]) for h, e in known)
        gains = max(abs(h.judge().gain - e.judge().gain) for h, e in known)
        extremes = max(
            max(
                abs(h.records["low"].min() - e.records["low"].min()),
                abs(h.records["high"].max() - e.records["high"].max()),
            )
            for h, e in known
        )
        print(
            f"{name} on {len(known)} predictable of {len(runs)} random runs: {verdicts} verdicts equal; at most "
            f"{1e3 * times:.2g} ms at the end, {gains:.1e} of the gain, {extremes:.1e} m of extremes"
        )


if __name__ == "__main__":
    main()
