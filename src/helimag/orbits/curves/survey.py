"""All stable stretches of an input's range, whether or not the scenario's own value lies in one."""

from collections.abc import Callable, Sequence

import numpy as np

from helimag.orbits.curves.branch import Branch
from helimag.orbits.curves.continuation import follow
from helimag.orbits.curves.intervals import stable_segments
from helimag.orbits.curves.spreading import Spread
from helimag.orbits.strobe.find import find_orbit
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
        Called with a rough fraction done.

    Returns
    -------
    list of Branch
        Those with a stable stretch, the known ones first. Stretches narrower than a 33rd of the range may be missed.

    Raises
    ------
    InputError
        Where the input is not a number that may take those values.
    """
    given, report = Input(path), progress or (lambda _: None)
    given.check(scenario)
    values = np.linspace(low, high, VALUES)
    scenarios = [given.changed(scenario, float(value)) for value in values]
    found = Spread(lambda node: scenarios[node[0]], (VALUES,), length=scenario.drive.distance)
    found.seek_all_over()
    found.spread(lambda done: report(0.3 * done))
    branches = list(known)
    for node in np.flatnonzero(found.stable):
        value = float(values[node])
        parts = (part for branch in branches for part in stable_segments(branch))
        if any(part.low <= value <= part.high for part in parts):
            continue
        orbit = find_orbit(scenarios[node], near=found.states[node])
        if orbit.stable:
            branches.append(follow(orbit, path, low, high))
        report(0.3 + 0.7 * (node + 1) / VALUES)
    return [branch for branch in branches if stable_segments(branch)]
