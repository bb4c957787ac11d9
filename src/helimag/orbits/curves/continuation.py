"""Follow an orbit through one input by pseudo-arclength, round folds too, and locate where its stability changes.

H. B. Keller, in: Applications of Bifurcation Theory, Academic Press 1977, 359; Y. A. Kuznetsov, Elements of Applied
Bifurcation Theory, 3rd ed., Springer 2004, ch. 4 and 10.
"""

from collections.abc import Callable

import numpy as np

from helimag.errors import InputError
from helimag.orbits.curves.branch import Branch, Change, Event, Point
from helimag.orbits.strobe import Floats, Measured, Orbit, Problem, Solved, Watch, chart, classify, orbits_of
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input

FIRST_STEP = 0.02  # of arclength: shares of the input's range, of the distance, radians
LONGEST_STEP = 0.06
SHORTEST_STEP = 1e-6
MOST_POINTS = 400
TURN = 0.98  # least cosine between tangents one step apart, so that a whole branch can be drawn
LOCATED = 1e-5  # of the input's range: how well a change of stability is located
CORRECTED = 1e-8
CORRECTIONS = 6
SLOPE_STRIDE = 1e-5  # of the input's range, for the map's derivative with respect to it


class _Curve:
    """The equations ``map(x; p) = x`` with the input p as a seventh unknown, over its range."""

    def __init__(self, scenario: Scenario, given: Input, low: float, high: float, watch: Watch) -> None:
        self.scenario, self.given, self.low, self.span = scenario, given, low, high - low
        self.watch = watch
        self.length = np.array([scenario.drive.distance])

    def scenario_at(self, share: float) -> Scenario:
        return self.given.changed(self.scenario, self.low + share * self.span)

    def evaluate(self, state: Floats, share: float) -> tuple[Problem, Floats, Floats, Floats, Measured]:
        """Problem, residual (6,), its Jacobian (6, 6), its slope over the input (6,), and measures."""
        scenarios = [self.scenario_at(share + by) for by in (0.0, SLOPE_STRIDE, -SLOPE_STRIDE)]
        problem = Problem(scenarios, watch=self.watch)
        problem.length[:] = self.length
        one = np.zeros(1, dtype=np.int64)
        value, jacobian, measures = problem.linearized(one, state[None])
        pair = np.array([1, 2])
        steps = np.repeat(problem.steps(one, state[None]), 2)
        images, _ = problem.advance(pair, np.repeat(state[None], 2, axis=0), steps, np.zeros(2), np.ones(2))
        away = chart.coordinates(images[:1], images[1:], self.length)[0]
        return problem, value[0], jacobian[0], away / (2.0 * SLOPE_STRIDE), measures

    def moved(self, state: Floats, by: Floats) -> Floats:
        return np.asarray(chart.moved(state[None], by[None, :6], self.length)[0])

    def corrected(self, state: Floats, share: float, row: Floats, before: Floats) -> tuple[Point, float, int] | None:
        """Newton from a predicted place, moving only across ``row`` (7,); None where it does not converge."""
        for iteration in range(CORRECTIONS):
            try:
                problem, value, jacobian, slope, measures = self.evaluate(state, share)
            except InputError:
                return None
            matrix = np.vstack([np.column_stack([jacobian - np.eye(6), slope]), row])
            if not np.isfinite(matrix).all() or not np.isfinite(value).all():
                return None
            step = np.linalg.solve(matrix, np.append(-value, 0.0))
            if np.linalg.norm(step) > 0.3:
                return None
            state, share = self.moved(state, step), share + step[6]
            if np.linalg.norm(step) < CORRECTED:
                tangent = np.linalg.solve(np.vstack([matrix[:6], before]), np.append(np.zeros(6), 1.0))
                tangent /= np.linalg.norm(tangent)
                return self._point(problem, state, share, value, jacobian, measures, tangent), share, iteration
        return None

    def _point(
        self,
        problem: Problem,
        state: Floats,
        share: float,
        value: Floats,
        jacobian: Floats,
        measures: Measured,
        tangent: Floats,
    ) -> Point:
        norm = np.array([float(np.linalg.norm(value))])
        one = np.zeros(1, dtype=np.int64)
        solved = Solved(np.array([True]), state[None], norm, jacobian[None], measures, one)
        (orbit,) = orbits_of(problem, one, solved, classify(problem, one, solved))
        return Point(self.low + share * self.span, orbit, tangent)


def follow(
    orbit: Orbit,
    path: str,
    low: float,
    high: float,
    *,
    while_stable: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Branch:
    """Follow an orbit through an input, both ways, until it leaves the range or its region.

    Parameters
    ----------
    orbit
        One that was found, at a value of the input within the range.
    path
        Dotted path of a scalar field, such as ``drive.pitch``; or ``drive.speed``.
    low, high
        Range of the input, SI.
    while_stable
        Stop each way at the first change of stability.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Branch
        Points in order of arclength; where stability changes as events.

    Raises
    ------
    InputError
        Where the orbit was not found, or its input is not a number within the range.
    """
    given = Input(path)
    if not orbit.found:
        raise InputError(f"an orbit to follow must have been found; got '{orbit.status}': {orbit.status.text()}")
    here = given.value(orbit.scenario)
    if not low < high or not low <= here <= high:
        raise InputError(
            f"the range of {path} must hold the orbit's own {given.show(orbit.scenario, here)}; got "
            f"{given.show(orbit.scenario, low)} to {given.show(orbit.scenario, high)}"
        )
    watch = Watch(progress)
    curve = _Curve(orbit.scenario, given, low, high, watch)
    start = (here - low) / (high - low)
    only_input = np.append(np.zeros(6), 1.0)
    begun = curve.corrected(orbit.state, start, only_input, only_input)
    if begun is None:
        raise InputError("the orbit does not solve its own equations: find it again with these inputs")
    first = begun[0]
    up = _one_way(curve, first, start, 1.0, while_stable, watch.part(0.0, 0.5))
    down = _one_way(curve, first, start, -1.0, while_stable, watch.part(0.5, 1.0))
    watch(1.0)
    points = [*reversed(down[0]), first, *up[0]]
    shift = len(down[0])
    events = [Event(e.kind, e.value, e.orbit, shift - e.index) for e in reversed(down[1])]
    events += [Event(e.kind, e.value, e.orbit, shift + 1 + e.index) for e in up[1]]
    return Branch(path, low, high, points, events, (down[2], up[2]), shift)


def _one_way(
    curve: _Curve, first: Point, share: float, sense: float, while_stable: bool, watch: Watch
) -> tuple[list[Point], list[Event], str]:
    """Points, events and the reason for the end, one way from ``first``; an event's index counts points passed."""
    points: list[Point] = []
    events: list[Event] = []
    at = Point(first.value, first.orbit, sense * first.tangent)
    step = FIRST_STEP
    for _ in range(MOST_POINTS):
        if (share >= 1.0 and at.tangent[6] > 0.0) or (share <= 0.0 and at.tangent[6] < 0.0):
            return points, events, "end of the range"
        step, landing = _limited(step, share, at.tangent[6])
        found = _advanced(curve, at, share, step, landing)
        if found is None:
            step *= 0.5
            if step < SHORTEST_STEP:
                return points, events, "the search for the next orbit failed"
            continue
        new, new_share, iterations = found
        changed = new.unstable != at.unstable or new.tangent[6] * at.tangent[6] < 0.0
        if changed and abs(new.unstable - at.unstable) > 1 and not _one_swing(at, new) and step > 64.0 * SHORTEST_STEP:
            step *= 0.5
            continue
        if not while_stable and new.tangent @ at.tangent < TURN and step > 1e-3:
            step *= 0.5
            continue
        if not new.orbit.found:
            if step > 1e-3:
                step *= 0.5
                continue
            return points, events, str(new.orbit.status)
        if changed:
            events.append(_located(curve, at, share, new, step, len(points)))
            if while_stable and new.unstable != at.unstable:
                return points, events, str(events[-1].kind)
        points.append(new)
        at, share = new, new_share
        step = min(LONGEST_STEP, step * (1.5 if iterations <= 2 else 0.8))
        watch(share if sense > 0.0 else 1.0 - share)
    return points, events, f"{MOST_POINTS} orbits, the most that are followed"


def _limited(step: float, share: float, slope: float) -> tuple[float, float | None]:
    """The step, cut where it would leave the range; and the end of the range where it then lands."""
    end = 1.0 if slope > 0.0 else 0.0
    if abs(slope) > 1e-3 and step * abs(slope) >= abs(end - share):
        return abs(end - share) / abs(slope), end
    return step, None


def _advanced(
    curve: _Curve, at: Point, share: float, step: float, landing: float | None
) -> tuple[Point, float, int] | None:
    """The next point of the branch; at ``landing``, where given, the input is held there."""
    predicted = curve.moved(at.orbit.state, step * at.tangent)
    if landing is not None:
        row = np.append(np.zeros(6), 1.0)
        return curve.corrected(predicted, landing, row, at.tangent)
    return curve.corrected(predicted, share + step * at.tangent[6], at.tangent, at.tangent)


def _one_swing(a: Point, b: Point) -> bool:
    """Whether what crosses the unit circle between two points is one conjugate pair."""
    if abs(a.unstable - b.unstable) != 2:
        return False
    crossing = _ordered(b)[min(a.unstable, b.unstable)]
    return bool(abs(crossing.imag) > 1e-9)


def _ordered(point: Point) -> np.ndarray:
    rates = point.orbit.rates
    return np.asarray(rates[np.argsort(-rates.real)])


def _located(curve: _Curve, a: Point, share: float, b: Point, step: float, index: int) -> Event:
    """The change of stability between two neighbours, by bisection and secants on the rate that crosses zero."""
    crossing = min(a.unstable, b.unstable) if a.unstable != b.unstable else None

    def test(point: Point) -> float:
        return float(_ordered(point)[crossing].real) if crossing is not None else float(point.tangent[6])

    low, high = 0.0, step
    f_low, f_high = test(a), test(b)
    best = b if abs(f_high) < abs(f_low) else a
    weight_low = weight_high = 1.0
    for _ in range(30):
        if abs(high - low) < LOCATED:
            break
        # Illinois method: a secant that halves the weight of an end that stays
        f_a, f_b = weight_low * f_low, weight_high * f_high
        middle = (low * f_b - high * f_a) / (f_b - f_a) if f_a * f_b < 0.0 else 0.5 * (low + high)
        middle = min(max(middle, low + 0.02 * (high - low)), high - 0.02 * (high - low))
        found = _advanced(curve, a, share, middle, None)
        if found is None:
            break
        moved = abs(found[0].value - best.value) / curve.span
        best = found[0]
        value = test(best)
        if value * f_low > 0.0:
            low, f_low, weight_low, weight_high = middle, value, 1.0, 0.5 * weight_high
        else:
            high, f_high, weight_low, weight_high = middle, value, 0.5 * weight_low, 1.0
        if moved < 0.1 * LOCATED and abs(value) < 1e-3 * max(abs(test(a)), abs(test(b))):
            break
    return Event(_named(a, b, best, crossing), best.value, best.orbit, index)


def _named(a: Point, b: Point, at: Point, crossing: int | None) -> Change:
    if crossing is None:
        return Change.FOLD
    rate = _ordered(at)[crossing]
    half_turn = np.pi * abs(at.orbit.scenario.drive.frequency)
    if abs(rate.imag) > 0.99 * half_turn:
        return Change.PERIOD_DOUBLING
    if abs(rate.imag) > 1e-6:
        return Change.NEIMARK_SACKER
    return Change.FOLD if a.tangent[6] * b.tangent[6] < 0.0 else Change.BRANCH_POINT
