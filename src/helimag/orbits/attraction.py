"""Basin of attraction of a stable orbit: from which places a device that is let go comes to it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag._integrate import Status
from helimag.errors import InputError
from helimag.orbits._problem import Floats, Problem
from helimag.orbits._starts import attitudes, sense_of, settle, to_lab, to_moving
from helimag.orbits.averaging import SlowFlow, averaged_paths
from helimag.orbits.orbit import Orbit
from helimag.simulation import advance

NEAR = 0.03  # of the distance: a run that spends its last quarter this near its orbit has come to it
SHRINKS = 0.95  # from the third quarter to the last, of the farthest distance: a run that still comes nearer counts
SHORTEST, LONGEST = 1200.0, 20_000.0  # s, of the runs
SAMPLES = 160


@dataclass(frozen=True)
class Basin:
    """Which starts of a grid come to the orbit.

    Attributes
    ----------
    places
        (n, 3): starts, moving frame, m; each with its settled attitude.
    captured
        (n,): which come to the orbit.
    ends
        (n,): how each run ended: "captured", "stayed" (inside, but not nearer), "attracted", "fell", "wall-limited",
        "out of step" (no attitude to start with), "left" (the averaged model's grid).
    volume
        m^3 of the starts that are captured: cells of the grid.
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
    """Let devices go at the nodes of a grid, and see which come to the orbit.

    Parameters
    ----------
    orbit
        A stable one.
    low, high
        Corners (3,) of the grid, moving frame, m.
    duration
        Of each run, s; default the orbit's longest decay time, within 1200 s and 20,000 s.
    flow
        Judge by the averaged model of this slow flow instead of by full runs: faster, less exact.
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        Where the orbit is not stable or the box is empty.
    """
    if not orbit.stable:
        raise InputError(f"a basin needs a stable orbit; this one is not: {orbit.text}")
    corners = np.asarray(low, float), np.asarray(high, float)
    if corners[0].shape != (3,) or corners[1].shape != (3,) or not np.all(corners[0] < corners[1]) or min(shape) < 2:
        raise InputError("a basin needs a box, low below high on each axis, and at least two starts a side")
    time = float(np.clip(-1.0 / orbit.growth, SHORTEST, LONGEST)) if duration is None else duration
    axes = [np.linspace(a, b, n) for a, b, n in zip(*corners, shape, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    judge = _by_runs if flow is None else _by_flow
    ends = judge(orbit, places, time, flow, progress)
    captured = ends == "captured"
    cell = float(np.prod([(axis[1] - axis[0]) for axis in axes]))
    engine = "full" if flow is None else "averaged"
    return Basin(orbit, shape, places, captured, ends, cell * int(captured.sum()), time, engine)


def _by_runs(
    orbit: Orbit, places: Floats, duration: float, _: SlowFlow | None, progress: Callable[[float], None] | None
) -> NDArray[np.str_]:
    problem = Problem([orbit.scenario])
    ends = np.full(len(places), "out of step", dtype="<U12")
    clear = np.flatnonzero(np.linalg.norm(places - problem.arm[0], axis=1) > 1.05 * problem.contact[0])
    guesses = attitudes(problem, 0, places[clear], sense_of(problem, orbit.state))
    states, found = settle(problem, np.zeros(clear.size, dtype=np.int64), guesses)
    good = clear[found]
    period = 1.0 / abs(orbit.scenario.drive.frequency)
    stride = max(1, round(duration / (SAMPLES * period))) * period
    scenario = orbit.scenario.replaced({"run.duration": SAMPLES * stride, "run.interval": stride})
    if good.size == 0:
        return ends
    starts = to_lab(scenario, np.zeros(good.size), states[found])
    for node, history in zip(
        good, advance([scenario] * good.size, initial_states=starts, progress=progress), strict=True
    ):
        match history.status:
            case Status.HORIZON:
                path = to_moving(scenario, stride * np.arange(SAMPLES + 1, dtype=np.float64), history.states)[:, :3]
                ends[node] = _verdict(orbit, path)
            case Status.CONTACT:
                ends[node] = "attracted"
            case Status.FALL:
                ends[node] = "fell"
            case _:
                ends[node] = "wall-limited"
    return ends


def _by_flow(
    orbit: Orbit, places: Floats, duration: float, flow: SlowFlow | None, progress: Callable[[float], None] | None
) -> NDArray[np.str_]:
    """The averaged model from all starts at once."""
    if flow is None:
        raise InputError("the averaged model needs its slow flow")
    paths = averaged_paths(flow, places, np.linspace(0.0, duration, SAMPLES + 1))
    if progress is not None:
        progress(1.0)
    stays = np.asarray(np.isfinite(paths).all(axis=(1, 2)))
    return np.array(
        [_verdict(orbit, path) if ok else "left" for path, ok in zip(paths, stays, strict=True)], dtype="<U12"
    )


def _verdict(orbit: Orbit, path: Floats) -> str:
    away = np.linalg.norm(path - orbit.position, axis=1)
    third, last = (float(part.max()) for part in np.array_split(away, 4)[2:])
    near = last < NEAR * orbit.scenario.drive.distance
    return "captured" if near or last < SHRINKS * third else "stayed"
