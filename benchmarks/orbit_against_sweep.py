"""Verdicts of half-hour runs against orbits, over a grid of pitch and frequency; every disagreement explained.

    python benchmarks/orbit_against_sweep.py [NODES [LOWEST HIGHEST]]

Frequencies run from LOWEST to HIGHEST, 1.5 to 4 Hz unless given. A sweep starts every run at the same place, which for
some inputs lies outside the basin of their stable orbit: runs from the scenario's own start and runs that start 5 mm
beside the orbit are counted apart. Exits with status 1 where fewer than 95 % of the second kind agree away from the
boundary, or where a difference finds no explanation.
"""

import sys
import time

import numpy as np

import helimag as hm
from helimag.engine import advance
from helimag.orbits import Why, compare_with_orbits


def main() -> int:
    nodes = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    lowest, highest = (float(text) for text in sys.argv[2:4]) if len(sys.argv) > 3 else (1.5, 4.0)
    base = hm.load("nose-first/fig3c")
    pitches, frequencies = np.radians(np.linspace(4.0, 18.0, nodes)), np.linspace(lowest, highest, nodes)
    scenarios = {
        (i, j): base.replaced({"drive.pitch": float(pitch), "drive.frequency": float(frequency)})
        for i, pitch in enumerate(pitches)
        for j, frequency in enumerate(frequencies)
    }
    begun = time.perf_counter()
    runs = advance(list(scenarios.values()))
    ran = time.perf_counter() - begun
    verdicts = np.array([str(run.judge().verdict) for run in runs]).reshape(nodes, nodes)
    result = compare_with_orbits(scenarios.__getitem__, verdicts)
    for case in result.cases:
        i, j = case.node
        place = "" if result.away[case.node] else " (beside the boundary)"
        print(f"{frequencies[j]:.3f} Hz {np.degrees(pitches[i]):6.3f} deg{place}: {case.text}")
    print(result.text)
    print(f"runs {ran:.0f} s, orbits and explanations {time.perf_counter() - begun - ran:.0f} s")
    unexplained = any(case.why is Why.UNEXPLAINED for case in result.cases)
    return 1 if unexplained or not result.share(beside=True) >= 0.95 else 0


if __name__ == "__main__":
    sys.exit(main())
