"""Figures of what goes on around an orbit: the slow flow with its fixed points, and the basin of attraction."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from helimag.geometry import magnet_start
from helimag.orbits import Basin, FixedPoint, Orbit, SlowFlow
from helimag.outcomes import BasinEnd
from helimag.plots._style import (
    BLUE,
    DARK,
    GREEN,
    GREY,
    MM,
    ORANGE,
    PALE,
    PURPLE,
    SKY,
    VERMILLION,
    WHITE,
    YELLOW,
    Sheet,
    Size,
    head,
    legend_below,
    styled,
)
from helimag.scenario import Scenario, drive_inputs

Floats = NDArray[np.float64]

PLANES = ((0, 1), (0, 2), (1, 2))
ACROSS = 61  # places along a side at which the flow is looked up for the figure
# of the ends, by their numbers and in the order of the legend; the last ones wait for ends to come
PALETTE = (GREEN, SKY, VERMILLION, BLUE, PURPLE, PALE, YELLOW, DARK, WHITE, ORANGE, GREY)
ENDS = dict(zip(BasinEnd, PALETTE, strict=False))
ON: dict[str, Any] = {
    "marker": "o",
    "color": VERMILLION,
    "markersize": 4.5,
    "linestyle": "none",
    "markeredgewidth": 1.0,
}


MIDDLE: dict[str, Any] = {"marker": "+", "linestyle": "none"}


def draw_flow(
    flow: SlowFlow,
    orbit: Orbit,
    captured: Basin | None = None,
    *,
    fixed_points: Sequence[FixedPoint] = (),
    size: Size = "print",
) -> Figure:
    """Draw the slow flow in three planes through an orbit: streamlines over speed, and where it stands still.

    Parameters
    ----------
    captured
        A basin on any grid, whose starts in the planes are marked: those that come to the orbit full, others open.
    fixed_points
        Of the flow: stable ones full, others open; small where they lie more than a cell off the plane.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide; mm, moving frame. Streamlines show the part of the flow within the plane.
    """
    planes = [_plane_of(flow, orbit, i, j) for i, j in PLANES]
    fastest = max(float(np.nanmax(speed, initial=0.0)) for *_, speed in planes)
    with styled(size) as sheet:
        figure, axes = three_panels(sheet)
        for axis, (i, j), (a, b, velocity, speed) in zip(axes, PLANES, planes, strict=True):
            image = axis.pcolormesh(
                a, b, speed, cmap="Blues", vmin=0.0, vmax=1.4 * fastest, shading="nearest", rasterized=True
            )
            axis.set_facecolor(PALE)
            if np.isfinite(speed).any():
                look: dict[str, Any] = {"color": DARK, "density": 1.1, "linewidth": 0.45, "arrowsize": 0.55}
                axis.streamplot(a, b, velocity[..., i], velocity[..., j], **look)
            if captured is not None:
                _starts(axis, captured, orbit, i, j)
            _frame(axis, orbit, i, j, (a[0], a[-1]), (b[0], b[-1]))
            _points(axis, fixed_points, flow, orbit, i, j)
        where: dict[str, Any] = {"location": "bottom", "pad": 0.03} if sheet.narrow else {"pad": 0.01}
        bar = figure.colorbar(image, ax=axes, label="speed of the slow flow (mm/s)", shrink=0.75, **where)
        (bar.ax.set_xlim if sheet.narrow else bar.ax.set_ylim)(0.0, fastest)
        head(figure, f"{orbit.scenario.title}: slow flow\n{drive_inputs(orbit.scenario)}")
        unsettled = not all(np.isfinite(speed).all() for *_, speed in planes)
        explain(figure, _flow_key(fixed_points, captured, unsettled, axes), most=4)
    return figure


def draw_basin(basin: Basin, *, size: Size = "print") -> Figure:
    """Draw a basin of attraction: cells in three planes through the orbit, coloured by how a run from them ends.

    Returns
    -------
    matplotlib.figure.Figure
        In mm, moving frame; 88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide". Each plane is the layer
        of cells nearest to the orbit.
    """
    names = [str(end) for end in ENDS if np.any(basin.ends == end)]
    codes = np.array([names.index(end) for end in basin.ends]).reshape(basin.shape)
    colours = ListedColormap([ENDS[BasinEnd.of(name)] for name in names])
    norm = BoundaryNorm(np.arange(len(names) + 1) - 0.5, colours.N)
    edges = [1e3 * _edges(axis) for axis in basin.axes]
    with styled(size) as sheet:
        figure, axes = three_panels(sheet)
        for axis, (i, j) in zip(axes, PLANES, strict=True):
            k = 3 - i - j
            layer = int(np.argmin(np.abs(basin.axes[k] - basin.orbit.position[k])))
            cells = np.take(codes, layer, axis=k).T
            axis.pcolormesh(
                edges[i], edges[j], cells, cmap=colours, norm=norm, edgecolors="white", linewidth=0.3, rasterized=True
            )
            x, y = 1e3 * basin.orbit.position[[i, j]]
            axis.plot(x, y, marker="*", color="black", markersize=6, markeredgecolor="white", markeredgewidth=0.4)
            _frame(axis, basin.orbit, i, j, (edges[i][0], edges[i][-1]), (edges[j][0], edges[j][-1]))
            axis.set_title(f"{'xyz'[k]} = {_signed(1e3 * basin.axes[k][layer])} mm")
        tally = {name: int(np.count_nonzero(basin.ends == name)) for name in names}
        handles: list[Any] = [Patch(color=ENDS[BasinEnd.of(name)], label=f"{name} ({tally[name]})") for name in names]
        handles.append(Line2D([], [], marker="*", color="black", linestyle="none", label="orbit"))
        explain(figure, handles + magnet_key(axes), most=5)
        scenario = basin.orbit.scenario
        judged = f"judged after {basin.duration:.0f} s by the {basin.engine} model, {basin.attitude} attitude"
        head(figure, f"{scenario.title}: how a run from each cell ends, {judged}\n{drive_inputs(scenario)}")
    return figure


def three_panels(sheet: Sheet) -> tuple[Figure, Sequence[Axes]]:
    """A figure with three panels in a row; in a column of a paper, two above one."""
    if not sheet.narrow:
        figure = sheet.figure(80.0 * MM)
        return figure, list(figure.subplots(1, 3))
    figure = sheet.figure(115.0 * MM)
    first, second, third, fourth = np.ravel(figure.subplots(2, 2))
    fourth.set_axis_off()
    return figure, [first, second, third]


def explain(figure: Figure, handles: Sequence[Any], *, most: int) -> None:
    """The legend: below three panels in a row, in so many columns, or in the place that two rows leave."""
    spare = next((axes for axes in figure.axes if not axes.axison), None)
    if spare is None:
        legend_below(figure, handles, most=most)
    else:
        spare.legend(handles=handles, loc="center", handletextpad=0.4, handlelength=1.4, borderpad=0.0)


def _plane_of(flow: SlowFlow, orbit: Orbit, i: int, j: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Both axes (mm), velocity (m, n, 3) and speed (m, n) in mm/s in the plane through the orbit."""
    across, up = (np.linspace(flow.axes[n][0], flow.axes[n][-1], ACROSS) for n in (i, j))
    a, b = np.meshgrid(across, up)
    places = np.repeat(orbit.position[None], a.size, axis=0)
    places[:, i], places[:, j] = a.ravel(), b.ravel()
    velocity = 1e3 * flow.at(places).reshape(*a.shape, 3)
    return 1e3 * across, 1e3 * up, velocity, np.linalg.norm(velocity, axis=-1)


def _frame(axis: Axes, orbit: Orbit, i: int, j: int, across: tuple[float, float], up: tuple[float, float]) -> None:
    """Limits, names, the plane's place; and the magnet with the sphere of contact where they reach into the frame."""
    k = 3 - i - j
    draw_magnet(axis, orbit.scenario, orbit.position[k], i, j)
    axis.set_xlim(*across)
    axis.set_ylim(*up)
    axis.set_aspect("equal")
    axis.set_xlabel(f"{'xyz'[i]} (mm)")
    axis.set_ylabel(f"{'xyz'[j]} (mm)")
    axis.set_title(f"{'xyz'[k]} = {_signed(1e3 * orbit.position[k])} mm")


def draw_magnet(axis: Axes, scenario: Scenario, level: float, i: int, j: int) -> None:
    """The magnet's centre, and the sphere within which device and magnet touch: cut by the plane, else in outline."""
    place = magnet_start(scenario.drive)
    radius = scenario.contact_distance
    off = float(place[3 - i - j]) - level
    cut = abs(off) < radius
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    size = np.sqrt(radius**2 - off**2) if cut else radius
    x, y = 1e3 * (place[i] + size * np.cos(angle)), 1e3 * (place[j] + size * np.sin(angle))
    axis.plot(x, y, color="black", linewidth=0.8, linestyle="-" if cut else ":", gid="contact")
    axis.plot(1e3 * place[i], 1e3 * place[j], "+", color="black", markersize=5, gid="magnet")


def magnet_key(axes: Any) -> list[Line2D]:
    """Entries for what of the magnet is seen in any frame."""
    handles = {}
    for axis in axes:
        (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
        for line in axis.lines:
            x, y = (np.asarray(values, float) for values in line.get_data())
            if line.get_gid() is None or not np.any((left <= x) & (x <= right) & (low <= y) & (y <= high)):
                continue
            if line.get_gid() == "magnet":
                name, look = "magnet's centre, projected", MIDDLE
            else:
                cut = line.get_linestyle() == "-"
                name = "contact with the magnet" if cut else "sphere of contact, projected"
                look = {"linestyle": line.get_linestyle(), "linewidth": 0.8}
            handles[name] = Line2D([], [], color="black", label=name, **look)
    return list(handles.values())


def _points(axis: Axes, points: Sequence[FixedPoint], flow: SlowFlow, orbit: Orbit, i: int, j: int) -> None:
    k = 3 - i - j
    cell = flow.axes[k][1] - flow.axes[k][0]
    for point in points:
        near = abs(point.position[k] - orbit.position[k]) < cell
        look = ON | {"markersize": 4.5 if near else 2.8, "markerfacecolor": VERMILLION if point.stable else "white"}
        axis.plot(1e3 * point.position[i], 1e3 * point.position[j], zorder=5, **look)
    if not points:
        axis.plot(1e3 * orbit.position[i], 1e3 * orbit.position[j], zorder=5, **ON)


def _flow_key(points: Sequence[FixedPoint], captured: Basin | None, unsettled: bool, axes: Any) -> list[Any]:
    handles: list[Any] = []
    if not points:
        handles.append(Line2D([], [], label="orbit", **ON))
    for stable, name in ((True, "stable fixed point"), (False, "saddle")):
        if any(point.stable is stable for point in points):
            look = ON | {"markerfacecolor": VERMILLION if stable else "white"}
            handles.append(Line2D([], [], label=name, **look))
    if captured is not None:
        dot: dict[str, Any] = {"marker": "o", "linestyle": "none", "markersize": 2.5, "markeredgewidth": 0.6}
        for mask, name, colour, face in _kinds_of_starts(captured):
            if mask.any():
                handles.append(Line2D([], [], label=name, color=colour, markerfacecolor=face, **dot))
    if unsettled:
        handles.append(Patch(color=PALE, label="no slow flow"))
    return handles + magnet_key(axes)


def _kinds_of_starts(captured: Basin) -> list[tuple[NDArray[np.bool_], str, str, str]]:
    return [
        (captured.captured, "start that comes to the orbit", GREEN, GREEN),
        (~captured.captured, "start that does not", ORANGE, "none"),
    ]


def _starts(axis: Axes, captured: Basin, orbit: Orbit, i: int, j: int) -> None:
    k = 3 - i - j
    levels = captured.axes[k]
    near = captured.places[:, k] == levels[np.argmin(np.abs(levels - orbit.position[k]))]
    for mask, _, colour, face in _kinds_of_starts(captured):
        x, y = 1e3 * captured.places[near & mask][:, [i, j]].T
        axis.scatter(x, y, s=6, facecolors=face, edgecolors=colour, linewidths=0.6, zorder=4)


def _edges(centres: Floats) -> Floats:
    half = 0.5 * (centres[1] - centres[0])
    return np.append(centres - half, centres[-1] + half)


def _signed(value: float) -> str:
    """A number with the typographer's minus, as on the axes; nothing is not negative."""
    return f"{round(value, 1) + 0.0:.1f}".replace("-", "\N{MINUS SIGN}")
