"""How sharp is the start of Fig. 3(B)? The outcome at the published start and 1 um beside it, integrated in many ways.

Tolerance and sampling interval change nothing but the integrator's steps, that is, its rounding and truncation errors.
For each start: how many of these runs fell, and the range of the gain at 700 s of those that fell, and stayed.
"""

import argparse
from itertools import product

import numpy as np

import helimag as hm

PUBLISHED_START = np.array([0.0, -0.045, 0.0])  # m
PUBLISHED_TIME = 700.0  # s, at which the paper gives the gain
OFFSET = 1e-6  # m
DURATION = 1000.0  # s; by then it has fallen or not
TOLERANCES = (1e-6, 3e-7, 1e-7, 1e-8, 1e-9, 1e-11)
INTERVALS = (0.3, 700.0 / 1800.0, 0.5, 0.7, 1.0)  # s; the second is the default of a run of 700 s


def starts() -> dict[str, tuple[float, ...]]:
    """Where device and magnet start (m), by name: the magnet is placed above the device in each."""
    places = {"published": PUBLISHED_START}
    for i, axis in enumerate("xyz"):
        for sign in (1.0, -1.0):
            places[f"{axis} {sign * OFFSET * 1e6:+.0f} um"] = PUBLISHED_START + sign * OFFSET * np.eye(3)[i]
    return {name: tuple(place.tolist()) for name, place in places.items()}


def gain_until(run: hm.Trajectory, time: float) -> float:
    """Gain of the part of a run up to ``time`` (s)."""
    early = run.dataset.sel(time=slice(0.0, time))
    return float(early["height_high"].max() - early["height_low"].min()) / run.dataset.attrs["initial_gap"]


def span(values: list[float]) -> str:
    """Smallest and largest value."""
    return f"{min(values):.2f} to {max(values):.2f}" if values else "-"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", action="store_true", help="print a line for every run too")
    options = parser.parse_args()
    places = starts()
    fell: dict[str, list[float]] = {name: [] for name in places}
    stayed: dict[str, list[float]] = {name: [] for name in places}
    base = hm.load("nose-first/fig3b")
    for tolerance, interval in product(TOLERANCES, INTERVALS):
        changes = {"run.duration": DURATION, "run.interval": interval}
        scenarios = [base.replaced({**changes, "drive.start": place}) for place in places.values()]
        runs = hm.simulate_many(scenarios, method="direct", tolerance=tolerance, refine=False)
        for name, run in zip(places, runs, strict=True):
            gain = gain_until(run, PUBLISHED_TIME)
            (fell if run.verdict == "fell" else stayed)[name].append(gain)
            if options.each:
                print(f"{name:10s} tolerance {tolerance:.0e} interval {interval:.3f} s {run.verdict:9s} {gain:.3f}")
    count = len(TOLERANCES) * len(INTERVALS)
    print(f"{'start':10s} {'fell':>9s} {'their gain(700 s)':>18s} {'gain(700 s) of those that stayed':>33s}")
    for name in places:
        print(f"{name:10s} {len(fell[name]):3d} of {count:2d} {span(fell[name]):>18s} {span(stayed[name]):>33s}")


if __name__ == "__main__":
    main()
