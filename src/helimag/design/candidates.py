"""Orbits that a design may have: stable ones over the box of inputs, fitted to the wanted values."""

import numpy as np

from helimag.design.fitting import fitted
from helimag.design.task import DesignTask
from helimag.engine import advance
from helimag.orbits import Floats, Orbit, Watch, find_orbit, find_orbits
from helimag.outcomes import Verdict

SAMPLES = 256  # places of the inputs' box that are looked at first
ROUNDS = 5  # of spreading from the stable ones among them
SOLVED = 24  # samples that are brought to the wanted values, the nearest ones
FIRST_LOOK = 1800.0  # s, of runs that tell whether devices settle from the scenario's start

Sample = tuple[Floats, Orbit]  # shares of the limits, and the orbit there


def stable_samples(task: DesignTask, watch: Watch) -> tuple[list[Sample], Floats]:
    """Stable orbits over the box of inputs, and places without: each sought from the nearest that is known."""
    from scipy.stats import qmc

    points = qmc.Sobol(len(task.span), seed=task.random).random(SAMPLES)
    scenarios = task.scenarios(task.low + points * task.span, watch.unmeasured())
    known: list[Sample] = []
    here = (task.parameters.nearest(task.scenario) - task.low) / task.span
    first = sorted(range(SAMPLES), key=lambda i: float(np.linalg.norm(points[i] - here)))
    seeds = [task.at(here), *(scenarios[i] for i in first[:12])]
    for count, scenario in enumerate(seeds):
        orbit = find_orbit(scenario, thorough=False, progress=watch.part(0.0, 0.5).turn(count, len(seeds)))
        if orbit.stable:
            known.append((task.shares(scenario), orbit))
        if len(known) >= 3:
            break
    open_ = list(range(SAMPLES))
    for count in range(ROUNDS if known else 0):
        places = np.array([place for place, _ in known])
        nearest = [int(np.argmin(np.linalg.norm(places - points[i], axis=1))) for i in open_]
        states = np.array([known[j][1].state for j in nearest])
        found = find_orbits([scenarios[i] for i in open_], states, progress=watch.part(0.5, 1.0).turn(count, ROUNDS))
        known += [(points[i], orbit) for i, orbit in zip(open_, found, strict=True) if orbit.stable]
        left = [i for i, orbit in zip(open_, found, strict=True) if not orbit.stable]
        if len(left) == len(open_) or not left:
            break
        open_ = left
    return known, points[open_]


def settling_samples(samples: list[Sample], unstable: Floats, watch: Watch) -> tuple[list[Sample], Floats]:
    """Those of the samples whose runs from the scenario's start are bounded, and all other places."""
    if not samples:
        return [], unstable
    runs = [orbit.scenario.replaced({"run.duration": FIRST_LOOK, "run.interval": None}) for _, orbit in samples]
    bounded = [history.judge().verdict is Verdict.BOUNDED for history in advance(runs, progress=watch)]
    others = [place for (place, _), fine in zip(samples, bounded, strict=True) if not fine]
    return [each for each, fine in zip(samples, bounded, strict=True) if fine], np.array([*unstable, *others])


def candidates(task: DesignTask, samples: list[Sample], avoided: Floats, watch: Watch) -> list[Orbit]:
    """Orbits with the wanted values, up to :data:`SOLVED`, those first that lie far from all places to be avoided."""
    solved = []
    near = sorted(samples, key=lambda sample: task.miss(sample[1]))[:SOLVED]
    for count, (_, orbit) in enumerate(near):
        fit = fitted(task, orbit, watch.turn(count, len(near)))
        if fit is not None:
            solved.append(fit)
    return sorted(solved, key=lambda orbit: -_room(task, orbit, avoided))


def _room(task: DesignTask, orbit: Orbit, avoided: Floats) -> float:
    """Distance to the nearest place to be avoided, or to the limits, in shares."""
    place = task.shares(orbit.scenario)
    edge = float(np.minimum(place, 1.0 - place).min())
    if len(avoided) == 0:
        return edge
    return min(float(np.linalg.norm(avoided - place, axis=1).min()), 2.0 * edge)
