"""Verdicts of runs over a grid of inputs beside the orbits there, with a reason for each that does not agree.

A run of finite length from one place and a stable orbit are different statements. So that neither is taken for the
other, every node where they differ is run on, and beside its orbit, and named.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from helimag.gain import Verdict
from helimag.orbits._problem import Floats, require_periodic
from helimag.orbits._starts import strobed
from helimag.orbits.closed_curve import swinging
from helimag.orbits.spreading import Node, Spread
from helimag.scenario import Scenario
from helimag.simulation import advance

LONG = 20_000.0  # s, of the runs that explain
SAMPLES = 2000
BESIDE = 0.005  # m from the orbit, of runs that ask whether it holds what comes near
MORE_SEEDS = 8  # nodes whose run stays though no stable orbit is known there, from which one is sought
INSIDE = (Verdict.BOUNDED, Verdict.DRIFTING)


class Why(StrEnum):
    """Why a run and the orbit of its inputs do not say the same."""

    BASIN = "starts outside the basin"
    SLOW_DRIFT = "slow drift"
    SHORT = "horizon too short"
    SOON = "judged too soon"
    OTHER = "other attractor"
    UNEXPLAINED = "not explained"

    @property
    def meaning(self) -> str:
        """In a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Why.BASIN: "the orbit is stable and a run beside it stays, but from the start the run leaves",
    Why.SLOW_DRIFT: "the run had not settled at its horizon; taken on, it does what the orbit says",
    Why.SHORT: "no stable orbit, and taken on the run leaves",
    Why.SOON: "judged to have left, but taken on it comes back to the stable orbit",
    Why.OTHER: "no stable orbit is known, and the run stays all the same",
    Why.UNEXPLAINED: "the orbit is stable, but a run beside it leaves",
}


@dataclass(frozen=True)
class Case:
    """A node where run and orbit differ, or where the run is undecided."""

    node: Node
    verdict: Verdict
    stable: bool
    later: Verdict
    later_end: float
    why: Why
    note: str = ""

    @property
    def text(self) -> str:
        """What was seen."""
        kind = "stable" if self.stable else "not stable"
        note = f" ({self.note})" if self.note else ""
        return f"run {self.verdict}, orbit {kind}; after {self.later_end:.0f} s {self.later}: {self.why}{note}"


@dataclass(frozen=True)
class Comparison:
    """Runs of a grid against its orbits. Arrays of the grid's shape.

    Attributes
    ----------
    verdicts
        Text of each :class:`helimag.Verdict`; empty where there is none.
    growth, swing
        Leading rate (1/s) of the orbit, real and unsigned imaginary part, nan where none is known: stable if negative.
    states
        (..., 7): orbits, moving frame.
    away
        Nodes none of whose neighbours, diagonal ones too, differs in stability.
    beside
        Whether a run that starts 5 mm beside the stable orbit stays for the runs' own duration; False elsewhere.
    cases
        All nodes that differ, and all undecided ones.
    """

    verdicts: NDArray[np.str_]
    growth: Floats
    swing: Floats
    states: Floats
    away: NDArray[np.bool_]
    beside: NDArray[np.bool_]
    cases: list[Case] = field(default_factory=list)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where there is a stable orbit."""
        return np.asarray(np.nan_to_num(self.growth, nan=1.0) < 0.0)

    @property
    def decided(self) -> NDArray[np.bool_]:
        """Where the run's verdict says something: drifting does not."""
        return np.asarray((self.verdicts != "") & (self.verdicts != str(Verdict.DRIFTING)))

    @property
    def agree(self) -> NDArray[np.bool_]:
        """Decided nodes whose run stays just where the orbit is stable."""
        return np.asarray(self.decided & ((self.verdicts == str(Verdict.BOUNDED)) == self.stable))

    def share(self, *, beside: bool = False) -> float:
        """Share that agrees away from the boundary: of decided runs, or of runs beside the orbit where it is stable."""
        if beside:
            told = np.where(self.stable, self.beside, self.agree)
            counted = self.away & (self.stable | self.decided)
        else:
            told, counted = self.agree, self.away & self.decided
        return float(told[counted].mean()) if counted.any() else float("nan")

    @property
    def text(self) -> str:
        """Shares and tally."""
        drifting = int(np.count_nonzero(self.verdicts == str(Verdict.DRIFTING)))
        tally = Counter(case.why for case in self.cases)
        lines = [
            f"{self.verdicts.size} nodes, {int(self.away.sum())} away from the boundary of stability, "
            f"{drifting} undecided (drifting)",
            f"decided runs agree with the orbit at {100.0 * self.share():.1f} % of those away from the boundary",
            f"runs that start {1e3 * BESIDE:.0f} mm beside the orbit, where it is stable: "
            f"{100.0 * self.share(beside=True):.1f} %",
        ]
        lines += [f"{count:4d} {why}: {why.meaning}" for why, count in tally.most_common()]
        return "\n".join(lines)


def compare_with_orbits(
    scenario_at: Callable[[Node], Scenario | None],
    verdicts: NDArray[np.str_],
    *,
    progress: Callable[[float], None] | None = None,
) -> Comparison:
    """Find the orbits of a grid of inputs, and set the verdicts of its runs beside them.

    Parameters
    ----------
    scenario_at
        The scenario of a node; None where there is none.
    verdicts
        Of the runs, text, of the grid's shape; empty where there is none.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        Where a drive has no frame in which it repeats.
    """
    report = progress or (lambda _: None)
    first = next(s for s in map(scenario_at, np.ndindex(verdicts.shape)) if s is not None)
    require_periodic(first)
    found = _orbits(scenario_at, verdicts, first.drive.distance, lambda done: report(0.3 * done))
    stable = found.stable
    inside = np.isin(verdicts, [str(verdict) for verdict in INSIDE])
    nodes = [node for node in np.ndindex(verdicts.shape) if verdicts[node] and scenario_at(node) is not None]
    beside = np.zeros(verdicts.shape, dtype=bool)
    held = [node for node in nodes if stable[node]]
    beside[tuple(np.array(held).T)] = _stay_beside(scenario_at, held, found, lambda done: report(0.3 + 0.3 * done))
    drifting = verdicts == str(Verdict.DRIFTING)
    listed = [node for node in nodes if drifting[node] or inside[node] != stable[node]]
    cases = _cases(scenario_at, listed, verdicts, found, beside, lambda done: report(0.6 + 0.4 * done))
    return Comparison(verdicts, found.growth, found.swing, found.states, away_from_boundary(stable), beside, cases)


def away_from_boundary(stable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Nodes all of whose neighbours, diagonal ones too, are of the same kind; beyond the edge nothing is known."""
    from scipy.ndimage import maximum_filter, minimum_filter

    return np.asarray(maximum_filter(stable, 3, mode="nearest") == minimum_filter(stable, 3, mode="nearest"))


def _orbits(
    scenario_at: Callable[[Node], Scenario | None],
    verdicts: NDArray[np.str_],
    length: float,
    report: Callable[[float], None],
) -> Spread:
    """Orbits spread from runs all over the grid, and from runs that stay where none is known yet."""
    found = Spread(scenario_at, verdicts.shape, length=length)
    found.seek_all_over()
    found.spread(report)
    for _ in range(MORE_SEEDS):
        missing = np.argwhere((verdicts == str(Verdict.BOUNDED)) & ~found.stable & (found.attempts < 100))
        if len(missing) == 0:
            break
        node = tuple(missing[len(missing) // 2].tolist())
        found.seek(node)
        found.attempts[node] = 100  # sought here: not again
        found.spread(report)
    return found


def _stay_beside(
    scenario_at: Callable[[Node], Scenario | None], nodes: list[Node], found: Spread, report: Callable[[float], None]
) -> list[bool]:
    """Whether runs that start beside their stable orbits stay for their scenario's duration."""
    scenarios = [scenario for node in nodes if (scenario := scenario_at(node)) is not None]
    if not scenarios:
        return []
    starts = np.array([found.states[node] + BESIDE * np.eye(7)[0] for node in nodes])
    return [h.judge().verdict in INSIDE for h in advance(scenarios, initial_states=starts, progress=report)]


def _cases(
    scenario_at: Callable[[Node], Scenario | None],
    nodes: list[Node],
    verdicts: NDArray[np.str_],
    found: Spread,
    beside: NDArray[np.bool_],
    report: Callable[[float], None],
) -> list[Case]:
    result = []
    longer = [
        scenario.replaced({"run.duration": max(LONG, scenario.run.duration), "run.interval": None})
        for node in nodes
        if (scenario := scenario_at(node)) is not None
    ]
    histories = advance(longer, progress=report) if longer else []
    for node, history in zip(nodes, histories, strict=True):
        verdict, stable = Verdict(verdicts[node]), bool(found.stable[node])
        later = history.judge()
        why = _why(verdict, stable, later.verdict in INSIDE, bool(beside[node]))
        note = ""
        if why is Why.OTHER:
            (run,) = strobed(history.scenario, LONG, samples=SAMPLES)
            note = swinging(run.times, run.states[:, 2]).text
        result.append(Case(node, verdict, stable, later.verdict, later.end_time, why, note))
    return result


def _why(verdict: Verdict, stable: bool, stays: bool, beside: bool) -> Why:
    """The reason, from what the run did at its horizon, what it does later, and what a run beside the orbit does."""
    if stable and not beside:
        return Why.UNEXPLAINED
    if stable and not stays:
        return Why.BASIN
    if not stable and stays:
        return Why.OTHER
    if verdict is Verdict.DRIFTING:
        return Why.SLOW_DRIFT
    return Why.SOON if stable else Why.SHORT
