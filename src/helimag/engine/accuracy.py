"""How far to trust the places of a run: it is set beside the same run with finer steps.

The two differ by about as much as the run is wrong. Looser steps would cost less, but where the longest step allowed
decides, and not the tolerance, they are the same steps and tell nothing. A device that loses step multiplies
every error greatly (`docs/howto/simulate.md` has a run), so what comes before and after that is told apart. Runs that
are to be exact there, and just before an end, are refined: the finer run takes the place of the other.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

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
WANTED = 5e-7  # m: then extremes are within 1e-6 m and gains within 1e-5; benchmarks/random_runs.py
WANTED_END = 5e-4  # s
FINEST = 1e-11  # a tolerance: rounding is not far below
SHARE_OF_REST = 0.6  # of the work that is left, for one more run: after most there is none


@dataclass(frozen=True)
class Accuracy:
    """A run beside itself with finer steps.

    Attributes
    ----------
    in_step
        Twice the largest distance of the heads up to the first slip, m; 1e-10 at least.
    first_slip
        Time of the first sample after one, s; None where neither slips.
    after_slip
        Twice the largest distance from there on, m; None where there is nothing after it.
    slips
        Turns slipped by the run, and by the one with finer steps.
    end
        By how much the two end apart, s.
    sensitive
        Whether only outcomes can be trusted after the first slip, not places nor the number of slips: there steps of
        the tolerance that was asked for and finer ones lead to places visibly apart.
    finer_steps
        Tolerance that was asked for over that of the run; 1 where its steps are as asked.
    """

    in_step: float
    first_slip: float | None
    after_slip: float | None
    slips: tuple[int, int]
    end: float
    sensitive: bool
    finer_steps: float = 1.0

    @property
    def enough(self) -> bool:
        """Whether finer steps would change nothing that matters."""
        return max(self.in_step, self.after_slip or 0.0) <= WANTED and self.end <= WANTED_END

    @property
    def text(self) -> str:
        """In a sentence."""
        return f"{self._places}{self._outcome}{self._steps}"

    @property
    def _places(self) -> str:
        first = f"places within {self.in_step:.1g} m"
        if self.first_slip is None:
            return f"{first}, by the same run with finer steps"
        until = f"{first} until it loses step, by {self.first_slip:.4g} s"
        if self.after_slip is None:
            return until
        if self.after_slip <= VISIBLE:
            return f"{until}, and within {self.after_slip:.1g} m after that"
        ours, theirs = self.slips
        counted = f", which slips {theirs} turns and not {ours}" if ours != theirs else ""
        return f"{until}; after that {1e3 * self.after_slip:.2g} mm from the same run with finer steps{counted}"

    @property
    def _outcome(self) -> str:
        """What can be trusted where errors grow to be visible."""
        if not self.sensitive:
            return ""
        return "; what differs by next to nothing before differs visibly after: trust the outcome, not places or slips"

    @property
    def _steps(self) -> str:
        return "" if self.finer_steps == 1.0 else f" (steps of a {self.finer_steps:.0f} times finer tolerance)"


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
    return _compared(history, _again(history, tolerance * _finer(history), method, device, progress))


def refined(
    history: History,
    *,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    device: str = "cpu",
    progress: Callable[[float], None] | None = None,
) -> tuple[History, Accuracy]:
    """Run again with finer steps until that changes nothing that matters, or steps cannot be finer.

    ``tolerance``, ``method`` and ``device`` are those of the run.

    Returns
    -------
    History
        The run itself where its steps are fine enough, as they mostly are; else the finest.
    Accuracy
        Of that one.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    share, now, behind = _finer(history), tolerance * _finer(history), 0.0
    finer = _again(history, now, method, device, _after(progress, behind))
    accuracy = first = _compared(history, finer)
    while not accuracy.enough and now > 2.0 * FINEST:
        now, behind, rougher = max(now * share, FINEST), behind + SHARE_OF_REST * (1.0 - behind), finer
        finer = _again(rougher, now, method, device, _after(progress, behind))
        accuracy = _compared(rougher, finer)
    if accuracy is first:
        return history, first
    return finer, replace(accuracy, sensitive=first.sensitive, finer_steps=tolerance / now)


def _finer(history: History) -> float:
    """Share of the tolerance that shows what a run's steps miss."""
    return FINER if uniform(system_of(history.scenario)) else FINER_NEAR_WALLS


def _again(
    history: History, tolerance: float, method: Method, device: str, progress: Callable[[float], None] | None
) -> History:
    """The same run with other steps."""
    (again,) = advance(
        [history.scenario],
        initial_states=history.states[:1],
        tolerance=tolerance,
        method=method,
        device=device,
        progress=progress,
    )
    return again


def _after(progress: Callable[[float], None] | None, behind: float) -> Callable[[float], None] | None:
    """The progress of one more run, once this share of the work is done, if it takes its part of the rest."""
    return None if progress is None else lambda done: progress(behind + SHARE_OF_REST * (1.0 - behind) * done)


def _compared(history: History, finer: History) -> Accuracy:
    """A run beside itself with finer steps."""
    shared = min(len(history.time), len(finer.time))
    same = np.flatnonzero(history.time[:shared] == finer.time[:shared])
    apart = MARGIN * np.linalg.norm(history.states[same, :3] - finer.states[same, :3], axis=1)
    slipped = np.flatnonzero((history.slips[same] > 0.0) | (finer.slips[same] > 0.0))
    first = int(slipped[0]) if slipped.size else len(same)
    after = float(apart[first:].max()) if slipped.size else None
    return Accuracy(
        in_step=max(float(apart[:first].max(initial=0.0)), LEAST),
        first_slip=float(history.time[same[first]]) if slipped.size else None,
        after_slip=None if after is None else max(after, LEAST),
        slips=(int(history.slips[-1]), int(finer.slips[-1])),
        end=abs(float(history.time[-1] - finer.time[-1])),
        sensitive=after is not None and after > VISIBLE,
    )
