"""Where stability ends over two inputs, as curves: folds, Neimark-Sacker points and period doublings followed exactly.

The curves' method is in :mod:`helimag.orbits.curves.tracing`; here are their beginnings, from a map of stability.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from helimag.orbits.curves.branch import Change, Event
from helimag.orbits.curves.continuation import follow
from helimag.orbits.curves.crossings import DOUBLE_ONE, FOLD_WITH_SWING, UNNAMED, Crossing, OneReal, Pair
from helimag.orbits.curves.mapping import StabilityMap
from helimag.orbits.curves.tracing import FAILED, Family, Node, Place, Trace, advanced, on_curve, trace
from helimag.orbits.strobe import Floats, Problem, Solved, Watch, chart, classify, find_orbit
from helimag.outcomes import OrbitStatus
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input, varied

SAME_POINT = 4e-3  # of the ranges: an event this near a curve of its kind, with such an orbit, lies on it
SAME_ORBIT = 0.4  # of the distance and in radians, between orbits of one curve and of a node beside it
ASIDE = 2e-3  # of arclength, from a codimension-two point to where the curve of the other kind is begun
ON_LINE = 1e-9  # of the ranges
UNTRACED = "not traced"


@dataclass(frozen=True)
class BoundaryCurve:
    """A curve in the plane of two inputs where a stable orbit loses stability.

    Attributes
    ----------
    scenario, paths
        Whose orbits, and the two inputs; the scenario's own values of these do not matter.
    kind
        What happens there.
    first, second
        (n,) values of the inputs, SI, in order along the curve.
    states
        (n, 7): orbits at the boundary, moving frame.
    swing
        (n,) imaginary part of the critical rate, 1/s.
    ends
        Why the curve stops at its first and last point: ``"edge of the map"``, ``"closed"``, the name of a
        codimension-two point beyond which it bounds no stable orbit, or what hindered the search.
    """

    scenario: Scenario
    paths: tuple[str, str]
    kind: Change
    first: Floats
    second: Floats
    states: Floats
    swing: Floats
    ends: tuple[str, str]


def boundary_of(result: StabilityMap, *, progress: Callable[[float], None] | None = None) -> list[BoundaryCurve]:
    """The exact boundary of a stability map: every curve on which a node's stable orbit loses stability.

    Parameters
    ----------
    result
        A map, coarse or fine: it gives the ranges, and a beginning of each curve between two neighbours of which one
        has a stable orbit and the other has not.
    progress
        Called with the fraction of such pairs dealt with, some times a second. What it raises stops the search.

    Returns
    -------
    list of BoundaryCurve
        In the order found. A change of stability that cannot be followed (a branch point) is a curve of one point.
        Where orbits end for another reason, such as walls, there is no curve.

    Notes
    -----
    A curve that passes between no two nodes, and ends at none that does, is not seen.
    """
    watch = Watch(progress)
    family = _Orbits(result, watch)
    curves: list[BoundaryCurve] = []
    traces: list[tuple[Change, Trace]] = []
    edges = list(_edges(result))
    for count, (node, axis, sense) in enumerate(edges):
        if not any(_divides(family, traced, node, axis, sense) for _, traced in traces):
            event = _event(result, node, axis, sense, watch.turn(count, len(edges)))
            if event is not None:
                _follow(family, event, traces, curves)
        watch((count + 1) / len(edges))
    watch(1.0)
    return curves


class _Orbits:
    """One-period maps over both inputs of a stability map, as :mod:`helimag.orbits.curves.tracing` takes them."""

    def __init__(self, result: StabilityMap, watch: Watch) -> None:
        self.result, self._watch = result, watch
        self.inputs = Input(result.paths[0]), Input(result.paths[1])
        self.low = np.array([values[0] for values in result.values])
        self.span = np.array([values[-1] - values[0] for values in result.values])
        self.length = np.array([result.scenario.drive.distance])
        self._packed: tuple[bytes, Problem] | None = None

    def scenario_at(self, shares: Floats) -> Scenario:
        values = (self.low + shares * self.span).tolist()
        return varied(self.result.scenario, dict(zip(self.result.paths, values, strict=True)))

    def place_of(self, event: Event) -> Place:
        values = np.array([given.value(event.orbit.scenario) for given in self.inputs])
        return Place(event.orbit.state, (values - self.low) / self.span)

    def moved(self, place: Place, by: Floats) -> Place:
        return Place(chart.moved(place.state[None], by[None, :6], self.length)[0], place.shares + by[6:])

    def offset(self, place: Place, to: Place) -> Floats:
        return np.append(chart.coordinates(to.state[None], place.state[None], self.length)[0], to.shares - place.shares)

    def images(self, place: Place, offsets: Floats) -> Floats:
        drives, which = np.unique(offsets[:, 6:], axis=0, return_inverse=True)
        problem = self._problem(place.shares + drives)
        length = np.repeat(self.length, len(offsets))
        around = np.broadcast_to(place.state, (len(offsets), 7))
        # as many steps for all, so that differences see the map and not its error
        steps = np.full(len(offsets), problem.steps(which[:1], place.state[None])[0])
        states = chart.moved(around, offsets[:, :6], length)
        begin = np.zeros(len(offsets))
        images, _ = problem.advance(which, states, steps, begin, begin + 1.0)
        return chart.coordinates(images, around, length)

    def refused(self, place: Place) -> str | None:
        problem = self._problem(place.shares[None])
        one, state = np.zeros(1, dtype=np.int64), place.state[None]
        _, measures = problem.map(one, state)
        nothing = np.zeros((1, 6, 6))
        (status,) = classify(problem, one, Solved(one == 0, state, np.zeros(1), nothing, measures, one))
        return None if status is OrbitStatus.FOUND else str(status)

    def _problem(self, shares: Floats) -> Problem:
        """Packed once for the calls that want the same drives in turn."""
        if self._packed is None or self._packed[0] != shares.tobytes():
            scenarios = [self.scenario_at(each) for each in shares]
            self._packed = shares.tobytes(), Problem(scenarios, watch=self._watch)
        return self._packed[1]


def _edges(result: StabilityMap) -> Iterator[tuple[tuple[int, int], int, int]]:
    """Stable nodes beside which, a step along an axis in a sense, there is no stable one."""
    stable = result.stable
    for i, j in np.argwhere(stable).tolist():
        for axis, sense in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside = (i + sense, j) if axis == 0 else (i, j + sense)
            if 0 <= beside[axis] < stable.shape[axis] and not stable[beside]:
                yield (i, j), axis, sense


def _divides(family: _Orbits, traced: Trace, node: tuple[int, int], axis: int, sense: int) -> bool:
    """Whether a curve passes between a node and its neighbour, with orbits like the node's."""
    grid = [values[k] for values, k in zip(family.result.values, node, strict=True)]
    at = (np.array(grid) - family.low) / family.span
    step = (family.result.values[axis][node[axis] + sense] - grid[axis]) / family.span[axis]
    shares = np.array([point.place.shares for point in traced.nodes])
    aside = shares[:, 1 - axis] - at[1 - axis]
    # a curve that ends on the line, as at the edge of the map, passes too
    for k in np.flatnonzero((aside[:-1] * aside[1:] <= ON_LINE**2) & (aside[:-1] != aside[1:])):
        part = np.clip(aside[k] / (aside[k] - aside[k + 1]), 0.0, 1.0)
        along = (1.0 - part) * shares[k, axis] + part * shares[k + 1, axis]
        way = float(along - at[axis]) / step
        if -0.05 <= way <= 1.05 and _alike(family, traced.nodes[k].place, family.result.states[node]):
            return True
    return False


def _alike(family: _Orbits, place: Place, state: Floats) -> bool:
    away = chart.coordinates(state[None], place.state[None], family.length)
    return bool(np.linalg.norm(away) < SAME_ORBIT)


def _event(result: StabilityMap, node: tuple[int, int], axis: int, sense: int, watch: Watch) -> Event | None:
    """The change of stability met first from a stable node along one input."""
    orbit = find_orbit(result.scenario_at(*node), near=result.states[node], progress=watch.part(0.0, 0.1))
    if not orbit.stable:
        return None
    values = result.values[axis]
    far = int(np.clip(node[axis] + sense * max(8, values.size // 4), 0, values.size - 1))
    low, high = sorted((float(values[node[axis]]), float(values[far])))
    branch = follow(orbit, result.paths[axis], low, high, while_stable=True, progress=watch.part(0.1, 0.9))
    end = branch.ends[1 if sense > 0 else 0]
    return next((event for event in branch.events if event.kind == end), None)


def _follow(family: _Orbits, event: Event, traces: list[tuple[Change, Trace]], curves: list[BoundaryCurve]) -> None:
    """Trace the curve through an event, and those that begin where it ends; add what is new."""
    place = family.place_of(event)
    crossing = _crossing(event)
    first = None if crossing is None else on_curve(family, crossing, place)
    if first is None or first.loss >= 0.0:
        why = UNTRACED if crossing is None else FAILED if first is None else UNNAMED
        curves.append(_single(family, event, place, why))
        return
    waiting = [first]
    while waiting:
        first = waiting.pop()
        kind = first.crossing.kind
        if any(_lies_on(family, traced, first.place) for known, traced in traces if known is kind):
            continue
        traced = trace(family, first)
        traces.append((kind, traced))
        curves.append(_curve(family, traced))
        for node, name in zip((traced.nodes[0], traced.nodes[-1]), traced.ends, strict=True):
            waiting += others_from(family, node, name)


def _crossing(event: Event) -> Crossing | None:
    if event.kind is Change.FOLD:
        return OneReal.near(event.orbit.jacobian, 1.0)
    if event.kind is Change.PERIOD_DOUBLING:
        return OneReal.near(event.orbit.jacobian, -1.0)
    if event.kind is Change.NEIMARK_SACKER:
        return Pair(event.swing / abs(event.orbit.scenario.drive.frequency))
    return None


def others_from(family: Family, node: Node, name: str) -> list[Node]:
    """Where a curve of the other kind begins beside a codimension-two point of folds and swings."""
    if name not in (DOUBLE_ONE, FOLD_WITH_SWING):
        return []
    if node.crossing.kind is Change.FOLD:
        values = np.linalg.eigvals(node.jacobian)
        swings = values[np.abs(values.imag) > 0.0]
        swing = 0.0 if name == DOUBLE_ONE else float(abs(np.angle(swings[np.argmax(np.abs(swings))])))
        crossing: Crossing = Pair(swing)
    else:
        crossing = OneReal.near(node.jacobian, 1.0)
    middle = on_curve(family, crossing, node.place)
    if middle is None:
        return []
    beside = [advanced(family, middle, step) for step in (ASIDE, -ASIDE)]
    return [
        each for each in beside if each is not None and each.loss < 0.0 and np.all(abs(each.place.shares - 0.5) < 0.5)
    ]


def _lies_on(family: _Orbits, traced: Trace, place: Place) -> bool:
    """Whether a place is a point of a curve."""
    shares = np.array([point.place.shares for point in traced.nodes])
    begins, ways = shares[:-1], np.diff(shares, axis=0)
    if not len(begins):
        return False
    part = np.clip(np.sum((place.shares - begins) * ways, axis=1) / np.maximum(np.sum(ways**2, axis=1), 1e-300), 0, 1)
    away = np.linalg.norm(begins + part[:, None] * ways - place.shares, axis=1)
    return any(_alike(family, traced.nodes[k].place, place.state) for k in np.flatnonzero(away < SAME_POINT))


def _curve(family: _Orbits, traced: Trace) -> BoundaryCurve:
    shares = np.array([node.place.shares for node in traced.nodes])
    values = family.low + shares * family.span
    periods = [1.0 / abs(family.scenario_at(each).drive.frequency) for each in shares]
    angles = [node.crossing.angle for node in traced.nodes]
    states = np.array([node.place.state for node in traced.nodes])
    return BoundaryCurve(
        scenario=family.result.scenario,
        paths=family.result.paths,
        kind=traced.nodes[0].crossing.kind,
        first=values[:, 0],
        second=values[:, 1],
        states=states,
        swing=np.array(angles) / np.array(periods),
        ends=traced.ends,
    )


def _single(family: _Orbits, event: Event, place: Place, why: str) -> BoundaryCurve:
    """A change of stability that is no curve."""
    first, second = (family.low + place.shares * family.span)[:, None]
    swing = np.array([event.swing])
    return BoundaryCurve(
        family.result.scenario,
        family.result.paths,
        event.kind,
        first,
        second,
        event.orbit.state[None],
        swing,
        (why, why),
    )
