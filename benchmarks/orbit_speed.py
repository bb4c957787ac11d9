"""How long orbits take: one from a neighbouring start with its multipliers, a 100 x 100 map of stability, its boundary.

    python benchmarks/orbit_speed.py [NODES]

Prints the fastest and the median of thirty neighbours, and one time for the map and the boundary. The accuracy of the
multipliers is benchmarks/orbit_brute_force.py's business; here each neighbour's leading rate is compared with the one
from a search that knows nothing of the neighbour.
"""

import sys
import time

import numpy as np

import helimag as hm
from helimag.orbits import boundary_of, stability_map

NEIGHBOURS = 10
SAME = 1e-6  # relative


def main() -> int:
    nodes = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    orbit = hm.find_orbit(scenario)
    times, worst = [], 0.0
    for path, near in {"drive.pitch": "12.9 deg", "drive.frequency": "2.45 Hz", "drive.distance": "152 mm"}.items():
        beside = scenario.replaced({path: near})
        alone = hm.find_orbit(beside)
        for _ in range(NEIGHBOURS):
            begun = time.perf_counter()
            found = hm.find_orbit(beside, near=orbit)
            times.append(time.perf_counter() - begun)
        worst = max(worst, abs(found.growth / alone.growth - 1.0))
    print(
        f"an orbit from a neighbour: {1e3 * min(times):.1f} ms, median {1e3 * float(np.median(times)):.1f} ms; "
        f"leading rates as found alone within {worst:.1e}"
    )
    pitches, frequencies = np.radians(np.linspace(4.0, 20.0, nodes)), np.linspace(1.5, 4.0, nodes)
    begun = time.perf_counter()
    result = stability_map(scenario, ("drive.pitch", pitches), ("drive.frequency", frequencies))
    mapped = time.perf_counter() - begun
    curves = boundary_of(result)
    traced = time.perf_counter() - begun - mapped
    points = sum(curve.first.size for curve in curves)
    print(
        f"{nodes} x {nodes} map: {mapped:.1f} s, {int(result.stable.sum())} stable; "
        f"boundary of {len(curves)} curves, {points} points: {traced:.1f} s"
    )
    return 0 if worst < SAME else 1


if __name__ == "__main__":
    sys.exit(main())
