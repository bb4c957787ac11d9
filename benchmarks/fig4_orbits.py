"""Fig. 4's trend of pitch without a start in it: over which pitches the orbit of Fig. 3(C) is stable, by frequency.

Run: python benchmarks/fig4_orbits.py. A run from one start samples a boundary that its basin blurs; the orbit has it
exactly. Everything but frequency and pitch is the preset's.
"""

import numpy as np

from helimag.orbits import find_orbit, stable_interval
from helimag.scenario import load

FREQUENCIES = (2.0, 2.25, 2.5, 2.75, 3.0, 3.3)  # Hz
LOW, HIGH = np.radians([2.0, 30.0])


def main() -> None:
    """Print an interval for each frequency."""
    for frequency in FREQUENCIES:
        orbit = find_orbit(load("paper/fig3c").replaced({"drive.frequency": frequency}))
        if not orbit.stable:
            print(f"{frequency:g} Hz: {orbit.text}")
            continue
        found = stable_interval(orbit, "drive.pitch", float(LOW), float(HIGH))
        extent = np.degrees(found.high - found.low)
        print(f"{frequency:g} Hz: {found.text}; {extent:.1f} deg", flush=True)


if __name__ == "__main__":
    main()
