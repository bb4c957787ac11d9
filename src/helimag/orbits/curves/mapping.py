"""Stability over a grid of two inputs, each orbit found from its neighbours."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits.curves.spreading import Node, OrbitGrid
from helimag.orbits.strobe import Floats, Orbit, Watch, find_orbit
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input, varied


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
        """The scenario of one node.

        Returns
        -------
        Scenario
            With both inputs as at the node.
        """
        values = float(self.values[0][i]), float(self.values[1][j])
        return varied(self.scenario, dict(zip(self.paths, values, strict=True)))


def seeds_within(
    scenario: Scenario,
    ranges: Mapping[str, tuple[float, float]],
    *,
    progress: Callable[[float], None] | None = None,
) -> list[Orbit]:
    """The scenario's own orbit, to begin a stability map from, where its inputs lie within the map's ranges.

    Parameters
    ----------
    ranges
        Lowest and highest value (SI) of each input, by path.
    progress
        Called with the fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    list of Orbit
        One, stable or not, or none where an input lies outside.
    """
    if not all(Input(path).within(scenario, low, high) for path, (low, high) in ranges.items()):
        return []
    return [find_orbit(scenario, thorough=False, progress=progress)]


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
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    StabilityMap
        Growth (1/s) and state of the orbit at each node.

    Notes
    -----
    A node counts as without an orbit where the search from its stable neighbours fails; a second stable orbit that no
    seed led to is not seen.
    """
    watch = Watch(progress)
    values = np.asarray(first[1], float), np.asarray(second[1], float)
    for path, given in zip((first[0], second[0]), values, strict=True):
        Input(path).check(scenario)
        if given.ndim != 1 or given.size < 2 or not np.all(np.diff(given) > 0.0):
            raise InputError(f"values of {path} must be at least two increasing numbers")
    inputs = Input(first[0]), Input(second[0])

    def scenario_at(node: Node) -> Scenario:
        return varied(scenario, {first[0]: float(values[0][node[0]]), second[0]: float(values[1][node[1]])})

    found = OrbitGrid(scenario_at, (values[0].size, values[1].size), length=scenario.drive.distance)
    for seed in seeds:
        if seed.stable:
            nearest = [int(np.abs(v - g.value(seed.scenario)).argmin()) for v, g in zip(values, inputs, strict=True)]
            found.plant((nearest[0], nearest[1]), seed.state, watch)
    found.seek_all_over(watch.part(0.0, 0.5))
    found.spread(watch.part(0.5, 1.0))
    watch(1.0)
    return StabilityMap(scenario, (first[0], second[0]), values, found.growth, found.swing, found.states)
