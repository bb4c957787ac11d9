"""Trial steps and achieved error for several settings of the step controller.

The error oscillates twice a turn, as the field grows and shrinks. A controller that follows it wastes steps on trials
that are rejected; one that grows slowly stays below it. Work at equal error is trials times error^(1/8).
"""

from dataclasses import replace

import numpy as np

from helimag.engine import DOP853, advance
from helimag.scenario import load

SETTINGS = ((0.9, 3.0), (0.9, 1.3), (0.9, 1.1), (0.8, 1.2), (0.8, 1.1), (0.85, 1.05))


def main() -> None:
    """Print a row a setting."""
    scenario = load("nose-first/fig3c").replaced({"run.duration": 100.0, "run.interval": 1.0})
    exact = advance([scenario], method=DOP853, tolerance=1e-13)[0].states[-1, :3]
    for safety, grow in SETTINGS:
        history = advance([scenario], method=replace(DOP853, safety=safety, growth=grow))[0]
        error = np.linalg.norm(history.states[-1, :3] - exact)
        trials = history.steps + history.rejected
        print(
            f"safety {safety:4.2f}, growth {grow:4.2f}: {trials} trials, {history.rejected} rejected, "
            f"error {error:.1e} m, work {trials * error**0.125:.0f}"
        )


if __name__ == "__main__":
    main()
