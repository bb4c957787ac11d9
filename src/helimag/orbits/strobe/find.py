"""Find orbits: from a neighbour, from a run, from a grid of places; one or many."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from helimag.errors import InputError
from helimag.geometry import long_axes
from helimag.orbits.strobe import chart
from helimag.orbits.strobe.floquet import fast_multipliers, multipliers_of, rates_of
from helimag.orbits.strobe.newton import Solved, solve
from helimag.orbits.strobe.orbit import Orbit
from helimag.orbits.strobe.problem import Floats, Ints, Problem
from helimag.orbits.strobe.starts import default_box, on_grid, open_water, strobed
from helimag.orbits.strobe.watching import Watch
from helimag.outcomes import End, OrbitStatus
from helimag.scenario import Scenario, as_scenario

SAME = 1e-5  # of the distance and in radians: two searches that end this near found one orbit
RUN_DURATION, RUN_SAMPLES = 1800.0, 24  # s; states of a run that searches begin at
NEIGHBOUR_ITERATIONS = 12  # evaluations from a neighbour's orbit, which needs three or four
GRID = (5, 5, 7)  # starts of a list
COARSE = (3, 3, 5)  # starts where a run led to no stable orbit


def find_orbit(
    scenario: Scenario | str | Path,
    *,
    near: "Orbit | Floats | None" = None,
    thorough: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Orbit:
    """Find the orbit of a scenario: the run that repeats itself, turn of the magnet by turn, in the frame of the drive.

    Parameters
    ----------
    scenario
        Whose orbit, or its name or path as :func:`helimag.load` takes it. A circular or a straight run; the workspace
        limits it.
    near
        An orbit of similar inputs, or a state (7,) in the moving frame, to begin the search at. Default: begin at
        states along a run, and where that leads to no stable orbit, on a grid of places around the magnet.
    thorough
        Whether to go on to the grid.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Orbit
        A stable one if the search ended on any (of several the one nearest to the end of the run), else the least
        unstable, else one whose status says why there is none.

    Raises
    ------
    InputError
        Where the drive has no moving frame in which it repeats, or ``near`` is not a state.
    """
    scenario, watch = as_scenario(scenario), Watch(progress)
    problem = Problem([scenario], watch=watch)
    if near is not None:
        return _solved(problem, _state_of(near)[None])[0]
    (run,) = strobed(open_water(scenario), RUN_DURATION, samples=RUN_SAMPLES, progress=watch.part(0.0, 0.6))
    states = run.states
    orbits = _distinct(_solved(problem.watched(watch.part(0.6, 0.7)), states, refine=False))
    if thorough and not any(orbit.stable for orbit in orbits):
        low, high = default_box(scenario, problem.arm[0])
        grid = on_grid(problem.watched(watch.part(0.7, 0.8)), 0, low, high, COARSE, both_ways=True)
        if len(grid):
            orbits = _distinct(orbits + _solved(problem.watched(watch.part(0.8, 0.95)), grid, refine=False))
    best = _best(orbits, states[-1, :3])
    if best is None:
        watch(1.0)
        return Orbit(scenario=scenario, status=_why_not(orbits, run.status))
    refined = _refined(problem, best)
    watch(1.0)
    return refined


def list_orbits(
    scenario: Scenario,
    *,
    low: Sequence[float] | None = None,
    high: Sequence[float] | None = None,
    shape: tuple[int, int, int] = GRID,
    both_ways: bool = True,
    progress: Callable[[float], None] | None = None,
) -> list[Orbit]:
    """All orbits that a grid of starts and a run lead to, the most stable first.

    Parameters
    ----------
    low, high
        Corners of the box to search, moving frame, m. Default: a region below the magnet, wide of it by its distance.
    shape
        Starts along x, y and z.
    both_ways
        Also begin with the device's nose pointing the other way along the field's axis.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    list of Orbit
        Each once.

    Raises
    ------
    InputError
        Where the drive has no moving frame in which it repeats, or the corners are none of a box.
    """
    watch = Watch(progress)
    problem = Problem([scenario], watch=watch)
    default = default_box(scenario, problem.arm[0])
    corners = [
        np.asarray(given if given is not None else own, float) for given, own in zip((low, high), default, strict=True)
    ]
    if any(corner.shape != (3,) or not np.isfinite(corner).all() for corner in corners) or np.any(
        corners[0] > corners[1]
    ):
        raise InputError("low and high must be corners of a box, three finite numbers each, low below high")
    starts = on_grid(problem.watched(watch.part(0.0, 0.2)), 0, corners[0], corners[1], shape, both_ways=both_ways)
    (run,) = strobed(open_water(scenario), RUN_DURATION, samples=RUN_SAMPLES, progress=watch.part(0.2, 0.5))
    begun = np.concatenate([starts, run.states])
    orbits = _distinct(_solved(problem.watched(watch.part(0.5, 0.9)), begun, refine=False))
    found = [
        _refined(problem, orbit)
        for orbit in orbits
        if orbit.found and np.all(orbit.position >= corners[0]) and np.all(orbit.position <= corners[1])
    ]
    watch(1.0)
    return sorted(found, key=lambda orbit: orbit.growth)


def find_orbits(
    scenarios: Sequence[Scenario], near: Floats, *, progress: Callable[[float], None] | None = None
) -> list[Orbit]:
    """Orbits of a batch, each from its own state; fast multipliers as the map gives them.

    Parameters
    ----------
    scenarios
        At least one; their magnets may have different field models.
    near
        (n, 7): a state for each, moving frame.
    progress
        Called with the fraction of searches done, some times a second. What it raises stops the search.

    Returns
    -------
    list of Orbit
        One for each start, found or not.

    Raises
    ------
    InputError
        Where a drive has no moving frame in which it repeats, or the states do not fit.
    """
    problem = Problem(scenarios, watch=Watch(progress))
    states = np.asarray(near, dtype=float)
    if states.shape != (len(scenarios), 7) or not np.isfinite(states).all():
        raise InputError(f"near must be finite states of shape ({len(scenarios)}, 7); got {states.shape}")
    return _solved(problem, states, which=np.arange(len(scenarios)), refine=False, iterations=NEIGHBOUR_ITERATIONS)


def _state_of(near: "Orbit | Floats") -> Floats:
    state = near.state if isinstance(near, Orbit) else np.asarray(near, dtype=float)
    if state.shape != (7,) or not np.isfinite(state).all():
        raise InputError(
            "near must be an orbit that was found or a state of seven finite numbers: x y z (m) qw qx qy qz"
        )
    length = np.linalg.norm(state[3:])
    if not length > 0.0:
        raise InputError("near must have a quaternion that is not zero")
    return np.concatenate([state[:3], state[3:] / length])


def _solved(
    problem: Problem, states: Floats, *, which: Ints | None = None, refine: bool = True, iterations: int = 25
) -> list[Orbit]:
    """Search from each state; problem 0 unless ``which`` says otherwise."""
    numbers = np.zeros(len(states), dtype=np.int64) if which is None else which
    solved = solve(problem, numbers, states, iterations=iterations)
    orbits = orbits_of(problem, numbers, solved, classify(problem, numbers, solved))
    return [_refined(problem, orbit) if orbit.found else orbit for orbit in orbits] if refine else orbits


def orbits_of(problem: Problem, which: Ints, solved: Solved, status: list[OrbitStatus]) -> list[Orbit]:
    """Results of a batch of searches; fast multipliers as the whole period's Jacobian gives them."""
    good = np.flatnonzero([s is OrbitStatus.FOUND for s in status])
    multipliers = np.full((len(which), 6), np.nan, dtype=np.complex128)
    if good.size:
        multipliers[good] = multipliers_of(solved.jacobian[good])
    return [
        _orbit(problem, which, solved, i, multipliers[i])
        if status[i] is OrbitStatus.FOUND
        else Orbit(scenario=problem.scenarios[which[i]], status=status[i], iterations=int(solved.iterations[i]))
        for i in range(len(which))
    ]


def _orbit(problem: Problem, which: Ints, solved: Solved, i: int, multipliers: np.ndarray) -> Orbit:
    measures = solved.measures[i]
    return Orbit(
        scenario=problem.scenarios[which[i]],
        status=OrbitStatus.FOUND,
        state=solved.states[i],
        multipliers=multipliers,
        rates=rates_of(multipliers, problem.period[which[i]]),
        jacobian=solved.jacobian[i],
        mean_position=measures["position"],
        height_range=(float(measures["low"]), float(measures["high"])),
        attack_angle=float(measures["attack"]),
        wobble=float(np.sqrt(max(measures["square"] - measures["attack"] ** 2, 0.0))),
        lag_cosine=float(measures["cosine"]),
        iterations=int(solved.iterations[i]),
    )


def _refined(problem: Problem, orbit: Orbit) -> Orbit:
    """The orbit with its fast multipliers resolved and the integration's error measured."""
    one = np.zeros(1, dtype=np.int64)
    state = orbit.state[None]
    image, _ = problem.advance(one, state, 2 * problem.steps(one, state), np.zeros(1), np.ones(1))
    value = chart.coordinates(image, state, problem.length)[0]
    error = np.linalg.solve(orbit.jacobian - np.eye(6), -value)
    multipliers = fast_multipliers(problem, orbit.state, orbit.multipliers)
    return replace(
        orbit,
        multipliers=multipliers,
        rates=rates_of(multipliers, problem.period[0]),
        position_error=float(np.linalg.norm(error[:3]) * problem.length[0]),
    )


def classify(problem: Problem, which: Ints, solved: Solved) -> list[OrbitStatus]:
    """How each search ended."""
    gap = np.linalg.norm(solved.states[:, :3] - problem.arm[which], axis=1)
    below = solved.measures["low"] < problem.lowest[which]
    far = gap > 4.0 * problem.length[which]
    result = []
    for i, number in enumerate(which):
        if not np.isfinite(solved.states[i]).all() or not np.isfinite(solved.residual[i]):
            result.append(OrbitStatus.BROKE_DOWN)
        elif gap[i] < problem.contact[number]:
            result.append(OrbitStatus.ATTRACTED)
        elif below[i] or far[i]:
            result.append(OrbitStatus.LEFT_BOX)
        elif solved.converged[i]:
            inside = _inside(problem.scenarios[number], solved.states[i], solved.measures[i])
            result.append(OrbitStatus.FOUND if inside else OrbitStatus.WALL_LIMITED)
        else:
            result.append(OrbitStatus.LOST_STEP if solved.measures["cosine"][i] < 0.0 else OrbitStatus.NO_ORBIT)
    return result


def _inside(scenario: Scenario, state: Floats, measures: np.void) -> bool:
    """Whether an orbit keeps clear of floor, surface and walls; a drive that moves on to one ends there anyway.

    Heights of the tail are by the mean attack angle, places sideways by the state at the start of the period. A device
    that goes round comes to every side of its circle.
    """
    low, high = np.array(open_water(scenario).workspace.box)
    length = scenario.device.tail_length
    radii = np.array([scenario.device.head_radius, scenario.device.tail_radius])  # of head and tail
    ends = state[:2] - np.outer([0.0, length], long_axes(state[3:])[:2])
    if scenario.drive.yaw_rate != 0.0:
        reach = np.full(2, np.max(np.linalg.norm(ends, axis=1) + radii))
        least, most = -reach, reach
    else:
        least, most = np.min(ends - radii[:, None], axis=0), np.max(ends + radii[:, None], axis=0)
    heights = np.array([0.0, -length * np.sin(measures["attack"])])
    least = np.append(least, np.min(measures["low"] + heights - radii))
    most = np.append(most, np.max(measures["high"] + heights + radii))
    return bool(np.all(low < least) and np.all(most < high))


def _distinct(orbits: list[Orbit]) -> list[Orbit]:
    """Each orbit once; failures are kept."""
    kept: list[Orbit] = []
    for orbit in orbits:
        length = np.array(orbit.scenario.drive.distance)
        known = (other for other in kept if other.found)
        if orbit.found and any(
            np.linalg.norm(chart.coordinates(orbit.state, other.state, length)) < SAME for other in known
        ):
            continue
        kept.append(orbit)
    return kept


def _best(orbits: list[Orbit], end: Floats) -> Orbit | None:
    found = [orbit for orbit in orbits if orbit.found]
    stable = [orbit for orbit in found if orbit.stable]
    if stable:
        return min(stable, key=lambda orbit: float(np.linalg.norm(orbit.position - end)))
    return min(found, key=lambda orbit: orbit.growth, default=None)


def _why_not(orbits: list[Orbit], end: End) -> OrbitStatus:
    """The most telling reason among searches that all failed: how the run ended, else what most searches met."""
    if any(orbit.status is OrbitStatus.WALL_LIMITED for orbit in orbits):
        return OrbitStatus.WALL_LIMITED
    if end.search is not None:
        return end.search
    lost = sum(orbit.status is OrbitStatus.LOST_STEP for orbit in orbits)
    return OrbitStatus.LOST_STEP if 2 * lost > len(orbits) else OrbitStatus.NO_ORBIT
