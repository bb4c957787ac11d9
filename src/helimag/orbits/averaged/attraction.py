"""Basin of attraction of a stable orbit: from which places a device that is released comes to it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from helimag.engine import start_state
from helimag.errors import InputError
from helimag.orbits.averaged.averaging import SlowFlow, slow_flow
from helimag.orbits.averaged.paths import averaged_paths
from helimag.orbits.strobe import Floats, Orbit, Problem, Watch, attitudes, open_water, sense_of, settle, strobed
from helimag.outcomes import BasinEnd
from helimag.runs.shares import wilson

FEWEST_TURNS = 12  # of the magnet in a run, so that its later quarters can be compared
AT = 1e-3  # of the distance: a run that spends its last quarter this near its orbit has come to it
NEAR = 0.03  # of the distance: this near, it must go no farther in its last quarter than in the third
SHRINKS = 0.95  # from the third quarter to the last, of the farthest distance: a run from afar must come nearer
SHORTEST, LONGEST = 1200.0, 20_000.0  # s, of the runs
SAMPLES = 160
WORDS = f"<U{max(map(len, BasinEnd))}"  # text that holds each of them
Attitude = Literal["settled", "released"]
LET_GO: Mapping[Attitude, str] = {
    "settled": "released with the attitude that it settles to when held there",
    "released": "released as simulate releases, with the attitude of the scenario's start",
}
MARGIN = 1.5  # of the box's half sides: how far a flow that judges it reaches, so that paths may leave it and return
ENGINE_NODES = 15  # of that flow, a side


@dataclass(frozen=True)
class Basin:
    """Which starts of a grid come to the orbit.

    Attributes
    ----------
    shape
        Starts along x, y and z.
    places
        (n, 3): starts, moving frame, m, z fastest: the centres of the cells.
    captured
        (n,): which come to the orbit.
    ends
        (n,): how each run ended, the words of :class:`helimag.outcomes.BasinEnd`.
    volume
        m^3 of the cells whose starts are captured.
    duration
        Of each run, s.
    engine
        "full" or "averaged": by which model.
    attitude
        "settled": with the attitude that the device takes on when held at the start. "released": as ``simulate`` lets
        go, with the attitude of the scenario's start at each place.
    """

    orbit: Orbit
    shape: tuple[int, int, int]
    places: Floats
    captured: NDArray[np.bool_]
    ends: NDArray[np.str_]
    volume: float
    duration: float
    engine: str
    attitude: Attitude = "settled"

    @property
    def axes(self) -> tuple[Floats, Floats, Floats]:
        """Centres of the cells along x, y and z, m."""
        x, y, z = (np.unique(column) for column in self.places.T)
        return x, y, z

    @property
    def cell(self) -> Floats:
        """Sides (3,) of a cell, m."""
        return np.array([(axis[-1] - axis[0]) / (axis.size - 1) for axis in self.axes])

    @property
    def reaches_edge(self) -> bool:
        """Whether cells at a face of the box are captured: the basin then goes on beyond it."""
        captured = self.captured.reshape(self.shape)
        return any(bool(np.take(captured, side, axis=i).any()) for i in range(3) for side in (0, -1))

    @property
    def hasty(self) -> bool:
        """Whether runs ended before the orbit's longest decay time: what had not come to it by then may still come."""
        return self.duration < -1.0 / self.orbit.growth

    @property
    def share(self) -> float:
        """Of the box's cells, how many are captured."""
        return float(self.captured.mean())

    @property
    def interval(self) -> tuple[float, float]:
        """Where the share of the box lies that is captured, with 95 per cent, as if its starts were drawn at random."""
        return wilson(self.share, self.captured.size)

    @property
    def text(self) -> str:
        """Volume and tally in a sentence."""
        whole = 1e6 * float(np.prod(self.cell)) * self.ends.size
        low, high = (whole * end for end in self.interval)
        names, counts = np.unique(self.ends, return_counts=True)
        tally = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        return (
            f"basin of {1e6 * self.volume:.1f} cm3 ({low:.1f} to {high:.1f}) in this box: of {self.ends.size} starts "
            f"{tally}, judged after {self.duration:.0f} s by the {self.engine} model; {LET_GO[self.attitude]}"
        )


def basin(
    orbit: Orbit,
    *,
    low: Floats,
    high: Floats,
    shape: tuple[int, int, int] = (9, 9, 9),
    duration: float | None = None,
    flow: SlowFlow | None = None,
    attitude: Attitude = "settled",
    progress: Callable[[float], None] | None = None,
) -> Basin:
    """Let devices go in the middle of each cell of a box, and see which come to the orbit.

    Parameters
    ----------
    orbit
        A stable one.
    low, high
        Corners (3,) of the box, moving frame, m.
    shape
        Cells along x, y and z; at least two each.
    duration
        Of each run, s; default the orbit's longest decay time, within 1200 s and 20,000 s.
    flow
        Judge by the averaged model of this slow flow instead of by full runs: faster, less exact.
    attitude
        With which the device is released: "settled", that which it takes on when held at the start, or "released", that
        of the scenario's own start, as ``simulate`` releases it; the averaged model knows the settled ones only.
    progress
        Called with the fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Basin
        How the run from each cell ends.

    Raises
    ------
    InputError
        Where the orbit is not stable, the box is empty, runs would be too short to tell, or the averaged model is
        asked for another attitude.
    """
    if attitude not in LET_GO:
        raise InputError(f"attitude must be {' or '.join(LET_GO)}; got {attitude!r}")
    if flow is not None and attitude != "settled":
        raise InputError("attitude must be settled by the averaged model, which knows no other; use full runs")
    corners = _checked(orbit, low, high, shape)
    time = float(np.clip(-1.0 / orbit.growth, SHORTEST, LONGEST)) if duration is None else duration
    least = FEWEST_TURNS / abs(orbit.scenario.drive.frequency)
    if not time >= least:
        raise InputError(f"duration must be {FEWEST_TURNS} turns of the magnet or more, {least:.3g} s; got {time:g} s")
    watch = Watch(progress)
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(*corners, shape, strict=True)]
    axes = [(edge[1:] + edge[:-1]) / 2.0 for edge in edges]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    if flow is None:
        ends, engine = ends_of_runs(orbit, places, time, watch, attitude), "full"
    else:
        ends, engine = _by_flow(orbit, places, time, flow, watch), "averaged"
    watch(1.0)
    captured = np.asarray(ends == BasinEnd.CAPTURED)
    volume = float(np.prod(corners[1] - corners[0])) * float(captured.mean())
    return Basin(orbit, shape, places, captured, ends, volume, time, engine, attitude)


def basin_by_flow(
    orbit: Orbit,
    *,
    low: Floats,
    high: Floats,
    shape: tuple[int, int, int] = (11, 11, 11),
    duration: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Basin:
    """The basin within a box by the averaged model, of a slow flow that reaches half as far again as the box.

    Parameters
    ----------
    orbit, low, high, shape, duration
        As for :func:`basin`.
    progress
        Called with the fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Basin
        How the averaged run from each cell ends.

    Raises
    ------
    InputError
        As for :func:`basin`; and where the device keeps in step with the field nowhere around the box.
    """
    watch = Watch(progress)
    low, high = _checked(orbit, low, high, shape)
    middle, half = (low + high) / 2.0, MARGIN * (high - low) / 2.0
    nodes = ENGINE_NODES, ENGINE_NODES, ENGINE_NODES
    flow = slow_flow(orbit, low=middle - half, high=middle + half, shape=nodes, progress=watch.part(0.0, 0.8))
    return basin(orbit, low=low, high=high, shape=shape, duration=duration, flow=flow, progress=watch.part(0.8, 1.0))


def _checked(orbit: Orbit, low: Floats, high: Floats, shape: tuple[int, int, int]) -> tuple[Floats, Floats]:
    """The box's corners, where a basin in it can be asked for."""
    if not orbit.stable:
        raise InputError(f"a basin needs a stable orbit; this one is not: {orbit.text}")
    corners = np.asarray(low, float), np.asarray(high, float)
    if corners[0].shape != (3,) or corners[1].shape != (3,) or not np.all(corners[0] < corners[1]) or min(shape) < 2:
        raise InputError("a basin needs a box, low below high on each axis, and at least two starts a side")
    return corners


def ends_of_runs(
    orbit: Orbit, places: Floats, duration: float, watch: Watch, attitude: Attitude = "settled"
) -> NDArray[np.str_]:
    """How full runs of a time (s) from places (n, 3) end, each begun with an attitude: see :class:`Basin`."""
    problem = Problem([orbit.scenario], watch=watch.part(0.0, 0.1))
    ends = np.full(len(places), BasinEnd.OUT_OF_STEP, dtype=WORDS)
    clear = np.flatnonzero(np.linalg.norm(places - problem.arm[0], axis=1) > 1.05 * problem.contact[0])
    if attitude == "released":
        ends[:] = BasinEnd.ATTRACTED
        turned = np.broadcast_to(start_state(orbit.scenario)[3:], (clear.size, 4))
        states, good = np.concatenate([places[clear], turned], axis=1), clear
    else:
        guesses = attitudes(problem, 0, places[clear], sense_of(problem, orbit.state))
        settled, found = settle(problem, np.zeros(clear.size, dtype=np.int64), guesses)
        states, good = settled[found], clear[found]
    if good.size == 0:
        return ends
    water = open_water(orbit.scenario)
    runs = strobed(water, duration, samples=SAMPLES, states=states, progress=watch.part(0.1, 1.0))
    for node, run in zip(good, runs, strict=True):
        ends[node] = run.status.basin or _inside(orbit, run.states[:, :3])
    return ends


def _by_flow(orbit: Orbit, places: Floats, duration: float, flow: SlowFlow, watch: Watch) -> NDArray[np.str_]:
    """The averaged model from all starts at once."""
    ends = np.full(len(places), BasinEnd.OUT_OF_STEP, dtype=WORDS)
    good = np.flatnonzero(np.isfinite(flow.at(places)).all(axis=1))
    paths = averaged_paths(flow, places[good], np.linspace(0.0, duration, SAMPLES + 1), progress=watch)
    for node, path in zip(good, paths, strict=True):
        ends[node] = _inside(orbit, path) if np.isfinite(path).all() else BasinEnd.LEFT
    return ends


def _inside(orbit: Orbit, path: Floats) -> BasinEnd:
    """Where a device goes that is still there at the end of its path (n, 3)."""
    return BasinEnd.CAPTURED if comes_to(orbit, path) else BasinEnd.STAYED


def comes_to(orbit: Orbit, path: Floats) -> bool:
    """Whether places (n, 3) of the moving frame, equally spaced in time, at last lie at an orbit or come nearer."""
    away = np.linalg.norm(path - orbit.position, axis=1)
    third, last = (float(part.max()) for part in np.array_split(away, 4)[2:])
    distance = orbit.scenario.drive.distance
    return last < AT * distance or last < (1.0 if last < NEAR * distance else SHRINKS) * third
