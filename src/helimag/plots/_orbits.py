"""Figures of orbits: a branch over one input, and stability over two."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits import BoundaryCurve, Branch, Orbit, StabilityMap
from helimag.plots._curves import draw_curves
from helimag.plots._style import BLUE, GREY, MM, ORANGE, VERMILLION, Size, fill, head, legend_below, styled
from helimag.scenario import Input, drive_inputs

Floats = NDArray[np.float64]

MARKS = {"fold": "s", "Neimark-Sacker": "o", "period doubling": "^", "branch point": "D"}
WORDS = {True: "stable", False: "unstable"}
NOWHERE = "no stable orbit in these ranges"
HEIGHTS: dict[str, Callable[[Orbit], float]] = {
    "mean height (mm)": lambda orbit: 1e3 * float(orbit.mean_position[2]),
    "leading rate (1/s)": lambda orbit: orbit.growth,
}


def _axis_name(given: Input, unit: str) -> str:
    return f"{given.name} ({unit})" if unit else given.name


def draw_branches(branches: Sequence[Branch], *, size: Size = "print") -> Figure:
    """Draw branches over one input: height of the orbit and leading rate, stable full, unstable dashed, changes marked.

    Returns
    -------
    matplotlib.figure.Figure
        Heights in mm, rates in 1/s; 88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    given, scenario = Input(branches[0].path), branches[0].points[0].orbit.scenario
    unit = given.shown(scenario, branches[0].points[0].value)[1]
    with styled(size) as sheet:
        figure = sheet.figure((130.0 if sheet.narrow else 78.0) * MM)
        axes = figure.subplots(2, 1, sharex=True) if sheet.narrow else figure.subplots(1, 2)
        for axis, (label, height) in zip(axes, HEIGHTS.items(), strict=True):
            for branch in branches:
                _draw_branch(axis, branch, height)
            axis.set_ylabel(label)
        for axis in axes[1:] if sheet.narrow else axes:
            axis.set_xlabel(_axis_name(given, unit))
        axes[1].axhline(0.0, color=GREY, linewidth=0.5)
        title = ", ".join(part for part in scenario.title.split(", ") if not part.startswith(f"{given.path} "))
        head(figure, f"{title}\n{drive_inputs(scenario, without=[given.path])}")
        lines, labels = axes[0].get_legend_handles_labels()
        once = dict(zip(labels, lines, strict=True))
        axes[0].legend(once.values(), once.keys())
    return figure


def _draw_branch(axis: Axes, branch: Branch, height: Callable[[Orbit], float]) -> None:
    given, scenario = Input(branch.path), branch.points[0].orbit.scenario
    looks: dict[bool, Any] = {True: {"color": BLUE}, False: {"color": VERMILLION, "linestyle": "--"}}
    for stable, stretch in _stretches(branch):
        values = [given.shown(scenario, value)[0] for value, _ in stretch]
        axis.plot(values, [height(orbit) for _, orbit in stretch], label=WORDS[stable], **looks[stable])
    for event in branch.events:
        at = given.shown(scenario, event.value)[0]
        axis.plot(at, height(event.orbit), MARKS[event.kind], color=ORANGE, label=str(event.kind), markersize=4)


def _stretches(branch: Branch) -> list[tuple[bool, list[tuple[float, Orbit]]]]:
    """Values and orbits from one event to the next, both included; and whether the orbits between are stable."""
    begun: list[tuple[float, Orbit]] = []
    result, stable = [], False
    for index in range(len(branch.points) + 1):
        for event in (event for event in branch.events if event.index == index):
            result.append((stable, [*begun, (event.value, event.orbit)]))
            begun, stable = [(event.value, event.orbit)], False
        if index < len(branch.points):
            point = branch.points[index]
            stable = point.orbit.stable
            begun.append((point.value, point.orbit))
    return [each for each in [*result, (stable, begun)] if len(each[1]) > 1]


def draw_stability(result: StabilityMap, curves: Sequence[BoundaryCurve] = (), *, size: Size = "print") -> Figure:
    """Draw where orbits are stable over two inputs: decay time in colour, and the curves where stability ends as lines.

    Parameters
    ----------
    curves
        As :func:`helimag.orbits.boundary_of` gives them, over the map's inputs.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88, 120 or 160 mm wide.

    Raises
    ------
    InputError
        Where curves are over other inputs.
    """
    inputs = Input(result.paths[0]), Input(result.paths[1])
    if any(curve.paths != result.paths for curve in curves):
        raise InputError(f"curves must be over the map's inputs, {result.paths[0]} and {result.paths[1]}")
    scales = [_scale(given, result) for given in inputs]
    first, second = (values * scale for values, (scale, _) in zip(result.values, scales, strict=True))
    decay = np.where(result.stable, -1.0 / np.where(result.stable, result.growth, -1.0), np.nan)
    with styled(size) as sheet:
        figure = sheet.figure(95.0 * MM, share=2.0 / 3.0)
        axis = figure.subplots()
        if result.stable.any():
            image = axis.pcolormesh(first, second, decay.T, cmap="viridis", shading="nearest", norm=_scale_of(decay))
            figure.colorbar(image, ax=axis, label="longest decay time (s)", extend="max")
        else:  # a scale of colours that nothing has would look like a failed drawing
            axis.text(0.5, 0.5, NOWHERE, transform=axis.transAxes, ha="center", va="center")
        told = drive_inputs(result.scenario, without=result.paths)
        title = axis.set_title("", fontsize=sheet.points(7.5))
        fill(title, f"{result.scenario.title}\n{told}", 0.85 * figure.bbox.width)
        looks = draw_curves(axis, curves, scales=(scales[0][0], scales[1][0]))
        axis.set_xlim(first[0], first[-1])
        axis.set_ylim(second[0], second[-1])
        axis.set_xlabel(_axis_name(inputs[0], scales[0][1]))
        axis.set_ylabel(_axis_name(inputs[1], scales[1][1]))
        if looks:
            legend_below(figure, looks, most=4)
    return figure


def _scale_of(decay: Floats) -> LogNorm:
    """Colours over the decay times; those beside a Neimark-Sacker curve, which have no limit, share the last one."""
    shortest, longest = float(np.nanmin(decay)), float(np.nanmax(decay))
    return LogNorm(shortest, max(min(longest, 30.0 * shortest), 2.0 * shortest))


def _scale(given: Input, result: StabilityMap) -> tuple[float, str]:
    number, unit = given.shown(result.scenario, 1.0)
    return number, unit
