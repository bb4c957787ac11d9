"""Figures of orbits: a branch over one input, stability over two, the slow flow, and a basin of attraction."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from helimag.orbits import Basin, BoundaryCurve, Branch, Input, Orbit, SlowFlow, StabilityMap
from helimag.plots._style import BLUE, FULL_WIDTH, GREEN, GREY, MM, ORANGE, PALE, VERMILLION, styled

Floats = NDArray[np.float64]

MARKS = {"fold": "s", "Neimark-Sacker": "o", "period doubling": "^", "branch point": "D"}
FIELDS = 2.0  # streamlines, in matplotlib's measure of density


def _axis_name(given: Input, unit: str) -> str:
    return f"{given.name} ({unit})" if unit else given.name


def draw_branch(branch: Branch) -> Figure:
    """Draw a branch: height of the orbit and leading rate over the input, stable full, unstable dashed, changes marked.

    Returns
    -------
    matplotlib.figure.Figure
        180 mm wide; heights in mm, rates in 1/s.
    """
    given, scenario = Input(branch.path), branch.points[0].orbit.scenario
    values = np.array([given.shown(scenario, point.value)[0] for point in branch.points])
    unit = given.shown(scenario, branch.points[0].value)[1]
    rows = [
        ("mean height (mm)", np.array([1e3 * point.orbit.mean_position[2] for point in branch.points])),
        ("leading rate (1/s)", np.array([point.orbit.growth for point in branch.points])),
    ]
    stable = np.array([point.orbit.stable for point in branch.points])
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 70.0 * MM), layout="constrained")
        axes = figure.subplots(1, 2)
        for axis, (label, heights) in zip(axes, rows, strict=True):
            axis.plot(values, np.where(stable | _beside(stable), heights, np.nan), color=BLUE, label="stable")
            axis.plot(values, np.where(stable, np.nan, heights), color=VERMILLION, linestyle="--", label="unstable")
            axis.set_xlabel(_axis_name(given, unit))
            axis.set_ylabel(label)
        axes[1].axhline(0.0, color=GREY, linewidth=0.5)
        for event in branch.events:
            at = given.shown(scenario, event.value)[0]
            for axis, height in zip(axes, (1e3 * event.orbit.mean_position[2], event.orbit.growth), strict=True):
                axis.plot(at, height, MARKS[event.kind], color=ORANGE, label=str(event.kind), markersize=4)
        axes[0].legend()
    return figure


def _beside(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Neighbours of what is marked, so that lines of two kinds meet."""
    return np.asarray(np.convolve(mask, [1, 1, 1], mode="same") > 0)


def draw_stability(result: StabilityMap, boundary: Sequence[BoundaryCurve] = ()) -> Figure:
    """Draw where orbits are stable over two inputs: decay time in colour, the located boundary on top.

    Returns
    -------
    matplotlib.figure.Figure
        120 mm wide.
    """
    inputs = Input(result.paths[0]), Input(result.paths[1])
    scales = [_scale(given, result) for given in inputs]
    first, second = (values * scale for values, (scale, _) in zip(result.values, scales, strict=True))
    decay = np.where(result.stable, -1.0 / np.where(result.stable, result.growth, -1.0), np.nan)
    with styled():
        figure = Figure(figsize=(120.0 * MM, 90.0 * MM), layout="constrained")
        axis = figure.subplots()
        image = axis.pcolormesh(first, second, np.log10(decay).T, cmap="viridis", shading="nearest")
        figure.colorbar(image, ax=axis, label="log10 of the longest decay time (s)")
        for why in dict.fromkeys(point.why for point in boundary):
            places = [(p.first * scales[0][0], p.second * scales[1][0]) for p in boundary if p.why == why]
            axis.plot(*np.array(places).T, MARKS.get(why, "x"), color=ORANGE, markersize=2.5, label=why)
        axis.set_xlim(first[0], first[-1])
        axis.set_ylim(second[0], second[-1])
        axis.set_xlabel(_axis_name(inputs[0], scales[0][1]))
        axis.set_ylabel(_axis_name(inputs[1], scales[1][1]))
        if boundary:
            axis.legend(loc="upper right", frameon=True)
    return figure


def _scale(given: Input, result: StabilityMap) -> tuple[float, str]:
    number, unit = given.shown(result.scenario, 1.0)
    return number, unit


def draw_flow(flow: SlowFlow, orbit: Orbit, captured: Basin | None = None) -> Figure:
    """Draw the slow flow through an orbit: streamlines in the plane at its height and in two upright planes.

    Parameters
    ----------
    captured
        A basin on any grid, whose starts near each plane are marked: those that come to the orbit full, others open.

    Returns
    -------
    matplotlib.figure.Figure
        180 mm wide; mm, moving frame. Streamlines show the part of the flow within the plane.
    """
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 66.0 * MM), layout="constrained")
        for axis, (i, j) in zip(figure.subplots(1, 3), ((0, 1), (0, 2), (1, 2)), strict=True):
            _plane(axis, flow, orbit, i, j)
            if captured is not None:
                _starts(axis, captured, orbit, i, j)
    return figure


def _plane(axis: Axes, flow: SlowFlow, orbit: Orbit, i: int, j: int) -> None:
    across, up = flow.axes[i], flow.axes[j]
    a, b = np.meshgrid(np.linspace(across[0], across[-1], 41), np.linspace(up[0], up[-1], 41))
    places = np.repeat(orbit.position[None], a.size, axis=0)
    places[:, i], places[:, j] = a.ravel(), b.ravel()
    velocity = 1e3 * flow.at(places)
    speed = np.linalg.norm(velocity, axis=1).reshape(a.shape)
    lines: dict[str, Any] = {"color": GREY, "density": FIELDS * 0.5, "linewidth": 0.5, "arrowsize": 0.5}
    image = axis.pcolormesh(1e3 * a, 1e3 * b, speed, cmap="Blues", shading="nearest", rasterized=True)
    axis.figure.colorbar(image, ax=axis, label="speed (mm/s)", orientation="horizontal")
    axis.streamplot(1e3 * a, 1e3 * b, velocity[:, i].reshape(a.shape), velocity[:, j].reshape(a.shape), **lines)
    axis.plot(1e3 * orbit.position[i], 1e3 * orbit.position[j], "o", color=VERMILLION, markersize=4)
    axis.set_xlabel(f"{'xyz'[i]} (mm)")
    axis.set_ylabel(f"{'xyz'[j]} (mm)")
    axis.set_aspect("equal")


def _starts(axis: Axes, captured: Basin, orbit: Orbit, i: int, j: int) -> None:
    k = 3 - i - j
    levels = np.unique(captured.places[:, k])
    near = captured.places[:, k] == levels[np.argmin(np.abs(levels - orbit.position[k]))]
    for mask, face in ((near & captured.captured, GREEN), (near & ~captured.captured, "none")):
        edge = GREEN if face == GREEN else PALE
        x, y = 1e3 * captured.places[mask][:, [i, j]].T
        axis.scatter(x, y, s=6, facecolors=face, edgecolors=edge, linewidths=0.5)
