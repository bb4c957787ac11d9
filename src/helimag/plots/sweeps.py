"""Figures of sweeps: gain curves, maps of the verdict with its boundary, small multiples."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import AbstractPathEffect, withStroke
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError
from helimag.outcomes import Verdict
from helimag.plots._curves import belongs, draw_curves
from helimag.plots._likely import add_scale, draw_band, draw_shares, draw_shares_at, ran_devices
from helimag.plots._style import (
    BLUE,
    DARK,
    GREEN,
    LIGHT,
    MM,
    ORANGE,
    PURPLE,
    SKY,
    TIME_COLOURS,
    VERMILLION,
    WHITE,
    YELLOW,
    Sheet,
    Size,
    head,
    legend_below,
    styled,
)
from helimag.scenario import drive_inputs, parse
from helimag.sweeps import axis_names, boundary_line, parse_plan

if TYPE_CHECKING:
    import xarray

    from helimag.orbits import BoundaryCurve

Floats = NDArray[np.float64]

# of the verdicts, by their numbers, no answer in grey; the last ones wait for verdicts to come
PALETTE = (WHITE, BLUE, SKY, VERMILLION, ORANGE, PURPLE, DARK, LIGHT, GREEN, YELLOW)
COLOURS = dict(zip(Verdict, PALETTE, strict=False))
NAMES = {"yaw_rate": "yaw rate"}
GAIN = "gain $\\gamma$"
EDGE, UNIT = 0.9, 0.6  # widths of a map's contours: around what is bounded, and at a gain of one
BORDER: dict[str, Any] = {"color": "black", "linewidth": EDGE}
GAIN_ONE: dict[str, Any] = {"color": "black", "linewidth": UNIT, "linestyle": "--"}
CASED = 2.2
CASING: list[AbstractPathEffect] = [
    withStroke(linewidth=CASED, foreground="white")
]  # sets the contours off from full colours
PANEL_HEIGHT = 50.0 * MM
HIGHEST_GAIN = 2.0  # of the axis: what lies above has left the magnet anyway


def draw_sweep(dataset: "xarray.Dataset", *, curves: Sequence["BoundaryCurve"] = (), size: Size = "print") -> Figure:
    """Draw a sweep: one axis as a curve, two as a map, more as one small panel for each value of the others.

    A sweep with an ensemble has maps of the share of its devices that stay to the end, and bands of gain on its curves.

    Parameters
    ----------
    dataset
        As :func:`helimag.sweep` gives it.
    curves
        Where orbits lose stability, as :func:`helimag.orbits.boundary_of` gives them: drawn over the panels of the same
        two inputs, either way round, whose other inputs are the same.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88 mm; 120 or 180 mm; or 160 mm wide.

    Raises
    ------
    InputError
        Where no run has been computed, or a curve belongs to none of the panels.
    """
    if not np.any(dataset["verdict"].values):
        raise InputError("there is nothing to draw: no run of this sweep has been computed")
    panels = list(panels_of(dataset))
    with styled(size) as sheet:
        columns = min(_most_columns(sheet, len(panels)), len(panels))
        rows = -(-len(panels) // columns)
        figure = sheet.figure(PANEL_HEIGHT * rows + 12 * MM, share=max(columns, 2) / 3)
        looks: dict[str, Line2D] = {}
        likely = ran_devices(dataset) and is_plane(panels[0][1])
        missing = list(curves)
        for place, (title, part) in enumerate(panels):
            axes = figure.add_subplot(rows, columns, place + 1)
            axes.set_title(title)
            looks |= {str(look.get_label()): look for look in _draw_panel(axes, part)}
            if is_plane(part):
                here = [curve for curve in curves if belongs(curve, part)]
                missing = [curve for curve in missing if not any(curve is each for each in here)]
                looks |= {str(look.get_label()): look for look in _lay_over(axes, part, here)}
        if missing:
            raise InputError(
                f"a curve over {missing[0].paths[0]} and {missing[0].paths[1]} belongs to no map of this sweep: the "
                "sweep must run over both as a map, and be the same in all else that decides an orbit"
            )
        handles = [*([] if likely else legend(dataset["verdict"].values)), *looks.values()]
        if likely:
            handles += add_scale(figure)
        legend_below(figure, handles, most=4 if looks else 7)
        head(figure, heading(dataset))
    return figure


def _most_columns(sheet: Sheet, panels: int) -> int:
    """Of panels: a slide is filled, a column of a paper has one or, of many panels, two."""
    if sheet.wide:
        return max(3, math.ceil(panels / 2))
    return (1 if panels < 4 else 2) if sheet.narrow else 3


def heading(dataset: "xarray.Dataset") -> str:
    """The sweep's title, and the inputs that all its runs share."""
    swept = {line.field for line in parse_plan(dataset.attrs["plan"]).axis}
    base = parse(dataset.attrs["scenario"])
    names = dict.fromkeys((dataset.attrs["title"], base.title))  # once where a plan is called as its device
    return f"{': '.join(names)}\n{drive_inputs(base, without=swept)}"


def _lay_over(axes: Axes, part: "xarray.Dataset", curves: Sequence["BoundaryCurve"]) -> list[Line2D]:
    """Curves over a map of the same inputs, which keeps its extent; a line of each look."""
    if not curves:
        return []
    fields = {part[name].attrs["long_name"]: name for name in axis_names(part) if part[name].ndim}
    first, second = (1.0 / _scale(part, fields[path]) for path in curves[0].paths)
    swapped = axes.get_xlabel() != label_of(part, fields[curves[0].paths[0]])
    limits = axes.get_xlim(), axes.get_ylim()
    looks = draw_curves(axes, curves, scales=(first, second), swapped=swapped)
    axes.set(xlim=limits[0], ylim=limits[1])
    return looks


def panels_of(dataset: "xarray.Dataset") -> Iterator[tuple[str, "xarray.Dataset"]]:
    """Two dimensions at most in each panel."""
    dims = dataset["verdict"].dims
    outer = [str(dim) for dim in dims[:-2]]
    for index in np.ndindex(*(dataset.sizes[dim] for dim in outer)):
        part = dataset.isel(dict(zip(outer, index, strict=True)))
        title = ", ".join(f"{NAMES.get(dim, dim)} {value_label(part, dim)}" for dim in outer if dim in part.coords)
        yield title, part


def _draw_panel(axes: Axes, part: "xarray.Dataset") -> list[Line2D]:
    """Draw one panel; the lines in it that a legend must name."""
    dims = [str(dim) for dim in part["verdict"].dims]
    names = [name for name in axis_names(part) if part[name].ndim == 1]
    if dims == ["point"] and len(names) >= 2:
        return _draw_points(axes, part, names[:2])
    if len(dims) == 1:
        return draw_curve(axes, part, names[0], label=None)
    if is_plane(part):
        return _draw_map(axes, part, _along(part, dims[0]), _along(part, dims[1]))
    lines: list[Line2D] = []
    for i in range(part.sizes[dims[0]]):
        row = part.isel({dims[0]: i})
        label = value_label(row, dims[0]) if dims[0] in row.coords else str(i)
        lines = draw_curve(axes, row, _along(row, dims[1]), label=label, colour=f"C{i}")
    axes.legend()
    return lines


def is_plane(part: "xarray.Dataset") -> bool:
    """Whether a panel is drawn over two inputs, as points or as a map: where both are numbers with some values."""
    dims = part["verdict"].dims
    if dims == ("point",):
        return True
    along = [part[_along(part, str(dim))] for dim in dims]
    return len(dims) == 2 and all(each.size > 1 and "flag_meanings" not in each.attrs for each in along)


def _along(part: "xarray.Dataset", dim: str) -> str:
    """The coordinate to draw along a dimension."""
    return dim if dim in part.coords else next(name for name in axis_names(part) if part[name].dims == (dim,))


def draw_curve(
    axes: Axes, row: "xarray.Dataset", name: str, *, label: str | None, colour: Any = "black", top: float = HIGHEST_GAIN
) -> list[Line2D]:
    """Gain along one axis, each run marked by its verdict; gamma = 1 as a line.

    Runs of the same verdict beside each other are joined; between verdicts nothing is known.
    """
    values, gain, flags = _shown(row, name), row["gain"].values, row["verdict"].values
    if ran_devices(row):
        draw_band(axes, row, values, top)
    for part in np.split(np.arange(flags.size), np.flatnonzero(np.diff(flags)) + 1):
        axes.plot(values[part], np.minimum(gain[part], top), color=colour, linewidth=0.6, label=label, zorder=1)
        label = None
    for verdict in Verdict:
        here = (flags == verdict) & (verdict != Verdict.NOT_COMPUTED)
        height = np.where(np.isnan(gain[here]), top, np.minimum(gain[here], top))
        marker = "x" if verdict is Verdict.FAILED else "o"
        axes.scatter(values[here], height, s=5, color=COLOURS[verdict], marker=marker, linewidths=0.6, zorder=2)
    axes.axhline(1.0, **GAIN_ONE)
    axes.set(xlabel=label_of(row, name), ylabel=GAIN, ylim=(0.0, 1.05 * top))
    if "flag_meanings" in row[name].attrs:
        axes.set_xticks(values, row[name].attrs["flag_meanings"].split()[: values.size])
    return [Line2D([], [], label="gain 1", **GAIN_ONE)]


def shade(axes: Axes, row: "xarray.Dataset", name: str, colour: Any, span: tuple[float, float] = (0.0, 1.0)) -> None:
    """Shade where runs are judged bounded, half a step to each side, over a part of the height."""
    values = _shown(row, name)
    middles = (values[1:] + values[:-1]) / 2.0
    edges = np.concatenate([values[:1], middles, values[-1:]])
    for i in np.flatnonzero(row["verdict"].values == Verdict.BOUNDED):
        axes.axvspan(edges[i], edges[i + 1], *span, color=colour, alpha=0.3, linewidth=0)


def _draw_map(axes: Axes, part: "xarray.Dataset", x: str, y: str) -> list[Line2D]:
    """Verdicts as coloured cells, the border of the bounded ones along the cells' sides, and the contour of gain 1."""
    across, up = _shown(part, x), _shown(part, y)
    axes.set(xlabel=label_of(part, x), ylabel=label_of(part, y))
    if ran_devices(part):
        dims = part["verdict"].dims
        draw_shares(axes, part.transpose(dims[1], dims[0], ...), across, up)
        return []
    flags, gain = plane_of(part, "verdict"), plane_of(part, "gain")
    colours = np.zeros((1 + max(verdict.flag for verdict in Verdict), 3))
    for verdict, colour in COLOURS.items():
        colours[verdict.flag] = to_rgb(colour)
    axes.pcolormesh(sides_of(across), sides_of(up), colours[flags], linewidth=0, antialiased=False)
    named = []
    edges = border_of(across, up, flags == Verdict.BOUNDED)
    if len(edges):
        for look in ({"color": "white", "linewidth": CASED}, BORDER):  # all of the casing first
            axes.add_collection(LineCollection(list(edges), capstyle="projecting", **look))
        named.append(Line2D([], [], label="edge of bounded runs", **BORDER))
    if np.nanmin(gain) < 1.0 < np.nanmax(gain):
        unit = axes.contour(across, up, gain, levels=[1.0], colors="black", linewidths=UNIT, linestyles="--")
        unit.set_path_effects(CASING)
        named.append(Line2D([], [], label="gain 1", **GAIN_ONE))
    return named


def plane_of(part: "xarray.Dataset", name: str) -> NDArray[Any]:
    """A variable of a map, the second dimension up."""
    dims = part["verdict"].dims
    return np.asarray(part[name].transpose(dims[1], dims[0]).values)


def sides_of(values: Floats) -> Floats:
    """Sides of the cells around values: half way between them, and as far beyond the outermost."""
    middles = (values[1:] + values[:-1]) / 2.0
    return np.concatenate([[2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]])


def border_of(across: Floats, up: Floats, inside: NDArray[np.bool_]) -> Floats:
    """Sides (n, 2 ends, 2) of cells that have a cell ``inside`` on one side alone; never a slope between two runs."""
    x, y = sides_of(across), sides_of(up)
    rows, columns = np.nonzero(inside[:, 1:] != inside[:, :-1])
    upright = np.stack([x[columns + 1], y[rows], x[columns + 1], y[rows + 1]], axis=1)
    rows, columns = np.nonzero(inside[1:] != inside[:-1])
    level = np.stack([x[columns], y[rows + 1], x[columns + 1], y[rows + 1]], axis=1)
    return np.concatenate([upright, level]).reshape(-1, 2, 2)


def _draw_points(axes: Axes, part: "xarray.Dataset", names: Sequence[str]) -> list[Line2D]:
    """Runs at points of a plane, with the boundary and its error bars where the plan looked for one."""
    axes.set(xlabel=label_of(part, names[0]), ylabel=label_of(part, names[1]))
    if ran_devices(part):
        draw_shares_at(axes, part, *(_shown(part, name) for name in names))
        return []
    flags = part["verdict"].values
    for verdict in Verdict:
        here = (flags == verdict) & (verdict != Verdict.NOT_COMPUTED)
        x, y = (_shown(part, name)[here] for name in names)
        axes.scatter(x, y, s=6, color=COLOURS[verdict], linewidths=0)
    points, error = boundary_shown(part, names)
    if not len(points):
        return []
    axes.errorbar(points[:, 0], points[:, 1], error[:, 1], error[:, 0], "k.", ms=2, lw=0.5, zorder=3)
    return [Line2D([], [], color="black", marker=".", markersize=2, linewidth=0.5, label="boundary, with its error")]


def boundary_shown(part: "xarray.Dataset", names: Sequence[str]) -> tuple[Floats, Floats]:
    """Points (n, 2) of the boundary that the plan looked for, and their errors (n, 2), in the axes' units."""
    plan = parse_plan(part.attrs["plan"])
    if plan.boundary is None:
        return np.empty((0, 2)), np.empty((0, 2))
    line = boundary_line(part, plan.boundary.verdict)
    scale = np.array([_scale(part, name) for name in names])
    return np.asarray(line.points).reshape(-1, 2) / scale, np.asarray(line.error).reshape(-1, 2) / scale


def legend(flags: NDArray[np.int8]) -> list[Patch]:
    """A coloured patch for each verdict that occurs."""
    return [
        Patch(color=COLOURS[verdict], label=str(verdict))
        for verdict in Verdict
        if verdict != Verdict.NOT_COMPUTED and np.any(flags == verdict)
    ]


def _scale(dataset: "xarray.Dataset", name: str) -> float:
    """What one of the units that a coordinate is shown in is in SI."""
    unit = dataset[name].attrs.get("shown_in", "1")
    kind = next((kind for kind in vars(q).values() if isinstance(kind, q.Kind) and kind.shown == unit), None)
    return 1.0 if kind is None else q.parse(f"1 {unit}", kind)


def _shown(dataset: "xarray.Dataset", name: str) -> Any:
    return dataset[name].values / _scale(dataset, name)


def _unit(dataset: "xarray.Dataset", name: str) -> str:
    unit = str(dataset[name].attrs.get("shown_in", "1"))
    return "" if unit == "1" else unit


def value_label(dataset: "xarray.Dataset", name: str) -> str:
    """A coordinate that is one value: the number with its unit, or the word that it stands for."""
    words = dataset[name].attrs.get("flag_meanings", "").split()
    if words:
        return str(words[int(dataset[name])]).replace("_", " ")
    return f"{float(_shown(dataset, name)):.4g} {_unit(dataset, name)}".strip()


def label_of(dataset: "xarray.Dataset", name: str) -> str:
    """An axis' label: name and unit."""
    unit = _unit(dataset, name)
    return f"{NAMES.get(name, name.replace('_', ' '))}{f' ({unit})' if unit else ''}"


@dataclass(frozen=True)
class Passes:
    """Two sweeps over one input at one frequency (Hz): a wide one, and a fine one around what is bounded."""

    frequency: float
    name: str
    wide: "xarray.Dataset"
    fine: "xarray.Dataset"


def draw_passes(passes: Sequence[Passes], *, size: Size = "print") -> Figure:
    """Draw wide passes above and fine ones below, a column an input: gain by frequency, strips where bounded.

    In a column of a paper, wide passes are at the left and fine ones at the right, a row an input.

    Parameters
    ----------
    passes
        One for each frequency and input.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide.
    """
    frequencies = list(dict.fromkeys(each.frequency for each in passes))
    names = list(dict.fromkeys(each.name for each in passes))
    with styled(size) as sheet:
        figure = sheet.figure((45.0 * len(names) + 25.0) * MM if sheet.narrow else 115.0 * MM)
        if sheet.narrow:
            axes = figure.subplots(len(names), 2, squeeze=False).T
        else:
            axes = figure.subplots(2, len(names), squeeze=False)
        colours = colormaps[TIME_COLOURS](np.linspace(0.0, 0.85, len(frequencies)))
        for each in passes:
            column, i = names.index(each.name), frequencies.index(each.frequency)
            strip = (1.0 - (i + 1) / (5 * len(frequencies)), 1.0 - i / (5 * len(frequencies)))
            for here, data, top in zip(axes[:, column], (each.wide, each.fine), (2.0, 1.25), strict=True):
                draw_curve(here, data, each.name, label=None, colour=colours[i], top=top)
                shade(here, data, each.name, colours[i], strip)
                here.set(ylim=(0.0, top * 1.3), xlabel=label_of(data, each.name))
        for column, letter in zip(range(len(names)), "ABC", strict=False):
            axes[0][column].set_title(f"({letter})", loc="left")
        flags = np.concatenate([data["verdict"].values for each in passes for data in (each.wide, each.fine)])
        lines = [Line2D([], [], color=c, label=f"{f:g} Hz") for f, c in zip(frequencies, colours, strict=True)]
        legend_below(figure, [*lines, *legend(flags)], most=max(len(lines), 4))
        where = "at the left, fine pass at the right" if sheet.narrow else "above, fine pass below"
        head(figure, f"wide pass {where}; strips: judged bounded", fontsize=sheet.points(7.0))
    return figure


def column_shown(dataset: "xarray.Dataset", name: str, *, whole: bool = True) -> Floats:
    """A coordinate in the unit that it is shown in: for every run, flat, or only its own values."""
    if not whole:
        return np.asarray(_shown(dataset, name), dtype=np.float64)
    flat = dataset[name].broadcast_like(dataset["verdict"]).transpose(*dataset["verdict"].dims).values.ravel()
    return np.asarray(flat / _scale(dataset, name), dtype=np.float64)
