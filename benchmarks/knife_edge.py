"""How sharp is the start of Fig. 3(B)? The outcome over integration tolerances, at the published start and 1 um beside it.

Prints one line a run: start, tolerance, verdict, gain over the first 700 s, and when the device fell behind.
"""

import argparse

import numpy as np

import helimag as hm

TOLERANCES = (1e-6, 1e-7, 3e-7, 1e-8, 1e-9, 1e-10, 1e-11)
OFFSET = 1e-6  # m
PUBLISHED_START = np.array([0.0, -0.045, 0.0])  # m
PUBLISHED_TIME = 700.0  # s, at which the paper gives the gain


def starts() -> dict[str, np.ndarray]:
    """Displacements of the start (m), by name."""
    shifts = {"published": np.zeros(3)}
    for i, axis in enumerate("xyz"):
        for sign in (1.0, -1.0):
            shifts[f"{axis} {sign * OFFSET * 1e6:+.0f} um"] = sign * OFFSET * np.eye(3)[i]
    return shifts


def gain_until(run: hm.Trajectory, time: float) -> float:
    """Gain of the part of a run up to ``time`` (s)."""
    early = run.dataset.sel(time=slice(0.0, time))
    return float(early["height_high"].max() - early["height_low"].min()) / run.dataset.attrs["initial_gap"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--preset", default="paper/fig3b")
    parser.add_argument("--tolerances", type=float, nargs="+", default=sorted(TOLERANCES, reverse=True))
    options = parser.parse_args()
    scenario = hm.load(options.preset)
    names = list(starts())
    states = np.array([[*(PUBLISHED_START + shift), 1.0, 0.0, 0.0, 0.0] for shift in starts().values()])
    print(f"{'start':10s} {'tolerance':>9s} {'verdict':>9s} {'gain(700 s)':>11s} {'fell behind (s)':>15s}")
    for tolerance in options.tolerances:
        runs = hm.simulate_many([scenario] * len(names), initial_states=states, tolerance=tolerance)
        for name, run in zip(names, runs, strict=True):
            judged = run.judgement
            escape = "-" if judged.escape_time is None else f"{judged.escape_time:.0f}"
            early = gain_until(run, PUBLISHED_TIME)
            print(f"{name:10s} {tolerance:9.0e} {judged.verdict:>9s} {early:11.3f} {escape:>15s}")


if __name__ == "__main__":
    main()
