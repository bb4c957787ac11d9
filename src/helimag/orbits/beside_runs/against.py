"""Verdicts of runs over a grid of inputs beside the orbits there, with a reason for each that does not agree.

A run of finite length from one place and a stable orbit are different statements. So that neither is taken for the
other, every node where they differ is run on, and beside its orbit, and named.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, advance
from helimag.errors import InputError
from helimag.orbits.beside_runs.closed_curve import swinging
from helimag.orbits.curves import Node, OrbitGrid, StabilityMap
from helimag.orbits.strobe import Floats, Watch, open_water, require_periodic, strobed
from helimag.outcomes import End, Verdict, Why
from helimag.scenario import Scenario

LONG = 20_000.0  # s, of the runs that explain
SAMPLES = 2000
BESIDE = 0.005  # m from the orbit, of runs that ask whether it holds what comes near
MORE_SEEDS = 8  # nodes whose run stays though no stable orbit is known there, from which one is sought


@dataclass(frozen=True)
class OrbitCase:
    """A node where run and orbit differ, or where the run is undecided; ``later`` is the verdict on the longer run."""

    node: Node
    verdict: Verdict
    stable: bool
    later: Verdict | None  # None where its numbers broke down
    later_end: float
    why: Why
    note: str = ""

    @property
    def text(self) -> str:
        """What was seen."""
        kind = "stable" if self.stable else "not stable"
        note = f" ({self.note})" if self.note else ""
        later = self.later or "broken down"
        return f"run {self.verdict}, orbit {kind}; after {self.later_end:.0f} s {later}: {self.why}{note}"


@dataclass(frozen=True)
class OrbitComparison:
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
    cases: list[OrbitCase] = field(default_factory=list)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where there is a stable orbit."""
        return np.asarray(np.nan_to_num(self.growth, nan=1.0) < 0.0)

    @property
    def decided(self) -> NDArray[np.bool_]:
        """Where the run's verdict says something: drifting and undecided do not."""
        return np.asarray((self.verdicts != "") & ~_open(self.verdicts))

    @property
    def agree(self) -> NDArray[np.bool_]:
        """Decided nodes whose run stays just where the orbit is stable."""
        return np.asarray(self.decided & ((self.verdicts == str(Verdict.BOUNDED)) == self.stable))

    def share(self, *, beside: bool = False) -> float:
        """Share that agrees away from the boundary: of decided runs, or of runs beside the orbit where it is stable.

        Returns
        -------
        float
            In [0, 1]; nan of nothing.
        """
        told, counted = self._told_beside if beside else (self.agree, self.decided)
        counted = counted & self.away
        return float(told[counted].mean()) if counted.any() else float("nan")

    @property
    def _told_beside(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which nodes agree where runs beside the orbit decide if it is stable; and which count."""
        told = np.where(self.stable, self.beside, self.agree)
        return np.asarray(told, dtype=bool), np.asarray((self.stable & (self.verdicts != "")) | self.decided)

    @property
    def text(self) -> str:
        """Shares and tally."""
        drifting = int(np.count_nonzero(_open(self.verdicts)))
        tally = Counter(case.why for case in self.cases)
        lines = [
            f"{self.verdicts.size} nodes, of which {int(self.away.sum())} lie away from the boundary of stability (no "
            f"neighbour differs); {drifting} not decided by their runs",
            f"runs that agree with the orbit: {_count(self.agree, self.decided, self.away)}",
        ]
        told, counted = self._told_beside
        start = f"with runs from {1e3 * BESIDE:.0f} mm beside the orbit where it is stable"
        lines.append(f"the same {start}: {_count(told, counted, self.away)}")
        lines += [f"{count:4d} {why}: {why.text()}" for why, count in tally.most_common()]
        return "\n".join(lines)


def _open(verdicts: NDArray[np.str_]) -> NDArray[np.bool_]:
    """Where runs were inside at their ends and nothing is told of what they do then."""
    return np.isin(verdicts, [verdict for verdict in Verdict if verdict.open])


def _count(agree: NDArray[np.bool_], counted: NDArray[np.bool_], away: NDArray[np.bool_]) -> str:
    """How many of those that count agree, away from the boundary of stability and beside it."""
    parts = []
    for kind, where in (("away from the boundary", away & counted), ("beside it", ~away & counted)):
        share = f" ({100.0 * agree[where].mean():.1f} %)" if where.any() else ""
        parts.append(f"{int(agree[where].sum())} of {int(where.sum())}{share} {kind}")
    return ", ".join(parts)


def compare_with_orbits(
    scenario_at: Callable[[Node], Scenario | None],
    verdicts: NDArray[np.str_],
    *,
    progress: Callable[[float], None] | None = None,
) -> OrbitComparison:
    """Find the orbits of a grid of inputs, and set the verdicts of its runs beside them.

    Parameters
    ----------
    scenario_at
        The scenario of a node; None where there is none.
    verdicts
        Of the runs, text, of the grid's shape; empty where there is none.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    OrbitComparison
        The orbit and the case at each node, and how many agree.

    Raises
    ------
    InputError
        Where no node has a scenario, or a drive has no frame in which it repeats.
    """
    watch = Watch(progress)
    scenarios = {node: s for node in np.ndindex(verdicts.shape) if (s := scenario_at(node)) is not None}
    if not scenarios:
        raise InputError("the grid must have a node with a scenario; got none")
    for scenario in scenarios.values():
        require_periodic(scenario)
    length = next(iter(scenarios.values())).drive.distance
    found = _orbits(scenarios.get, verdicts, length, watch.part(0.0, 0.3))
    stable = found.stable
    inside = np.isin(verdicts, [verdict for verdict in Verdict if verdict.inside])
    nodes = {node: scenario for node, scenario in scenarios.items() if verdicts[node]}
    beside = np.zeros(verdicts.shape, dtype=bool)
    held = {node: scenario for node, scenario in nodes.items() if stable[node]}
    for node, stays in _stay_beside(held, found, watch.part(0.3, 0.6)).items():
        beside[node] = stays
    undecided = _open(verdicts)
    listed = {node: s for node, s in nodes.items() if undecided[node] or inside[node] != stable[node]}
    cases = _cases(listed, verdicts, found, beside, watch.part(0.6, 1.0))
    watch(1.0)
    return OrbitComparison(verdicts, found.growth, found.swing, found.states, away_from_boundary(stable), beside, cases)


def map_of(
    result: OrbitComparison, scenario: Scenario, inputs: Sequence[tuple[str, Sequence[float | str]]]
) -> StabilityMap | None:
    """The orbits of a comparison as a stability map, whose boundary can be followed.

    Parameters
    ----------
    scenario
        What the runs have in common.
    inputs
        Path and values (SI, or text) of each input that the grid runs along.

    Returns
    -------
    StabilityMap or None
        None where the grid does not run along two numbers, two increasing values of each at least.
    """
    if len(inputs) != 2 or result.verdicts.ndim != 2:
        return None
    if any(isinstance(value, str) for _, values in inputs for value in values):
        return None
    first, second = (np.asarray(values, float) for _, values in inputs)
    if min(first.size, second.size) < 2 or not all(np.all(np.diff(values) > 0.0) for values in (first, second)):
        return None
    paths = inputs[0][0], inputs[1][0]
    return StabilityMap(scenario, paths, (first, second), result.growth, result.swing, result.states)


def away_from_boundary(stable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Nodes all of whose neighbours, diagonal ones too, are of the same kind; beyond the edge nothing is known."""
    from scipy.ndimage import maximum_filter, minimum_filter

    return np.asarray(maximum_filter(stable, 3, mode="nearest") == minimum_filter(stable, 3, mode="nearest"))


def _orbits(
    scenario_at: Callable[[Node], Scenario | None],
    verdicts: NDArray[np.str_],
    length: float,
    watch: Watch,
) -> OrbitGrid:
    """Orbits spread from runs all over the grid, and from runs that stay where none is known yet."""
    found = OrbitGrid(scenario_at, verdicts.shape, length=length)
    found.seek_all_over(watch.part(0.0, 0.4))
    found.spread(watch.part(0.4, 0.8))
    sought = np.zeros(verdicts.shape, dtype=bool)
    for count in range(MORE_SEEDS):
        missing = np.argwhere((verdicts == str(Verdict.BOUNDED)) & ~found.stable & ~sought)
        if len(missing) == 0:
            break
        node = tuple(missing[len(missing) // 2].tolist())
        sought[node] = True
        part = watch.part(0.8, 1.0).turn(count, MORE_SEEDS)
        found.seek(node, part.part(0.0, 0.5))
        found.spread(part.part(0.5, 1.0))
    return found


def _stay_beside(scenarios: Mapping[Node, Scenario], found: OrbitGrid, watch: Watch) -> dict[Node, bool]:
    """Whether runs that start beside their stable orbits stay for their scenario's duration."""
    starts = np.array([found.states[node] + BESIDE * np.eye(7)[0] for node in scenarios])
    return {node: _stays(_verdict(run)) for node, run in _run(scenarios, starts, watch).items()}


def _cases(
    scenarios: Mapping[Node, Scenario],
    verdicts: NDArray[np.str_],
    found: OrbitGrid,
    beside: NDArray[np.bool_],
    watch: Watch,
) -> list[OrbitCase]:
    longer = {
        node: scenario.replaced({"run.duration": max(LONG, scenario.run.duration), "run.interval": None})
        for node, scenario in scenarios.items()
    }
    result = []
    naming = watch.part(0.6, 1.0)
    for count, (node, history) in enumerate(_run(longer, None, watch.part(0.0, 0.6)).items()):
        verdict, stable, later = Verdict.of(verdicts[node]), bool(found.stable[node]), _verdict(history)
        why = _why(verdict, stable, _stays(later), bool(beside[node]))
        note = ""
        if why is Why.OTHER:
            (run,) = strobed(history.scenario, LONG, samples=SAMPLES, progress=naming.turn(count, len(longer)))
            note = swinging(run.times, run.states[:, 2]).text
        result.append(OrbitCase(node, verdict, stable, later, float(history.time[-1]), why, note))
    return result


def _run(scenarios: Mapping[Node, Scenario], starts: Floats | None, watch: Watch) -> dict[Node, History]:
    """Runs in open water from starts (n, 7), by default the scenarios' own."""
    if not scenarios:
        return {}
    histories = advance([open_water(each) for each in scenarios.values()], initial_states=starts, progress=watch)
    return dict(zip(scenarios, histories, strict=True))


def _verdict(history: History) -> Verdict | None:
    return None if history.status is End.NOT_FINITE else history.judge().verdict


def _stays(verdict: Verdict | None) -> bool:
    """Whether a run is still inside at its end; one whose numbers broke down is not."""
    return verdict is not None and verdict.inside


def _why(verdict: Verdict, stable: bool, stays: bool, beside: bool) -> Why:
    """The reason, from what the run did at its horizon, what it does later, and what a run beside the orbit does."""
    if stable and not beside:
        return Why.UNEXPLAINED
    if stable and not stays:
        return Why.BASIN
    if not stable and stays:
        return Why.OTHER
    if verdict.open:
        return Why.SLOW_DRIFT
    return Why.SOON if stable else Why.SHORT
