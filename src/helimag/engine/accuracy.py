"""How far to trust the places of a run, and finer steps for those that need them.

A run is set beside the same run with finer steps. The two differ by about as much as the run is wrong. Looser steps
would cost less, but where the longest step allowed decides, and not the tolerance, they are the same steps and tell
nothing. A device that loses step multiplies every error greatly (`docs/howto/simulate.md` has a run), and so does one
that is drawn into the magnet. What comes before and after a loss of step is told apart; and such runs are refined: they
are made again with steps so fine that what is multiplied is next to nothing.
"""

from collections.abc import Callable, Sequence
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
SURE = 1e-10  # a tolerance, of runs that multiply errors: benchmarks/random_runs.py
FINEST = 1e-11  # a tolerance: rounding is not far below


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
    other_verdict
        A verdict that other steps lead to; None where all that were taken lead to the same.
    refined
        Whether the run was made again with finer steps than were asked for, see :func:`refined`.
    """

    in_step: float
    first_slip: float | None
    after_slip: float | None
    slips: tuple[int, int]
    end: float
    sensitive: bool
    other_verdict: str | None = None
    refined: bool = False

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
        if self.other_verdict is not None:
            return f"; the outcome depends on the steps as well: with others the verdict is '{self.other_verdict}'"
        if self.sensitive:
            return (
                "; what differs by next to nothing before differs visibly after: trust the outcome, not places or slips"
            )
        return ""

    @property
    def _steps(self) -> str:
        return f" (steps at a tolerance of {SURE:g})" if self.refined else ""


def accuracy_of(
    history: History,
    *,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    device: str = "cpu",
    rough: History | None = None,
    progress: Callable[[float], None] | None = None,
) -> Accuracy:
    """Run again with finer steps, and compare; ``tolerance``, ``method`` and ``device`` are those of the run.

    Parameters
    ----------
    rough
        The run with steps as asked for, in whose place ``history`` came; None where that is the one.

    Returns
    -------
    Accuracy
        What the two runs differ by (m), until and after the first loss of step, and whether the end can be foretold.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    (finer,) = _again([history], _finer(history, tolerance), method, device, None, progress)
    accuracy = _compared(history, finer)
    if rough is None:
        return accuracy
    other = accuracy.other_verdict or _other_verdict(history, rough)
    return replace(accuracy, refined=True, sensitive=_compared(rough, history).sensitive, other_verdict=other)


def refined(
    histories: Sequence[History],
    *,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[History]:
    """Make those runs again that multiply errors, at a tolerance of ``SURE``.

    ``tolerance``, ``method`` and ``device`` are those of the runs.

    Returns
    -------
    list of History
        The runs themselves, in order, and in place of each that slips or is drawn in the one with finer steps.
    """
    found = list(histories)
    places = [place for place, run in enumerate(found) if tolerance > SURE and run.heights.multiply_errors]
    if places:
        again = _again([found[place] for place in places], SURE, method, device, threads, progress)
        for place, finer in zip(places, again, strict=True):
            found[place] = finer
    return found


def _finer(history: History, tolerance: float) -> float:
    """A tolerance that shows what a run's steps miss."""
    share = FINER if uniform(system_of(history.scenario)) else FINER_NEAR_WALLS
    return max(share * tolerance, FINEST) if tolerance > FINEST else FINER * tolerance


def _again(
    histories: Sequence[History],
    tolerance: float,
    method: Method,
    device: str,
    threads: int | None,
    progress: Callable[[float], None] | None,
) -> list[History]:
    """The same runs with other steps."""
    return advance(
        [history.scenario for history in histories],
        initial_states=np.array([history.states[0] for history in histories]),
        tolerance=tolerance,
        method=method,
        device=device,
        threads=threads,
        progress=progress,
    )


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
        other_verdict=_other_verdict(history, finer),
    )


def _other_verdict(history: History, other: History) -> str | None:
    """The verdict on another run, where it is not the same."""
    ours, theirs = history.judge().verdict, other.judge().verdict
    return None if ours is theirs else str(theirs)
