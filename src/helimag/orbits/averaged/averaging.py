"""Slow flow: how the device drifts relative to the drive, place by place, with roll and axis following.

The attitude relaxes within some ten seconds, the place within hundreds. What remains after that is a flow in three
dimensions, on the slow manifold: the attitudes that the device has while it drifts. It is computed in stages. Held in
place, the attitude settles (stage 0); released, it lags behind where it would settle, because the place moves (stages
1, 2 ...): each stage takes the attitudes of the stage before to work out by how much.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits.strobe import (
    Floats,
    Orbit,
    Problem,
    Watch,
    attitudes,
    chart,
    default_box,
    sense_of,
    settle,
)
from helimag.scenario import Scenario

SHAPE = (17, 17, 21)
LAG_STAGES = 4
ROTATION = range(3, 6)
BATCH = 512
SLOW = 0.05  # of the gap to the magnet: a device that a turn moves farther is being drawn in, and has no slow flow
FAR = 1e3  # m
ROUNDING = 1e-9  # of a cell: a place on the grid's face is inside


@dataclass(frozen=True)
class SlowFlow:
    """Velocity of the settled device in the moving frame, on a grid.

    Attributes
    ----------
    axes
        Three increasing arrays (m), moving frame.
    velocity
        (nx, ny, nz, 3), m/s: zero on an orbit. Nodes without a settled attitude hold their nearest neighbour's.
    states
        (nx, ny, nz, 7): place and attitude, at the start of the magnet's turn.
    settled
        (nx, ny, nz): where an attitude was found that keeps in step, and a turn of the magnet moves the device little.
    """

    scenario: Scenario
    axes: tuple[Floats, Floats, Floats]
    velocity: Floats
    states: Floats
    settled: NDArray[np.bool_]

    def at(self, places: Floats) -> Floats:
        """Velocity (n, 3) at places (n, 3), by tricubic splines; nan outside the grid or where nothing settles.

        Returns
        -------
        ndarray
            (n, 3), m/s.
        """
        from scipy.ndimage import map_coordinates

        index = self._index(places)
        out = np.stack(
            [map_coordinates(c, index, order=3, prefilter=False, mode="nearest") for c in self._splines], axis=1
        )
        last = np.array(self.settled.shape)[:, None] - 1.0
        inside = np.all((index >= -ROUNDING) & (index <= last + ROUNDING), axis=0)
        near = np.clip(np.nan_to_num(index).round().astype(int), 0, np.array(self.settled.shape)[:, None] - 1)
        out[~(inside & self.settled[tuple(near)])] = np.nan
        return np.asarray(out)

    def state_at(self, place: Floats) -> Floats:
        """State (7,) at a place: the attitude of the nearest node.

        Returns
        -------
        ndarray
            (7,): place and attitude.
        """
        near = np.clip(self._index(place[None]).round().astype(int)[:, 0], 0, np.array(self.settled.shape) - 1)
        state: Floats = self.states[tuple(near)].copy()
        state[:3] = place
        return state

    def _index(self, places: Floats) -> Floats:
        return np.stack([(p - a[0]) / (a[1] - a[0]) for p, a in zip(places.T, self.axes, strict=True)])

    @property
    def _splines(self) -> list[Floats]:
        from scipy.ndimage import spline_filter

        kept = self.__dict__.get("_kept")
        if kept is None:
            kept = [spline_filter(self.velocity[..., i], order=3, mode="nearest") for i in range(3)]
            object.__setattr__(self, "_kept", kept)
        return list(kept)


def slow_flow(
    orbit: Orbit,
    *,
    low: Floats | None = None,
    high: Floats | None = None,
    shape: tuple[int, int, int] = SHAPE,
    lag_stages: int = LAG_STAGES,
    progress: Callable[[float], None] | None = None,
) -> SlowFlow:
    """Work out the slow flow around an orbit on a grid.

    Parameters
    ----------
    orbit
        One that was found: of the two ways that the nose may point along the field's axis, the flow has the orbit's.
    low, high
        Corners (3,) of the grid, moving frame, m. Default: below the magnet, wide of it by half its distance.
    shape
        Nodes along x, y and z; at least four each.
    lag_stages
        0 for attitudes that settle in a place that is held; each further stage lets them lag behind the drift better.
    progress
        Called with the fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    SlowFlow
        Velocities (m/s) on the grid, nan where nothing settles.

    Raises
    ------
    InputError
        Where the orbit was not found, the grid is none, or the device keeps in step with the field nowhere on it.
    """
    if not orbit.found:
        raise InputError(f"a slow flow needs an orbit that was found; got '{orbit.status}'")
    scenario = orbit.scenario
    watch = Watch(progress)
    problem = Problem([scenario], watch=watch)
    default = default_box(scenario, problem.arm[0])
    corners = [
        np.asarray(own if given is None else given, float) for given, own in zip((low, high), default, strict=True)
    ]
    if min(shape) < 4 or lag_stages < 0 or np.any(corners[0] >= corners[1]):
        raise InputError("a slow flow needs at least four nodes a side, low below high, and lag_stages of zero or more")
    axes = tuple(np.linspace(a, b, n) for a, b, n in zip(*corners, shape, strict=True))
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    first = problem.watched(watch.turn(0, 1 + lag_stages))
    states, settled = _settled(first, places, sense_of(problem, orbit.state))
    settled = settled.reshape(shape)
    states = _filled(states.reshape(*shape, 7), settled)
    velocity, settled = _drift(problem, states, settled, axes)
    for stage in range(lag_stages):
        states = _filled(states, settled)
        slope = _attitude_slope(states, problem.length[0])
        states, settled = _lagged(problem, states, settled, slope)
        velocity, settled = _drift(problem, states, settled, axes)
        watch((2.0 + stage) / (1.0 + lag_stages))
    return SlowFlow(scenario, axes, velocity, states, settled)  # type: ignore[arg-type]


def _settled(problem: Problem, places: Floats, sense: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Attitudes that repeat themselves with the head held."""
    states, good = np.zeros((len(places), 7)), np.zeros(len(places), dtype=bool)
    gap = np.linalg.norm(places - problem.arm[0], axis=1)
    clear = np.flatnonzero(gap > 1.05 * problem.contact[0])
    states[:, :3], states[:, 3] = places, 1.0
    for begin in range(0, clear.size, BATCH):
        part = clear[begin : begin + BATCH]
        which = np.zeros(part.size, dtype=np.int64)
        share = problem.watch.part(begin / clear.size, (begin + part.size) / clear.size)
        states[part], good[part] = settle(problem.watched(share), which, attitudes(problem, 0, places[part], sense))
    return states, good


def _filled(values: Floats, good: NDArray[np.bool_]) -> Floats:
    """The values with those of nodes that are not good taken from the nearest that are."""
    from scipy.ndimage import distance_transform_edt

    if not good.any():
        raise InputError("nowhere in this box does the device keep in step with the field: choose another box")
    if good.all():
        return values
    nearest = distance_transform_edt(~good, return_distances=False, return_indices=True)
    result = values[tuple(nearest)]
    if values.shape[-1] == 7:
        result[..., :3] = values[..., :3]
    return np.asarray(result)


def _drift(
    problem: Problem, states: Floats, settled: NDArray[np.bool_], axes: tuple[Floats, ...]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Velocity at each node (m/s) of the flow whose map over a period displaces as the device is displaced; and where.

    A flow v displaces by T v + T^2/2 (grad v) v + ...; the second term is taken off.
    """
    flat = states.reshape(-1, 7)
    images, _ = problem.map(np.zeros(len(flat), dtype=np.int64), flat)
    moved = (images[:, :3] - flat[:, :3]).reshape(*settled.shape, 3)
    moved = np.clip(np.nan_to_num(moved, nan=np.inf), -FAR, FAR)  # a device in the magnet goes anywhere
    gap = np.linalg.norm(states[..., :3] - problem.arm[0], axis=-1)
    slow = settled & (np.linalg.norm(moved, axis=-1) < SLOW * gap)
    moved[~slow] = 0.0
    moved = _filled(moved, slow)
    gradient = np.stack([np.gradient(moved, axis, axis=i) for i, axis in enumerate(axes)], axis=-1)
    return np.asarray((moved - 0.5 * np.einsum("...ij,...j->...i", gradient, moved)) / problem.period[0]), slow


def _attitude_slope(states: Floats, length: float) -> Floats:
    """Derivative (..., 3, 3) of the attitude (rotation vector in body axes) by place over ``length``."""
    result = np.zeros((*states.shape[:3], 3, 3))
    ones = np.full(states.shape[:3], length)
    for i in range(3):
        after, before = np.roll(states, -1, axis=i), np.roll(states, 1, axis=i)
        ends = [slice(None)] * 3
        ends[i] = slice(-1, None)
        after[tuple(ends)] = states[tuple(ends)]
        ends[i] = slice(0, 1)
        before[tuple(ends)] = states[tuple(ends)]
        turn = chart.coordinates(after, states, ones)[..., 3:] - chart.coordinates(before, states, ones)[..., 3:]
        span = (after[..., i] - before[..., i]) / length
        result[..., i] = turn / span[..., None]
    return result


def _lagged(
    problem: Problem, states: Floats, settled: NDArray[np.bool_], slope: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Attitudes that after one free period are the ones of the place then reached, to first order in the step."""
    flat, slopes = states.reshape(-1, 7).copy(), slope.reshape(-1, 3, 3)
    good = settled.ravel().copy()
    every = np.flatnonzero(good)
    for begin in range(0, every.size, BATCH):
        part = every[begin : begin + BATCH]
        which = np.zeros(part.size, dtype=np.int64)
        value, jacobian, _ = problem.linearized(which, flat[part], columns=ROTATION)
        excess = value[:, 3:] - np.einsum("nij,nj->ni", slopes[part], value[:, :3])
        matrix = jacobian[:, 3:, 3:] - np.eye(3) - slopes[part] @ jacobian[:, :3, 3:]
        turn = np.linalg.solve(matrix, -excess[:, :, None])[:, :, 0]
        fine = np.isfinite(turn).all(axis=1) & (np.linalg.norm(turn, axis=1) < 0.5)
        step = np.concatenate([np.zeros((part.size, 3)), np.where(fine[:, None], turn, 0.0)], axis=1)
        flat[part] = chart.moved(flat[part], step, problem.length[which])
        good[part[~fine]] = False
    result = good.reshape(settled.shape)
    return _filled(flat.reshape(states.shape), result), result
