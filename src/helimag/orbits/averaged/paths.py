"""Paths of the averaged model, and how far they stray from full runs."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from helimag.orbits.averaged.averaging import SlowFlow
from helimag.orbits.strobe import Floats, Orbit, Watch, strobed

SAMPLES = 300  # of a full run that the averaged model is compared with
STEP = 4.0  # s, of the averaged model (Runge and Kutta, fourth order): a fiftieth of a slow swing
OFF = (0.25, 0.6)  # of the way from the orbit to the grid's face along x: where the averaging error is measured from
COMPARED = 1800.0  # s, of those runs


def averaged_paths(
    flow: SlowFlow, places: Floats, times: Floats, *, progress: Callable[[float], None] | None = None
) -> Floats:
    """Paths of the averaged model from places (m, 3), moving frame, all at once.

    Parameters
    ----------
    times
        (n,) increasing, s, from the start of the run; each gap is cut into equal steps of at most ``STEP``.
    progress
        Called with the fraction done.

    Returns
    -------
    array
        (m, n, 3), m; nan once a path has left the grid.
    """
    at = np.array(places, dtype=float)
    path = np.empty((len(at), len(times), 3))
    now = 0.0
    for i, time in enumerate(times):
        count = int(np.ceil((time - now) / STEP - 1e-9))
        for _ in range(count):
            dt = (time - now) / count
            k1 = flow.at(at)
            k2 = flow.at(at + 0.5 * dt * k1)
            k3 = flow.at(at + 0.5 * dt * k2)
            k4 = flow.at(at + dt * k3)
            at = at + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        path[:, i], now = at, float(time)
        if progress is not None:
            progress((i + 1) / len(times))
    return path


@dataclass(frozen=True)
class AveragingError:
    """Distance (m) between averaged and full model over one run: times (n,), distances (n,), and both heights (n,)."""

    time: Floats
    distance: Floats
    averaged: Floats
    full: Floats

    @property
    def worst(self) -> float:
        return float(self.distance.max())

    @property
    def mean(self) -> float:
        return float(self.distance.mean())


def averaging_error(
    flow: SlowFlow, place: Floats, duration: float, *, progress: Callable[[float], None] | None = None
) -> AveragingError:
    """Run both models from a place (3,) for a time (s) and compare; the full one starts with the flow's attitude there.

    ``progress`` is called with the fraction done of the full run.
    """
    begin = np.asarray(place, float)
    start = flow.state_at(begin)[None]
    (run,) = strobed(flow.scenario, duration, samples=SAMPLES, states=start, progress=progress)
    path, full = averaged_paths(flow, begin[None], run.times)[0], run.states[:, :3]
    both = np.isfinite(path).all(axis=1)
    distance = np.linalg.norm(path[both] - full[both], axis=1)
    return AveragingError(run.times[both], distance, path[both, 2], full[both, 2])


def averaging_errors(
    flow: SlowFlow, orbit: Orbit, *, progress: Callable[[float], None] | None = None
) -> list[tuple[float, AveragingError]]:
    """Averaged model beside full runs of half an hour from two places off the orbit, as far as the flow is known there.

    The places are the nodes next to a quarter and three fifths of the way from the orbit to the grid's face along x.

    Parameters
    ----------
    flow
        A slow flow around the orbit.
    orbit
        One that was found.
    progress
        Called with the fraction done, some times a second. What it raises stops the comparison.

    Returns
    -------
    list of (float, AveragingError)
        How far each start lies off the orbit (m), and the comparison from there.
    """
    watch, errors = Watch(progress), []
    for count, share in enumerate(OFF):
        place = orbit.position + share * np.array([flow.axes[0][-1] - orbit.position[0], 0.0, 0.0])
        node = np.array([axis[np.argmin(np.abs(axis - x))] for axis, x in zip(flow.axes, place, strict=True)])
        if np.isfinite(flow.at(node[None])).all():
            off = float(np.linalg.norm(node - orbit.position))
            errors.append((off, averaging_error(flow, node, COMPARED, progress=watch.turn(count, len(OFF)))))
    watch(1.0)
    return errors
