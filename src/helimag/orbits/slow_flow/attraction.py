"""Basin of attraction of a stable orbit: from which places a device that is let go comes to it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits.slow_flow.averaging import SlowFlow, averaged_paths
from helimag.orbits.strobe.orbit import Orbit
from helimag.orbits.strobe.problem import Floats, Problem
from helimag.orbits.strobe.starts import attitudes, open_water, sense_of, settle, strobed
from helimag.outcomes import BasinEnd
from helimag.runs.shares import wilson

FEWEST_TURNS = 12  # of the magnet in a run, so that its later quarters can be compared
AT = 1e-3  # of the distance: a run that spends its last quarter this near its orbit has come to it
NEAR = 0.03  # of the distance: this near, it must go no farther in its last quarter than in the third
SHRINKS = 0.95  # from the third quarter to the last, of the farthest distance: a run from afar must come nearer
SHORTEST, LONGEST = 1200.0, 20_000.0  # s, of the runs
SAMPLES = 160
WORDS = f"<U{max(map(len, BasinEnd))}"  # text that holds each of them


@dataclass(frozen=True)
class Basin:
    """Which starts of a grid come to the orbit.

    Attributes
    ----------
    shape
        Starts along x, y and z.
    places
        (n, 3): starts, moving frame, m, z fastest: the centres of the cells; each with its settled attitude.
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
    """

    orbit: Orbit
    shape: tuple[int, int, int]
    places: Floats
    captured: NDArray[np.bool_]
    ends: NDArray[np.str_]
    volume: float
    duration: float
    engine: str

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
    def text(self) -> str:
        """Volume and tally in a sentence."""
        names, counts = np.unique(self.ends, return_counts=True)
        tally = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        return (
            f"basin of {1e6 * self.volume:.1f} cm3 in this box: of {self.ends.size} starts {tally}, judged after "
            f"{self.duration:.0f} s by the {self.engine} model"
        )


def basin(
    orbit: Orbit,
    *,
    low: Floats,
    high: Floats,
    shape: tuple[int, int, int] = (9, 9, 9),
    duration: float | None = None,
    flow: SlowFlow | None = None,
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
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        Where the orbit is not stable, the box is empty, or runs would be too short to tell.
    """
    if not orbit.stable:
        raise InputError(f"a basin needs a stable orbit; this one is not: {orbit.text}")
    corners = np.asarray(low, float), np.asarray(high, float)
    if corners[0].shape != (3,) or corners[1].shape != (3,) or not np.all(corners[0] < corners[1]) or min(shape) < 2:
        raise InputError("a basin needs a box, low below high on each axis, and at least two starts a side")
    time = float(np.clip(-1.0 / orbit.growth, SHORTEST, LONGEST)) if duration is None else duration
    least = FEWEST_TURNS / abs(orbit.scenario.drive.frequency)
    if not time >= least:
        raise InputError(f"duration must be {FEWEST_TURNS} turns of the magnet or more, {least:.3g} s; got {time:g} s")
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(*corners, shape, strict=True)]
    axes = [(edge[1:] + edge[:-1]) / 2.0 for edge in edges]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    if flow is None:
        ends, engine = _by_runs(orbit, places, time, progress), "full"
    else:
        ends, engine = _by_flow(orbit, places, time, flow, progress), "averaged"
    captured = np.asarray(ends == BasinEnd.CAPTURED)
    volume = float(np.prod(corners[1] - corners[0])) * float(captured.mean())
    return Basin(orbit, shape, places, captured, ends, volume, time, engine)


@dataclass(frozen=True)
class Agreement:
    """A basin by the averaged model beside full runs from some of its starts.

    Attributes
    ----------
    starts
        (m,): numbers of the starts that were run.
    averaged, full
        (m,): how each ended by either model.
    """

    starts: NDArray[np.int64]
    averaged: NDArray[np.str_]
    full: NDArray[np.str_]

    @property
    def counts(self) -> dict[str, int]:
        """Starts that both models say come to the orbit, only one of them says so, or neither."""
        averaged, full = self.averaged == BasinEnd.CAPTURED, self.full == BasinEnd.CAPTURED
        masks = {
            "both": averaged & full,
            "only_averaged": averaged & ~full,
            "only_full": full & ~averaged,
            "neither": ~averaged & ~full,
        }
        return {name: int(mask.sum()) for name, mask in masks.items()}

    @property
    def share(self) -> float:
        """Of these starts on which the models agree."""
        return (self.counts["both"] + self.counts["neither"]) / self.starts.size

    @property
    def interval(self) -> tuple[float, float]:
        """Where the share of all starts lies, with 95 per cent."""
        return wilson(self.share, self.starts.size)

    @property
    def text(self) -> str:
        """The comparison in a sentence."""
        low, high = (round(100.0 * end) for end in self.interval)
        counts = self.counts
        return (
            f"of {self.starts.size} starts that full runs judged too, the models agree on {100.0 * self.share:.0f} % "
            f"(of all starts: {low} to {high} %, with 95 % confidence): {counts['both']} captured by both, "
            f"{counts['only_averaged']} by the averaged model only, {counts['only_full']} by full runs only, "
            f"{counts['neither']} by neither"
        )


def agreement(
    caught: Basin, *, starts: int = 60, seed: int = 0, progress: Callable[[float], None] | None = None
) -> Agreement:
    """Judge some starts of a basin by full runs too.

    Parameters
    ----------
    caught
        A basin by the averaged model.
    starts
        How many, drawn without order from all of them.
    seed
        Of the draw.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        Where the basin is one by full runs, or there is no start to compare.
    """
    if caught.engine != "averaged" or starts < 1:
        raise InputError("only a basin by the averaged model, and at least one start of it, can be held against runs")
    every = caught.ends.size
    drawn = np.sort(np.random.default_rng(seed).choice(every, size=min(starts, every), replace=False))
    full = _by_runs(caught.orbit, caught.places[drawn], caught.duration, progress)
    return Agreement(drawn, caught.ends[drawn], full)


def _by_runs(
    orbit: Orbit, places: Floats, duration: float, progress: Callable[[float], None] | None
) -> NDArray[np.str_]:
    problem = Problem([orbit.scenario])
    ends = np.full(len(places), BasinEnd.OUT_OF_STEP, dtype=WORDS)
    clear = np.flatnonzero(np.linalg.norm(places - problem.arm[0], axis=1) > 1.05 * problem.contact[0])
    guesses = attitudes(problem, 0, places[clear], sense_of(problem, orbit.state))
    states, found = settle(problem, np.zeros(clear.size, dtype=np.int64), guesses)
    good = clear[found]
    if good.size == 0:
        return ends
    water = open_water(orbit.scenario)
    runs = strobed(water, duration, samples=SAMPLES, states=states[found], progress=progress)
    for node, run in zip(good, runs, strict=True):
        ends[node] = run.status.basin or _inside(orbit, run.states[:, :3])
    return ends


def _by_flow(
    orbit: Orbit, places: Floats, duration: float, flow: SlowFlow, progress: Callable[[float], None] | None
) -> NDArray[np.str_]:
    """The averaged model from all starts at once."""
    ends = np.full(len(places), BasinEnd.OUT_OF_STEP, dtype=WORDS)
    good = np.flatnonzero(np.isfinite(flow.at(places)).all(axis=1))
    paths = averaged_paths(flow, places[good], np.linspace(0.0, duration, SAMPLES + 1), progress=progress)
    for node, path in zip(good, paths, strict=True):
        ends[node] = _inside(orbit, path) if np.isfinite(path).all() else BasinEnd.LEFT
    return ends


def _inside(orbit: Orbit, path: Floats) -> BasinEnd:
    """What becomes of a device that is still there at the end of its path (n, 3)."""
    return BasinEnd.CAPTURED if comes_to(orbit, path) else BasinEnd.STAYED


def comes_to(orbit: Orbit, path: Floats) -> bool:
    """Whether places (n, 3) of the moving frame, equally spaced in time, at last lie at an orbit or come nearer."""
    away = np.linalg.norm(path - orbit.position, axis=1)
    third, last = (float(part.max()) for part in np.array_split(away, 4)[2:])
    distance = orbit.scenario.drive.distance
    return last < AT * distance or last < (1.0 if last < NEAR * distance else SHRINKS) * third
