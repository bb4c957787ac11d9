"""Fixed points of a slow flow: where the averaged device stands still in the moving frame, and as which orbits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from helimag.orbits.averaged.averaging import SlowFlow
from helimag.orbits.strobe import Floats, Orbit, Problem, Watch, sense_of, settle

ITERATIONS = 40
STRIDE = 0.02  # of a cell, for the flow's derivatives
CLOSED = 1e-7  # of a cell: a Newton step this short has arrived
SAME = 0.02  # of a cell: two searches that end this near found one point
SETTLED = 1e-3  # of the attitude's first error, before the drift is measured
MOST_TURNS = 2000  # waiting for that
BESIDE = 1.0  # cell: an orbit farther from a fixed point than this is not the one that it stands for


@dataclass(frozen=True)
class FixedPoint:
    """A zero of a slow flow.

    Attributes
    ----------
    position
        (3,), m, moving frame, at the start of the magnet's turn.
    rates
        (3,) eigenvalues of the flow there (1/s), leading first.
    error
        m: how far the full model's point of rest lies from here, by the drift that the full model has here; nan where
        that cannot be told.
    """

    position: Floats
    rates: NDArray[np.complex128]
    error: float

    @property
    def stable(self) -> bool:
        """Whether every small displacement dies out in the averaged model."""
        return bool(np.all(self.rates.real < 0.0))

    @property
    def kind(self) -> str:
        """Sink, saddle or source, and whether places near it swing."""
        growing = int(np.count_nonzero(self.rates.real > 0.0))
        swings = "spiral " if np.any(np.abs(self.rates.imag) > 0.0) else ""
        name = {0: "sink", 3: "source"}.get(growing, f"saddle, {growing} of 3 directions unstable")
        return swings + name


@dataclass(frozen=True)
class Counterpart:
    """A fixed point and the orbit that it stands for; either may be missing."""

    point: FixedPoint | None
    orbit: Orbit | None

    @property
    def distance(self) -> float:
        """Between the two, m; nan where one is missing."""
        if self.point is None or self.orbit is None:
            return float("nan")
        return float(np.linalg.norm(self.point.position - self.orbit.position))


def fixed_points(flow: SlowFlow, *, progress: Callable[[float], None] | None = None) -> list[FixedPoint]:
    """All zeros of the flow that Newton's method finds from every node and the middle of every cell, most stable first.

    The flow is the tricubic spline of :meth:`SlowFlow.at`. A zero in a part of the grid without settled attitudes is
    not found. ``progress`` is called with a rough fraction done, some times a second; what it raises stops the search.
    """
    watch = Watch(progress)
    places = _zeros(flow, watch.part(0.0, 0.5))
    points = [_point(flow, place, watch.part(0.5, 1.0).turn(i, len(places))) for i, place in enumerate(places)]
    watch(1.0)
    return sorted(points, key=lambda point: float(point.rates.real.max()))


def _zeros(flow: SlowFlow, watch: Watch) -> list[Floats]:
    """Places (3,) where the flow stands still, each once."""
    cell = np.array([axis[1] - axis[0] for axis in flow.axes])
    at = _starts(flow)
    arrived: list[Floats] = []
    for iteration in range(ITERATIONS):
        watch(iteration / ITERATIONS)
        value, slope = _linear(flow, at, cell)
        good = np.isfinite(value).all(axis=1) & np.isfinite(slope).all(axis=(1, 2))
        at, value, slope = at[good], value[good], slope[good]
        regular = np.abs(np.linalg.det(slope)) > 0.0
        at, value, slope = at[regular], value[regular], slope[regular]
        step = -np.linalg.solve(slope, value[:, :, None])[:, :, 0]
        length = np.linalg.norm(step / cell, axis=1)
        at = at + step / np.maximum(length, 1.0)[:, None]
        arrived += list(at[length < CLOSED])
        at = at[length >= CLOSED]
        if not len(at):
            break
    places: list[Floats] = []
    for place in arrived:
        if not any(np.linalg.norm((place - other) / cell) < SAME for other in places):
            places.append(place)
    return places


def counterparts(points: Sequence[FixedPoint], orbits: Sequence[Orbit], flow: SlowFlow) -> list[Counterpart]:
    """Fixed points beside orbits, nearest first come; orbits that the flow cannot have are left out.

    Those lie outside its grid, or have their nose the other way along the field's axis.
    """
    cell = float(np.linalg.norm([axis[1] - axis[0] for axis in flow.axes]))
    left = [orbit for orbit in orbits if _of_flow(orbit, flow)]
    pairs = []
    near = [
        (float(np.linalg.norm(p.position - o.position)), i, j) for i, p in enumerate(points) for j, o in enumerate(left)
    ]
    taken: tuple[set[int], set[int]] = (set(), set())
    for distance, i, j in sorted(near):
        if distance < BESIDE * cell and i not in taken[0] and j not in taken[1]:
            taken[0].add(i)
            taken[1].add(j)
            pairs.append((i, Counterpart(points[i], left[j])))
    pairs += [(i, Counterpart(point, None)) for i, point in enumerate(points) if i not in taken[0]]
    ordered = [pair for _, pair in sorted(pairs, key=lambda entry: entry[0])]
    return ordered + [Counterpart(None, orbit) for j, orbit in enumerate(left) if j not in taken[1]]


def averaged_rates(flow: SlowFlow, orbit: Orbit) -> NDArray[np.complex128]:
    """Eigenvalues (3,) of the averaged model at an orbit (1/s), leading first: compare with its slowest rates.

    They are nan where the flow is not known all around the orbit.
    """
    step = 2e-3 * orbit.scenario.drive.distance
    offsets = step * np.eye(3)
    place = orbit.position
    columns = (flow.at(place + offsets) - flow.at(place - offsets)) / (2.0 * step)
    if not np.isfinite(columns).all():
        return np.full(3, np.nan, dtype=np.complex128)
    values = np.linalg.eigvals(columns.T).astype(np.complex128)
    return np.asarray(values[np.argsort(-values.real)])


def _of_flow(orbit: Orbit, flow: SlowFlow) -> bool:
    inside = all(axis[0] <= x <= axis[-1] for axis, x in zip(flow.axes, orbit.position, strict=True))
    return inside and sense_of(Problem([flow.scenario]), orbit.state) == _sense(flow)


def _sense(flow: SlowFlow) -> float:
    """Which way along the field's axis the nose points in this flow."""
    return sense_of(Problem([flow.scenario]), flow.states[flow.settled][0])


def _starts(flow: SlowFlow) -> Floats:
    nodes = [np.asarray(axis) for axis in flow.axes]
    middles = [(axis[1:] + axis[:-1]) / 2.0 for axis in flow.axes]
    return np.array([*product(*nodes), *product(*middles)])


def _linear(flow: SlowFlow, places: Floats, cell: Floats) -> tuple[Floats, Floats]:
    """Velocity (n, 3) and its derivatives (n, 3, 3) at places (n, 3)."""
    stride = STRIDE * cell
    offsets = np.concatenate([np.zeros((1, 3)), np.diag(stride), -np.diag(stride)])
    values = flow.at((places[:, None, :] + offsets).reshape(-1, 3)).reshape(-1, 7, 3)
    slope = (values[:, 1:4] - values[:, 4:]) / (2.0 * stride[:, None])
    return values[:, 0], np.swapaxes(slope, 1, 2)


def _point(flow: SlowFlow, place: Floats, watch: Watch) -> FixedPoint:
    cell = np.array([axis[1] - axis[0] for axis in flow.axes])
    slope = _linear(flow, place[None], cell)[1][0]
    rates = np.linalg.eigvals(slope).astype(np.complex128)
    return FixedPoint(place, rates[np.argsort(-rates.real, kind="stable")], _error(flow, place, slope, watch))


def _error(flow: SlowFlow, place: Floats, slope: Floats, watch: Watch) -> float:
    """Distance to the full model's point of rest: its drift less the flow's, over the flow's slope.

    The drift is measured after the attitude has settled in a free run from the place. Over a period T a flow v moves
    the device by T v + T^2/2 (grad v) v.
    """
    problem, one = Problem([flow.scenario], watch=watch), np.zeros(1, dtype=np.int64)
    period = float(problem.period[0])
    state, _ = settle(problem, one, flow.state_at(place)[None])
    _, jacobian, _ = problem.linearized(one, state, columns=range(3, 6))
    if not np.isfinite(jacobian).all():
        return float("nan")
    slowest = float(np.abs(np.linalg.eigvals(jacobian[0, 3:, 3:])).max())
    turns = int(np.ceil(np.log(SETTLED) / np.log(slowest))) if 0.0 < slowest < 1.0 else MOST_TURNS
    state, _ = problem.map(one, state, periods=min(max(turns, 1), MOST_TURNS))
    image, _ = problem.map(one, state)
    moved = (image[0, :3] - state[0, :3]) / period
    drift = np.linalg.solve(np.eye(3) + 0.5 * period * slope, moved)
    difference = drift - flow.at(state[:, :3])[0]
    return float(np.linalg.norm(np.linalg.solve(slope, difference)))
