"""Maps over two inputs around the present point: gains of runs, coarse first; stability, and where exactly it ends."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from helimag.engine import advance
from helimag.errors import InputError
from helimag.orbits import boundary_of, seeds_within, stability_map
from helimag.outcomes import End
from helimag.scenario import Scenario
from helimag.studio.knobs import Knob

NODES = 25  # along each input; coarse maps take every 4th and every 2nd of them
STEPS = (4, 2, 1)
BATCH = 8
BOUNDARY_NODES = 9
WIDTHS = {"near": 0.1, "around": 0.25, "wide": 0.6}  # half of the map, in shares of the slider's range
THREADS = max(1, (os.cpu_count() or 2) - 1)  # one core stays for the live run

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Axis2D:
    """One axis of a map, in the knob's shown unit."""

    knob: Knob
    low: float
    high: float

    @classmethod
    def around(cls, knob: Knob, scenario: Scenario, width: str) -> "Axis2D":
        """About the present value, within what the slider reaches.

        Raises
        ------
        InputError
            Where the scenario has no such input.
        """
        here = knob.value(scenario)
        if here is None:
            raise InputError(f"{knob.label} is not given in this scenario")
        half = WIDTHS[width] * (knob.high - knob.low)
        low = max(min(knob.low, here), here - half)
        return cls(knob, low, max(min(max(knob.high, here), here + half), low + 1e-3 * half))

    @property
    def values(self) -> list[float]:
        """Of the nodes."""
        return [float(value) for value in np.linspace(self.low, self.high, NODES)]

    @property
    def ranged(self) -> tuple[float, float]:
        """Ends in SI."""
        return self.low * self.knob.scale, self.high * self.knob.scale


@dataclass(frozen=True)
class MapPlane:
    """A scenario and the two inputs that a map varies."""

    scenario: Scenario
    first: Axis2D
    second: Axis2D

    def at(self, x: float, y: float) -> Scenario:
        """The scenario at a place.

        Raises
        ------
        InputError
            Where there is none.
        """
        return self.second.knob.changed(self.first.knob.changed(self.scenario, x), y)

    @property
    def key(self) -> str:
        """The same for all scenarios that this map is of."""
        return self.at(self.first.low, self.second.low).hash

    def holds_for(self, scenario: Scenario) -> bool:
        """Whether the map is of this scenario, wherever it lies in it."""
        try:
            return MapPlane(scenario, self.first, self.second).key == self.key
        except InputError:
            return False


# what the page draws: centre x, y, width, height, number, verdict, words, whether inside
Cell = tuple[float, float, float, float, float | None, str, str, bool]


def gain_cells(plane: MapPlane, step: int, done: set[tuple[int, int]], progress: Progress) -> Iterator[list[Cell]]:
    """Cells of the nodes at every ``step`` that are not ``done`` yet, some at a time; marks them as done."""
    nodes = [(i, j) for j in range(0, NODES, step) for i in range(0, NODES, step) if (i, j) not in done]
    for begin in range(0, len(nodes), BATCH):
        part = nodes[begin : begin + BATCH]
        progress(begin / len(nodes))
        yield _judged(plane, part, step, progress)
        done.update(part)


def _judged(plane: MapPlane, nodes: list[tuple[int, int]], step: int, progress: Progress) -> list[Cell]:
    xs, ys = plane.first.values, plane.second.values
    wide, high = step * (xs[1] - xs[0]), step * (ys[1] - ys[0])
    cells: list[Cell] = []
    scenarios: dict[tuple[int, int], Scenario] = {}
    for i, j in nodes:
        try:
            scenarios[i, j] = plane.at(xs[i], ys[j])
        except InputError as error:
            cells.append((xs[i], ys[j], wide, high, None, "failed", str(error)[:120], False))
    if not scenarios:
        return cells
    for (i, j), history in zip(
        scenarios, advance(list(scenarios.values()), threads=THREADS, progress=progress), strict=True
    ):
        if history.status is End.NOT_FINITE:
            cells.append((xs[i], ys[j], wide, high, None, "failed", "no run: its numbers broke down", False))
            continue
        judged = history.judge()
        words = f"{judged.verdict}, gain {judged.gain:.3f}"
        verdict = judged.verdict
        cells.append((xs[i], ys[j], wide, high, judged.gain, str(verdict), words, verdict.inside))
    return cells


@dataclass(frozen=True)
class Stability:
    """Cells by the growth rate of the orbit there, and curves where stability ends."""

    cells: list[Cell]
    curves: list[dict[str, object]]


def stability(plane: MapPlane, nodes: int, progress: Progress) -> Stability:
    """Orbits over a grid and the exact boundary of where they are stable.

    Raises
    ------
    InputError
        Where the scenario has no orbits: a sampled path, walls.
    """
    first, second = plane.first, plane.second
    xs, ys = (np.linspace(*axis.ranged, nodes) for axis in (first, second))
    ranges = {axis.knob.path: axis.ranged for axis in (first, second)}
    seeds = seeds_within(plane.scenario, ranges, progress=lambda share: progress(0.1 * share))
    found = stability_map(
        plane.scenario,
        (first.knob.path, xs),
        (second.knob.path, ys),
        seeds=seeds,
        progress=lambda share: progress(0.1 + 0.5 * share),
    )
    curves = boundary_of(found, progress=lambda share: progress(0.6 + 0.4 * share))
    a, b = first.knob.scale, second.knob.scale
    wide, high = float(xs[1] - xs[0]) / a, float(ys[1] - ys[0]) / b
    cells: list[Cell] = []
    for i, x in enumerate(xs):
        for j, y in enumerate(ys):
            rate = float(found.growth[i, j])
            known = bool(np.isfinite(rate))
            told = f"e-fold in {1.0 / abs(rate):.0f} s" if known and rate else ""
            words = "no orbit found" if not known else f"{'stable, decays' if rate < 0 else 'unstable, grows'} {told}"
            cells.append((float(x) / a, float(y) / b, wide, high, rate if known else None, "", words, known))
    lines: list[dict[str, object]] = [
        {"kind": str(curve.kind), "points": np.column_stack([curve.first / a, curve.second / b]).tolist()}
        for curve in curves
    ]
    return Stability(cells, lines)
