"""Is there one device for the paper's simulation and its experiment? Each family's device in the other's drives.

Run: python benchmarks/one_device.py. First both families' devices under all drives; then the experiment's device, with
its true drag, under the drives of Fig. 3, for a grid of net weights and gravity centres.
"""

from collections import Counter
from itertools import product

import numpy as np

from helimag.engine import advance
from helimag.scenario import Scenario, load

CASES = [load(f"paper/fig3{case}") for case in "abc"]
ROWS = [load(f"paper/table1-row{row}") for row in range(1, 8)]
WEIGHTS = np.arange(4e-6, 61e-6, 3e-6)
PLACES = np.arange(-8e-3, 3.1e-3, 1e-3)


def with_device_of(drive: Scenario, other: Scenario) -> Scenario:
    """A scenario's drive, with another's device and fluid."""
    device, fluid = other.device.model_dump(), other.fluid.model_dump()
    return drive.replaced({"device": device, "fluid": fluid, "provenance": {}})


def main() -> None:
    """Print all of it."""
    ends = [str(h.heights.end) for h in advance([with_device_of(row, CASES[0]) for row in ROWS])]
    print("the simulation's device in Table I, rows 1-7:", ", ".join(ends))
    swapped = [with_device_of(case, ROWS[0]) for case in CASES]
    ends = [f"{h.judge().verdict} at {h.judge().escape_time:.0f} s" for h in advance(swapped)]
    print("the experiment's device in Fig. 3, A-C:", ", ".join(ends))
    found: Counter[tuple[str, ...]] = Counter()
    for weight, place in product(WEIGHTS, PLACES):
        changes = {"device.weight.net_weight": weight, "device.weight.gravity_center": place}
        runs = advance([with_device_of(case, ROWS[0]).replaced(changes) for case in CASES])
        found[tuple(str(run.judge().verdict) for run in runs)] += 1
    print(f"true drag, {WEIGHTS.size} net weights of 4 to 58 uN, {PLACES.size} gravity centres of -8 to 3 mm; A, B, C:")
    for outcomes, count in found.most_common():
        print(f"  {count:3d}  {', '.join(outcomes)}")


if __name__ == "__main__":
    main()
