"""Fit the net weight and its place for the straight runs of Table I, and print what all seven rows then do.

The paper gives neither. For each of a few places, the weight is taken that leaves row 1 (the bounded run) the least
range of heights; the place is taken whose attack angle in row 1 is nearest to the measured -6 deg.
"""

import numpy as np

from helimag.engine import advance
from helimag.scenario import load

WEIGHTS = np.arange(34e-6, 50e-6, 0.25e-6)
PLACES = (0.0, -1e-3, -2e-3, -3e-3)


def main() -> None:
    """Print, for each place, the best weight and the outcome of every row."""
    rows = [load(f"nose-first/table1-row{i}") for i in range(1, 8)]
    for place in PLACES:
        changes = [{"device.weight.net_weight": w, "device.weight.gravity_center": place} for w in WEIGHTS]
        outputs = [history.judge().output for history in advance([rows[0].replaced(change) for change in changes])]
        best = changes[int(np.argmin(outputs))]
        histories = advance([row.replaced(best) for row in rows])
        print(f"net weight {1e6 * best['device.weight.net_weight']:.2f} uN at {1e3 * place:.0f} mm")
        for number, history in enumerate(histories, 1):
            judgement = history.judge()
            way = "up" if history.states[-1, 2] > history.states[0, 2] else "down"
            angle = np.rad2deg(judgement.attack_angle)
            wobble = np.rad2deg(judgement.wobble)
            print(
                f"  row {number}: {way:4s} {1e3 * judgement.output:6.2f} mm, ends at the {history.heights.end}, "
                f"attack angle {angle:6.1f} deg, wobble {wobble:4.1f} deg"
            )


if __name__ == "__main__":
    main()
