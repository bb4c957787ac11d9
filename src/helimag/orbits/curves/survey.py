"""All stable stretches of an input's range, whether or not the scenario's own value lies in one."""

from collections.abc import Callable, Sequence

import numpy as np

from helimag.errors import InputError
from helimag.orbits.curves.branch import Branch
from helimag.orbits.curves.continuation import follow
from helimag.orbits.curves.intervals import stable_segments
from helimag.orbits.curves.spreading import OrbitGrid
from helimag.orbits.strobe import Orbit, Watch, find_orbit
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input

VALUES = 33  # of the input at which stable orbits are sought


def survey(
    scenario: Scenario,
    path: str,
    low: float,
    high: float,
    *,
    known: Sequence[Branch] = (),
    progress: Callable[[float], None] | None = None,
) -> list[Branch]:
    """Follow every family of orbits that is stable somewhere in a range of an input.

    Parameters
    ----------
    path
        Dotted path of a scalar field, such as ``drive.pitch``; or ``drive.speed``.
    low, high
        Range of the input, SI.
    known
        Branches over the same range that need not be followed again.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    list of Branch
        Those with a stable stretch, the known ones first. Stretches narrower than a 33rd of the range may be missed.

    Raises
    ------
    InputError
        Where the input is not a number that may take those values.
    """
    given, watch = Input(path), Watch(progress)
    given.check(scenario)
    values = np.linspace(low, high, VALUES)
    scenarios = [given.changed(scenario, float(value)) for value in values]
    found = OrbitGrid(lambda node: scenarios[node[0]], (VALUES,), length=scenario.drive.distance)
    found.seek_all_over(watch.part(0.0, 0.2))
    found.spread(watch.part(0.2, 0.3))
    following = watch.part(0.3, 1.0)
    branches = list(known)
    for node in np.flatnonzero(found.stable):
        value = float(values[node])
        parts = (part for branch in branches for part in stable_segments(branch))
        if any(part.low <= value <= part.high for part in parts):
            continue
        one = following.turn(int(node), VALUES)
        orbit = find_orbit(scenarios[node], near=found.states[node], progress=one.part(0.0, 0.1))
        if orbit.stable:
            branches.append(follow(orbit, path, low, high, progress=one.part(0.1, 1.0)))
    watch(1.0)
    return [branch for branch in branches if stable_segments(branch)]


def all_branches(
    orbit: Orbit, path: str, low: float, high: float, *, progress: Callable[[float], None] | None = None
) -> list[Branch]:
    """The branch of an orbit through an input, first, and all others that are stable somewhere in the range.

    Parameters
    ----------
    orbit
        Result of a search; its own branch is followed where it was found and its input lies in the range.
    path, low, high
        As for :func:`survey`.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    list of Branch
        Each with its points in order of arclength and its events.

    Raises
    ------
    InputError
        As for :func:`survey`; and where the range does not go from low to high.
    """
    given, watch = Input(path), Watch(progress)
    if not low < high:
        ends = " to ".join(given.show(orbit.scenario, value) for value in (low, high))
        raise InputError(f"the range of {path} must go from low to high; got {ends}")
    own = []
    if orbit.found and given.within(orbit.scenario, low, high):
        own = [follow(orbit, path, low, high, progress=watch.part(0.0, 0.3))]
    stable = survey(orbit.scenario, path, low, high, known=own, progress=watch.part(0.3, 1.0))
    return own + [branch for branch in stable if branch not in own]
