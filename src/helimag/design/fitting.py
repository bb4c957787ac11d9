"""Inputs changed as little as need be until the orbit has exactly the wanted values."""

import math
from collections.abc import Sequence

import numpy as np

from helimag.design.task import DesignTask
from helimag.orbits import Floats, Orbit, Watch, chart, find_orbits

WITHIN = 1e-6  # of the wanted value
STRIDE = 1e-3  # of the limits, for the slope over the inputs
MOST_STEPS = 12


def fitted(task: DesignTask, orbit: Orbit, watch: Watch) -> Orbit | None:
    """The nearest orbit with exactly the wanted values: Gauss and Newton's method, least change of the inputs."""
    quiet = watch.unmeasured()
    for _ in range(MOST_STEPS):
        if task.miss(orbit) < WITHIN:
            return orbit if orbit.stable else None
        place = task.shares(orbit.scenario)
        tried = [place + STRIDE * unit for unit in np.eye(len(place))]
        begun = np.repeat(orbit.state[None], len(tried), axis=0)
        beside = find_orbits([task.at(shares) for shares in tried], begun, progress=quiet)
        if not all(other.found for other in beside):
            return None
        logs = np.array([[math.log(getattr(o, name)) for o in (orbit, *beside)] for name in task.wanted])
        slope = (logs[:, 1:] - logs[:, :1]) / STRIDE
        lack = np.log(list(task.wanted.values())) - logs[:, 0]
        step = np.linalg.lstsq(slope, lack, rcond=None)[0]
        step *= min(1.0, 0.1 / max(float(np.linalg.norm(step)), 1e-12))
        target = np.clip(place + step, 0.0, 1.0)
        if np.linalg.norm(target - place) < 1e-9:
            return None
        carried = _carried(orbit, beside, target - place)
        (orbit,) = find_orbits([task.at(target)], carried[None], progress=quiet)
        if not orbit.found:
            return None
    return None


def _carried(orbit: Orbit, beside: Sequence[Orbit], step: Floats) -> Floats:
    """The orbit's state after a step (k,) of the inputs, by its slope to the orbits a stride along each."""
    length = np.full(len(beside), orbit.scenario.drive.distance)
    around = np.repeat(orbit.state[None], len(beside), axis=0)
    slope = chart.coordinates(np.array([other.state for other in beside]), around, length) / STRIDE
    return np.asarray(chart.moved(orbit.state[None], (step @ slope)[None], length[:1])[0])
