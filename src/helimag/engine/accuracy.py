"""How far to trust the places of a run: it is set beside the same run with finer steps.

The two differ by about as much as the run is wrong. Looser steps would cost less, but where the longest step allowed
decides, and not the tolerance, they are the same steps and tell nothing. A device that loses step multiplies
every error greatly (`docs/howto/simulate.md` has a run), so what comes before and after that is told apart.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from helimag.engine.batch import TOLERANCE
from helimag.engine.history import History
from helimag.engine.methods import MULTIREVOLUTION, Method
from helimag.engine.running import advance
from helimag.engine.system import system_of, uniform

FINER = 1.0 / 30.0  # of the tolerance
FINER_NEAR_WALLS = 1.0 / 1000.0  # what walls add is followed to first order within a step, so that errors fall slower
MARGIN = 2.0  # of what is told over what is found: the finer run is wrong, too
LEAST = 1e-10  # m; nothing less is told: where the longest step allowed decides, both runs have the same steps
VISIBLE = 1e-5  # m: what cameras tell apart; runs farther apart than that are not the same to anyone who looks


@dataclass(frozen=True)
class Accuracy:
    """A run beside itself with finer steps.

    Attributes
    ----------
    in_step
        Twice the largest distance of the heads up to the first slip, m.
    first_slip
        Time of the first sample after one, s; None where neither slips.
    after_slip
        Twice the largest distance from there on, m; None where there is nothing after it.
    slips
        Turns slipped by the run, and by the one with finer steps.
    end
        By how much the two end apart, s.
    """

    in_step: float
    first_slip: float | None
    after_slip: float | None
    slips: tuple[int, int]
    end: float

    @property
    def sensitive(self) -> bool:
        """Whether only outcomes can be trusted after the first slip, not places nor the number of slips."""
        return self.after_slip is not None and (self.after_slip > VISIBLE or self.slips[0] != self.slips[1])

    @property
    def text(self) -> str:
        """In a sentence."""
        first = f"places within {max(self.in_step, LEAST):.1g} m"
        if self.first_slip is None:
            return f"{first}, by the same run with finer steps"
        until = f"{first} until it loses step, by {self.first_slip:.4g} s"
        if self.after_slip is None:
            return until
        if not self.sensitive:
            return f"{until}, and within {max(self.after_slip, LEAST):.1g} m after that"
        ours, theirs = self.slips
        return (
            f"{until}; after that {1e3 * self.after_slip:.2g} mm from the same run with finer steps, which slips "
            f"{theirs} turns and not {ours}: trust the outcome, not places or slips"
            if ours != theirs
            else f"{until}; after that {1e3 * self.after_slip:.2g} mm from the same run with finer steps: trust the "
            "outcome, not places"
        )


def accuracy_of(
    history: History,
    *,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    device: str = "cpu",
    progress: Callable[[float], None] | None = None,
) -> Accuracy:
    """Run again with finer steps, and compare; ``tolerance``, ``method`` and ``device`` are those of the run.

    Returns
    -------
    Accuracy
        What the two runs differ by (m), until and after the first loss of step, and whether the end can be foretold.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    (finer,) = advance(
        [history.scenario],
        initial_states=history.states[:1],
        tolerance=tolerance * (FINER if uniform(system_of(history.scenario)) else FINER_NEAR_WALLS),
        method=method,
        device=device,
        progress=progress,
    )
    shared = min(len(history.time), len(finer.time))
    same = np.flatnonzero(history.time[:shared] == finer.time[:shared])
    apart = MARGIN * np.linalg.norm(history.states[same, :3] - finer.states[same, :3], axis=1)
    slipped = np.flatnonzero((history.slips[same] > 0.0) | (finer.slips[same] > 0.0))
    first = int(slipped[0]) if slipped.size else len(same)
    return Accuracy(
        in_step=float(apart[:first].max(initial=0.0)),
        first_slip=float(history.time[same[first]]) if slipped.size else None,
        after_slip=float(apart[first:].max()) if slipped.size else None,
        slips=(int(history.slips[-1]), int(finer.slips[-1])),
        end=abs(float(history.time[-1] - finer.time[-1])),
    )
