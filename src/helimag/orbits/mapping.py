"""Stability over a grid of two inputs, each orbit found from its neighbours."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits import _chart as chart
from helimag.orbits._floquet import multipliers_of, rates_of
from helimag.orbits._inputs import Input
from helimag.orbits._newton import solve
from helimag.orbits._problem import Floats, Problem
from helimag.orbits.find import classify, find_orbit
from helimag.orbits.orbit import Orbit, OrbitStatus
from helimag.scenario import Scenario

ITERATIONS = 12  # evaluations a point; a neighbour's orbit needs three or four
ATTEMPTS = 4  # from different neighbours
SEEDS = (3, 3)  # nodes of the grid from which orbits are also sought where a run leads


@dataclass(frozen=True)
class StabilityMap:
    """Orbits over a grid: arrays (n, m) for n values of the first input and m of the second.

    Attributes
    ----------
    growth
        Real part of the leading rate (1/s), nan where no orbit was found: stable where negative.
    swing
        Imaginary part of the leading rate (1/s).
    states
        (n, m, 7): orbits in the moving frame.
    """

    scenario: Scenario
    paths: tuple[str, str]
    values: tuple[Floats, Floats]
    growth: Floats
    swing: Floats
    states: Floats

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether a stable orbit was found."""
        return np.nan_to_num(self.growth, nan=1.0) < 0.0

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether any orbit was found."""
        return np.isfinite(self.growth)

    def scenario_at(self, i: int, j: int) -> Scenario:
        """The scenario of one node."""
        first = Input(self.paths[0]).changed(self.scenario, float(self.values[0][i]))
        return Input(self.paths[1]).changed(first, float(self.values[1][j]))


def stability_map(
    scenario: Scenario,
    first: tuple[str, Sequence[float] | Floats],
    second: tuple[str, Sequence[float] | Floats],
    *,
    seeds: Sequence[Orbit] = (),
    progress: Callable[[float], None] | None = None,
) -> StabilityMap:
    """Find the stable orbit at every node of a grid of two inputs, spreading from where one is known.

    Parameters
    ----------
    first, second
        Path and increasing values (SI) of each input.
    seeds
        Stable orbits within the grid to begin from, besides those that runs lead to at a few nodes.
    progress
        Called with the fraction of nodes visited.

    Notes
    -----
    A node counts as without an orbit where the search from its stable neighbours fails; a second stable orbit that no
    seed led to is not seen.
    """
    values = np.asarray(first[1], float), np.asarray(second[1], float)
    for path, given in zip((first[0], second[0]), values, strict=True):
        Input(path).value(scenario)
        if given.ndim != 1 or given.size < 2 or not np.all(np.diff(given) > 0.0):
            raise InputError(f"values of {path} must be at least two increasing numbers")
    front = _Front(scenario, (first[0], second[0]), values)
    for seed in seeds:
        front.plant(seed, front.node_of(seed.scenario))
    for i in np.unique(np.linspace(0, values[0].size - 1, SEEDS[0] + 2).round().astype(int)[1:-1]):
        for j in np.unique(np.linspace(0, values[1].size - 1, SEEDS[1] + 2).round().astype(int)[1:-1]):
            if not front.stable[i, j]:
                front.plant(find_orbit(front.scenario_at(i, j), thorough=False), (int(i), int(j)))
    front.spread(progress or (lambda _: None))
    return StabilityMap(scenario, (first[0], second[0]), values, front.growth, front.swing, front.states)


class _Front:
    """Orbits known so far, and the nodes beside them that are next."""

    def __init__(self, scenario: Scenario, paths: tuple[str, str], values: tuple[Floats, Floats]) -> None:
        self.base, self.values = scenario, values
        self.inputs = Input(paths[0]), Input(paths[1])
        shape = values[0].size, values[1].size
        self.growth, self.swing = np.full(shape, np.nan), np.full(shape, np.nan)
        self.states = np.full((*shape, 7), np.nan)
        self.attempts = np.zeros(shape, dtype=int)
        self.fresh: list[tuple[int, int]] = []
        self.rows = [self.inputs[0].changed(scenario, float(value)) for value in values[0]]

    @property
    def stable(self) -> NDArray[np.bool_]:
        return np.asarray(np.nan_to_num(self.growth, nan=1.0) < 0.0)

    def scenario_at(self, i: int, j: int) -> Scenario:
        return self.inputs[1].changed(self.rows[i], float(self.values[1][j]))

    def node_of(self, scenario: Scenario) -> tuple[int, int]:
        nearest = (int(np.abs(v - g.value(scenario)).argmin()) for v, g in zip(self.values, self.inputs, strict=True))
        return next(nearest), next(nearest)

    def plant(self, seed: Orbit, node: tuple[int, int]) -> None:
        """Take a stable orbit to the node, if it leads to one there."""
        if seed.stable:
            self._attempt([node], seed.state[None])

    def spread(self, report: Callable[[float], None]) -> None:
        """Go from stable nodes to their neighbours until no more are stable; a node is tried from several of them."""
        waiting: dict[tuple[int, int], list[Floats]] = {}
        while self.fresh or waiting:
            for i, j in self.fresh:
                for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                    node = i + step[0], j + step[1]
                    if self._open(node):
                        waiting.setdefault(node, []).append(self._guess((i, j), step))
            self.fresh = []
            waiting = {node: guesses for node, guesses in waiting.items() if guesses and self._open(node)}
            if waiting:
                self._attempt(list(waiting), np.array([guesses.pop(0) for guesses in waiting.values()]))
            report(float(np.count_nonzero(self.attempts)) / self.attempts.size)

    def _open(self, node: tuple[int, int]) -> bool:
        i, j = node
        inside = 0 <= i < self.values[0].size and 0 <= j < self.values[1].size
        return inside and not self.growth[node] < 0.0 and bool(self.attempts[node] < ATTEMPTS)

    def _guess(self, at: tuple[int, int], step: tuple[int, int]) -> Floats:
        """The neighbour's orbit, carried on along the line from the one behind it where that is known."""
        behind = at[0] - step[0], at[1] - step[1]
        known = 0 <= behind[0] < self.values[0].size and 0 <= behind[1] < self.values[1].size
        state: Floats = self.states[at]
        if not known or not self.growth[behind] < 0.0:
            return state
        length = np.array([self.base.drive.distance])
        change = -chart.coordinates(self.states[behind][None], state[None], length)
        return np.asarray(chart.moved(state[None], change, length)[0])

    def _attempt(self, nodes: list[tuple[int, int]], starts: Floats) -> None:
        problem = Problem([self.scenario_at(i, j) for i, j in nodes])
        which = np.arange(len(nodes))
        solved = solve(problem, which, starts, iterations=ITERATIONS)
        status = classify(problem, which, solved)
        rates = np.full((len(nodes), 6), np.nan, dtype=np.complex128)
        good = np.array([s is OrbitStatus.FOUND for s in status])
        if good.any():
            rates[good] = rates_of(multipliers_of(solved.jacobian[good]), problem.period[good])
        for k, node in enumerate(nodes):
            self.attempts[node] += 1
            if not good[k]:
                continue
            lead = rates[k][np.argmax(rates[k].real)]
            if np.isnan(self.growth[node]) or lead.real < 0.0:
                self.growth[node], self.swing[node] = lead.real, abs(lead.imag)
                self.states[node] = solved.states[k]
            if lead.real < 0.0:
                self.fresh.append(node)
