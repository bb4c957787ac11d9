"""The figures of docs/theory/orbits.md: a branch with its fold, stability over two inputs, the slow flow and the basin.

python benchmarks/orbit_figures.py [FOLDER]
"""

import math
import sys
import time
from pathlib import Path

import numpy as np

import helimag as hm
from helimag import plots
from helimag.orbits import (
    averaged_rates,
    averaging_error,
    basin,
    boundary_of,
    fixed_points,
    follow,
    slow_flow,
    stability_map,
)

HALF = np.array([0.055, 0.055, 0.05])  # m, of the box that the flow is drawn in
FLOW_NODES = (13, 13, 13)
STARTS = (9, 9, 9)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/theory/figures")
    folder.mkdir(parents=True, exist_ok=True)
    scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    orbit = hm.find_orbit(scenario)

    branch = follow(orbit, "drive.pitch", math.radians(4.0), math.radians(20.0))
    plots.save(plots.draw_branches([branch]), folder / "branch.png")
    print(branch.text)

    begun = time.perf_counter()
    pitches, frequencies = np.radians(np.linspace(4.0, 20.0, 60)), np.linspace(1.5, 4.0, 60)
    stable = stability_map(scenario, ("drive.pitch", pitches), ("drive.frequency", frequencies), seeds=[orbit])
    print(f"stability map of 60 x 60 nodes: {time.perf_counter() - begun:.0f} s, {stable.stable.sum()} stable")
    begun = time.perf_counter()
    curves = boundary_of(stable)
    print(f"boundary: {time.perf_counter() - begun:.0f} s")
    for curve in curves:
        first, second = np.degrees(curve.first), curve.second
        print(
            f"{curve.kind}, {first.size} points, from {first[0]:.3f} deg and {second[0]:.4f} Hz ({curve.ends[0]}) to "
            f"{first[-1]:.3f} deg and {second[-1]:.4f} Hz ({curve.ends[1]})"
        )
    plots.save(plots.draw_stability(stable, curves), folder / "stability.png")

    begun = time.perf_counter()
    flow = slow_flow(orbit, low=orbit.position - HALF, high=orbit.position + HALF, shape=FLOW_NODES)
    print(f"slow flow of {flow.settled.size} nodes: {time.perf_counter() - begun:.0f} s")
    print(f"rates of the averaged model {averaged_rates(flow, orbit)}, of the orbit {orbit.rates[:3]}")
    for away in (0.005, 0.01, 0.02):
        error = averaging_error(flow, orbit.position + np.array([away, 0.0, 0.0]), 1800.0)
        print(
            f"averaged model from {1e3 * away:.0f} mm: {1e3 * error.mean:.2f} mm off, {1e3 * error.worst:.2f} at most"
        )
    points = fixed_points(flow)
    for point in points:
        print(f"{point.kind} at {1e3 * point.position} mm, exact to {1e3 * point.error:.2g} mm")
    quick = basin(orbit, low=orbit.position - HALF, high=orbit.position + HALF, shape=STARTS, flow=flow)
    print(quick.text)
    plots.save(plots.draw_flow(flow, orbit, quick, fixed_points=points), folder / "flow.png")
    caught = basin(orbit, low=orbit.position - HALF, high=orbit.position + HALF, shape=STARTS)
    print(caught.text)
    plots.save(plots.draw_basin(caught), folder / "basin.png")


if __name__ == "__main__":
    main()
