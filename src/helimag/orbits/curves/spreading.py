"""Orbits at the nodes of a grid of any dimension: from one that is known on to its neighbours while they are stable."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from helimag.orbits.strobe import Floats, Problem, Watch, chart, classify, find_orbit, multipliers_of, rates_of, solve
from helimag.outcomes import OrbitStatus
from helimag.scenario import Scenario

Node = tuple[int, ...]

ITERATIONS = 12  # evaluations a point; a neighbour's orbit needs three or four
ATTEMPTS = 4  # from different neighbours
SEEDS_A_SIDE = 3  # nodes at which runs are made to find a first orbit


class OrbitGrid:
    """Orbits known so far at the nodes of a grid; ``length`` (m) is the scale that guesses are extrapolated in.

    Attributes
    ----------
    growth, swing
        Real and unsigned imaginary part of the leading rate (1/s), of the grid's shape; nan where no orbit is known.
    states
        (..., 7), moving frame.
    """

    def __init__(
        self, scenario_at: Callable[[Node], Scenario | None], shape: tuple[int, ...], *, length: float
    ) -> None:
        self.scenario_at, self.shape = scenario_at, shape
        self._length = np.array([length])
        self.growth, self.swing = np.full(shape, np.nan), np.full(shape, np.nan)
        self.states = np.full((*shape, 7), np.nan)
        self.attempts = np.zeros(shape, dtype=int)
        self._fresh: list[Node] = []

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where a stable orbit is known."""
        return np.asarray(np.nan_to_num(self.growth, nan=1.0) < 0.0)

    def plant(self, node: Node, state: Floats, watch: Watch) -> None:
        """Take a state (7,) to the orbit at a node, if it leads to one there."""
        self._attempt([node], state[None], watch)

    def seek(self, node: Node, watch: Watch, *, thorough: bool = False) -> None:
        """Make a run at a node, and look for the orbit that it leads to; ``thorough`` searches a grid of starts too."""
        scenario = self.scenario_at(node)
        if scenario is None or self.stable[node]:
            return
        seed = find_orbit(scenario, thorough=thorough, progress=watch.part(0.0, 0.9))
        if seed.stable:
            self.plant(node, seed.state, watch)

    def seek_all_over(self, watch: Watch) -> None:
        """Seek at nodes spread over the grid; where the runs there lead to nothing stable, on grids of starts too."""
        lines = [
            np.unique(np.linspace(0, n - 1, SEEDS_A_SIDE + 2).round().astype(int)[1:-1]).tolist() for n in self.shape
        ]
        nodes = list(product(*lines))
        for thorough, half in ((False, watch.turn(0, 2)), (True, watch.turn(1, 2))):
            for count, node in enumerate(nodes):
                self.seek(node, half.turn(count, len(nodes)), thorough=thorough)
            if self.stable.any():
                return

    def spread(self, watch: Watch) -> None:
        """Go from stable nodes to their neighbours until no more are stable; a node is tried from several of them."""
        waiting: dict[Node, list[Floats]] = {}
        while self._fresh or waiting:
            for at in self._fresh:
                for axis, sense in product(range(len(self.shape)), (1, -1)):
                    node = _beside(at, axis, sense)
                    if self._open(node):
                        waiting.setdefault(node, []).append(self._guess(at, _beside(at, axis, -sense)))
            self._fresh = []
            waiting = {node: guesses for node, guesses in waiting.items() if guesses and self._open(node)}
            if waiting:
                self._attempt(list(waiting), np.array([guesses.pop(0) for guesses in waiting.values()]), watch)
            watch(float(np.count_nonzero(self.attempts)) / self.attempts.size)

    def _inside(self, node: Node) -> bool:
        return all(0 <= i < n for i, n in zip(node, self.shape, strict=True))

    def _open(self, node: Node) -> bool:
        return self._inside(node) and not self.growth[node] < 0.0 and bool(self.attempts[node] < ATTEMPTS)

    def _guess(self, at: Node, behind: Node) -> Floats:
        """The neighbour's orbit, carried on along the line from the one behind it where that is known."""
        state: Floats = self.states[at]
        if not self._inside(behind) or not self.growth[behind] < 0.0:
            return state
        change = -chart.coordinates(self.states[behind][None], state[None], self._length)
        return np.asarray(chart.moved(state[None], change, self._length)[0])

    def _attempt(self, nodes: list[Node], starts: Floats, watch: Watch) -> None:
        """Search at nodes from starts (n, 7), all at once."""
        batch: list[tuple[Node, Scenario, Floats]] = []
        for node, start in zip(nodes, starts, strict=True):
            self.attempts[node] += 1
            scenario = self.scenario_at(node)
            watch.pulse()
            if scenario is not None:
                batch.append((node, scenario, start))
        if batch:
            tried, scenarios, begun = zip(*batch, strict=True)
            self._solve(tried, Problem(scenarios, watch=watch.unmeasured()), np.array(begun))

    def _solve(self, nodes: Sequence[Node], problem: Problem, starts: Floats) -> None:
        which = np.arange(len(nodes))
        solved = solve(problem, which, starts, iterations=ITERATIONS)
        status = classify(problem, which, solved)
        good = np.flatnonzero([s is OrbitStatus.FOUND for s in status])
        if good.size == 0:
            return
        rates = rates_of(multipliers_of(solved.jacobian[good]), problem.period[good])
        for k, rate in zip(good.tolist(), rates, strict=True):
            node, lead = nodes[k], rate[np.argmax(rate.real)]
            if np.isnan(self.growth[node]) or lead.real < 0.0:
                self.growth[node], self.swing[node] = lead.real, abs(lead.imag)
                self.states[node] = solved.states[k]
            if lead.real < 0.0:
                self._fresh.append(node)


def _beside(node: Node, axis: int, sense: int) -> Node:
    return (*node[:axis], node[axis] + sense, *node[axis + 1 :])
