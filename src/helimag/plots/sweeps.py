"""Figures of sweeps: gain curves, maps of the verdict with its boundary, small multiples; on paper and interactive."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import AbstractPathEffect, withStroke
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError, MissingExtra
from helimag.files import replacing
from helimag.outcomes import Reason, Verdict
from helimag.plots._curves import belongs, draw_curves
from helimag.plots._likely import STAYING, add_scale, draw_band, draw_shares, draw_shares_at, ran_devices
from helimag.plots._style import (
    BLUE,
    DARK,
    FULL_WIDTH,
    GREEN,
    GREY,
    MM,
    ORANGE,
    PURPLE,
    SKY,
    TIME_COLOURS,
    VERMILLION,
    WHITE,
    YELLOW,
    styled,
)
from helimag.sweeps import axis_names, boundary_line, parse_plan

if TYPE_CHECKING:
    import xarray

    from helimag.orbits import BoundaryCurve

Floats = NDArray[np.float64]

# of the verdicts, by their numbers, no answer in grey; the last ones wait for verdicts to come
PALETTE = (WHITE, BLUE, SKY, VERMILLION, ORANGE, PURPLE, DARK, GREY, GREEN, YELLOW)
COLOURS = dict(zip(Verdict, PALETTE, strict=False))
NAMES = {"yaw_rate": "yaw rate"}
GAIN = "gain $\\gamma$"
EDGE, UNIT = 0.9, 0.6  # widths of a map's contours: around what is bounded, and at a gain of one
CONTOURS: dict[str, dict[str, Any]] = {
    "edge of bounded runs": {"color": "black", "linewidth": EDGE},
    "gain 1": {"color": "black", "linewidth": UNIT, "linestyle": "--"},
}
CASING: list[AbstractPathEffect] = [
    withStroke(linewidth=2.2, foreground="white")
]  # sets the contours off from full colours
CURVES = 8  # more values of the first axis than this make a map instead of a curve each
PANEL_HEIGHT = 50.0 * MM
HIGHEST_GAIN = 2.0  # of the axis: what lies above has left the magnet anyway


def draw_sweep(dataset: "xarray.Dataset", *, curves: Sequence["BoundaryCurve"] = ()) -> Figure:
    """Draw a sweep: one axis as a curve, two as curves or a map, more as one small panel for each value of the others.

    A sweep with an ensemble has maps of the share of its devices that stay to the end, and bands of gain on its curves.

    Parameters
    ----------
    dataset
        As :func:`helimag.sweep` gives it.
    curves
        Where orbits lose stability, as :func:`helimag.orbits.boundary_of` gives them: drawn over the panels of the same
        two inputs, either way round, whose other inputs are the same.

    Raises
    ------
    InputError
        Where no run has been computed, or a curve belongs to none of the panels.
    """
    if not np.any(dataset["verdict"].values):
        raise InputError("there is nothing to draw: no run of this sweep has been computed")
    panels = list(_panels(dataset))
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    with styled():
        figure = Figure(figsize=(FULL_WIDTH * max(columns, 2) / 3, PANEL_HEIGHT * rows + 12 * MM), layout="constrained")
        looks: dict[str, Line2D] = {}
        likely = ran_devices(dataset) and _is_plane(panels[0][1], as_map=True)
        missing = list(curves)
        for place, (title, part) in enumerate(panels):
            axes = figure.add_subplot(rows, columns, place + 1)
            axes.set_title(title)
            _draw_panel(axes, part, as_map=bool(curves) or likely)
            if _is_plane(part, as_map=bool(curves) or likely):
                here = [curve for curve in curves if belongs(curve, part)]
                missing = [curve for curve in missing if not any(curve is each for each in here)]
                looks |= {str(look.get_label()): look for look in _lay_over(axes, part, here)}
        if missing:
            raise InputError(
                f"a curve over {missing[0].paths[0]} and {missing[0].paths[1]} belongs to no map of this sweep: the "
                "sweep must run over both as a map, and be the same in all else that decides an orbit"
            )
        if looks:
            looks |= {label: Line2D([], [], label=label, **look) for label, look in CONTOURS.items()}
        handles = [*([] if likely else legend(dataset["verdict"].values)), *looks.values()]
        if likely:
            handles += add_scale(figure)
        figure.legend(handles=handles, loc="outside lower center", ncols=4 if looks else 7)
        figure.suptitle(dataset.attrs["title"], fontsize=8)
    return figure


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


def _panels(dataset: "xarray.Dataset") -> Iterator[tuple[str, "xarray.Dataset"]]:
    """Two dimensions at most in each panel."""
    dims = dataset["verdict"].dims
    outer = [str(dim) for dim in dims[:-2]]
    for index in np.ndindex(*(dataset.sizes[dim] for dim in outer)):
        part = dataset.isel(dict(zip(outer, index, strict=True)))
        title = ", ".join(
            f"{NAMES.get(dim, dim)} {_shown(part, dim):.4g} {_unit(part, dim)}" for dim in outer if dim in part.coords
        )
        yield title, part


def _draw_panel(axes: Axes, part: "xarray.Dataset", *, as_map: bool = False) -> None:
    dims = [str(dim) for dim in part["verdict"].dims]
    names = [name for name in axis_names(part) if part[name].ndim == 1]
    if dims == ["point"] and len(names) >= 2:
        _draw_points(axes, part, names[:2])
    elif len(dims) == 1:
        draw_curve(axes, part, names[0], label=None)
    elif not _is_plane(part, as_map=as_map):
        for i in range(part.sizes[dims[0]]):
            row = part.isel({dims[0]: i})
            label = f"{_shown(row, dims[0]):.4g} {_unit(row, dims[0])}" if dims[0] in row.coords else str(i)
            draw_curve(axes, row, _along(row, dims[1]), label=label, colour=f"C{i}")
        axes.legend()
    else:
        _draw_map(axes, part, _along(part, dims[0]), _along(part, dims[1]))


def _is_plane(part: "xarray.Dataset", *, as_map: bool) -> bool:
    """Whether a panel is drawn over two inputs, as points or as a map; ``as_map`` even where curves would do."""
    dims = part["verdict"].dims
    return dims == ("point",) or (len(dims) == 2 and (as_map or part.sizes[dims[0]] > CURVES))


def _along(part: "xarray.Dataset", dim: str) -> str:
    """The coordinate to draw along a dimension."""
    return dim if dim in part.coords else next(name for name in axis_names(part) if part[name].dims == (dim,))


def draw_curve(
    axes: Axes, row: "xarray.Dataset", name: str, *, label: str | None, colour: Any = "black", top: float = HIGHEST_GAIN
) -> None:
    """Gain along one axis, each run marked by its verdict; gamma = 1 as a line."""
    values, gain, flags = _shown(row, name), row["gain"].values, row["verdict"].values
    if ran_devices(row):
        draw_band(axes, row, values, top)
    axes.plot(values, np.minimum(gain, top), color=colour, linewidth=0.6, label=label, zorder=1)
    for verdict in Verdict:
        here = (flags == verdict) & (verdict != Verdict.NOT_COMPUTED)
        height = np.where(np.isnan(gain[here]), top, np.minimum(gain[here], top))
        marker = "x" if verdict is Verdict.FAILED else "o"
        axes.scatter(values[here], height, s=5, color=COLOURS[verdict], marker=marker, linewidths=0.6, zorder=2)
    axes.axhline(1.0, color="black", linewidth=0.6, linestyle="--")
    axes.set(xlabel=label_of(row, name), ylabel=GAIN, ylim=(0.0, 1.05 * top))


def shade(axes: Axes, row: "xarray.Dataset", name: str, colour: Any, span: tuple[float, float] = (0.0, 1.0)) -> None:
    """Shade where runs are judged bounded, half a step to each side, over a part of the height."""
    values = _shown(row, name)
    middles = (values[1:] + values[:-1]) / 2.0
    edges = np.concatenate([values[:1], middles, values[-1:]])
    for i in np.flatnonzero(row["verdict"].values == Verdict.BOUNDED):
        axes.axvspan(edges[i], edges[i + 1], *span, color=colour, alpha=0.3, linewidth=0)


def _draw_map(axes: Axes, part: "xarray.Dataset", x: str, y: str) -> None:
    """Verdicts as coloured cells with the gain's contours and the boundary of what is bounded, or devices' shares."""
    dims = part["verdict"].dims
    axes.set(xlabel=label_of(part, x), ylabel=label_of(part, y))
    if ran_devices(part):
        draw_shares(axes, part.transpose(dims[1], dims[0], ...), _shown(part, x), _shown(part, y))
        return
    flags = part["verdict"].transpose(dims[1], dims[0]).values
    colours = np.zeros((1 + max(verdict.flag for verdict in Verdict), 3))
    for verdict, colour in COLOURS.items():
        colours[verdict.flag] = to_rgb(colour)
    axes.pcolormesh(_shown(part, x), _shown(part, y), colours[flags], shading="nearest", linewidth=0)
    inside = (flags == Verdict.BOUNDED).astype(float)
    if 0.0 < inside.mean() < 1.0:
        edge = axes.contour(_shown(part, x), _shown(part, y), inside, levels=[0.5], colors="black", linewidths=EDGE)
        edge.set_path_effects(CASING)
    gain = part["gain"].transpose(dims[1], dims[0]).values
    if np.nanmin(gain) < 1.0 < np.nanmax(gain):
        unit = axes.contour(
            _shown(part, x), _shown(part, y), gain, levels=[1.0], colors="black", linewidths=UNIT, linestyles="--"
        )
        unit.set_path_effects(CASING)


def _draw_points(axes: Axes, part: "xarray.Dataset", names: Sequence[str]) -> None:
    """Runs at points of a plane, with the boundary and its error bars where the plan looked for one."""
    axes.set(xlabel=label_of(part, names[0]), ylabel=label_of(part, names[1]))
    if ran_devices(part):
        draw_shares_at(axes, part, *(_shown(part, name) for name in names))
        return
    flags = part["verdict"].values
    for verdict in Verdict:
        here = (flags == verdict) & (verdict != Verdict.NOT_COMPUTED)
        x, y = (_shown(part, name)[here] for name in names)
        axes.scatter(x, y, s=6, color=COLOURS[verdict], linewidths=0)
    plan = parse_plan(part.attrs["plan"])
    if plan.boundary is not None:
        line = boundary_line(part, plan.boundary.verdict)
        scale = [_scale(part, name) for name in names]
        error = [line.error[:, i] / scale[i] for i in (0, 1)]
        axes.errorbar(
            line.points[:, 0] / scale[0], line.points[:, 1] / scale[1], error[1], error[0], "k.", ms=2, lw=0.5, zorder=3
        )


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
    return {"deg": "°", "deg/s": "°/s", "1": ""}.get(unit, unit)


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


def draw_passes(passes: Sequence[Passes]) -> Figure:
    """Draw wide passes above and fine ones below, a column an input: gain by frequency, strips where bounded.

    Parameters
    ----------
    passes
        One for each frequency and input.
    """
    frequencies = list(dict.fromkeys(each.frequency for each in passes))
    names = list(dict.fromkeys(each.name for each in passes))
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, 115 * MM), layout="constrained")
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
        figure.legend(handles=[*lines, *legend(flags)], loc="outside lower center", ncols=max(len(lines), 4))
        figure.suptitle("wide pass above, fine pass below; strips: judged bounded", fontsize=7)
    return figure


def interactive_sweep(dataset: "xarray.Dataset") -> Any:
    """The same as a plotly figure: every run with its inputs, gain, verdict and reason on hovering over it.

    Raises
    ------
    InputError
        Where no run has been computed.
    MissingExtra
        Where plotly is not installed.
    """
    try:
        from plotly.subplots import make_subplots
    except ImportError:
        raise MissingExtra("interactive figures need plotly: pip install 'helimag[sweeps]'") from None
    if not np.any(dataset["verdict"].values):
        raise InputError("there is nothing to draw: no run of this sweep has been computed")
    panels = list(_panels(dataset))
    columns = min(len(panels), 3)
    rows = -(-len(panels) // columns)
    titles = [title for title, _ in panels] if len(panels) > 1 else None
    figure = make_subplots(rows=rows, cols=columns, subplot_titles=titles)
    for place, (_, part) in enumerate(panels):
        _add_panel(figure, part, {"row": place // columns + 1, "col": place % columns + 1})
    named: set[str] = set()
    for trace in figure.data:  # each verdict and curve once in the legend, all panels' together
        trace.update(legendgroup=trace.name, showlegend=trace.name not in named)
        named.add(trace.name)
    figure.update_layout(title=dataset.attrs["title"], template="plotly_white", height=max(640, 360 * rows))
    return figure


def _add_panel(figure: Any, part: "xarray.Dataset", place: dict[str, int]) -> None:
    """Draw one panel's runs: gain curves where there are few, else a map of verdicts."""
    names = axis_names(part)
    columns = {name: _column(part, name) for name in names}
    inner = [name for name in names if part[name].ndim] or names
    verdict = part["verdict"]
    curve = len(inner) == 1 or (len(inner) == 2 and verdict.ndim == 2 and verdict.shape[0] <= CURVES)
    flags, gain = verdict.values.ravel(), part["gain"].values.ravel()
    if curve and len(inner) == 2:
        for value in np.unique(columns[inner[0]]):
            row = columns[inner[0]] == value
            figure.add_scatter(
                x=columns[inner[1]][row],
                y=gain[row],
                mode="lines",
                line={"width": 1},
                name=f"{value:.4g} {_unit(part, inner[0])}",
                hoverinfo="skip",
                **place,
            )
    x, y = (columns[inner[-1]], gain) if curve else (columns[inner[0]], columns[inner[1]])
    text = _hover(part, columns)
    for outcome in Verdict:
        here = (flags == outcome) & (outcome != Verdict.NOT_COMPUTED)
        if np.any(here):
            figure.add_scatter(
                x=x[here],
                y=y[here],
                mode="markers",
                marker={"color": COLOURS[outcome], "size": 7},
                name=str(outcome),
                legendrank=outcome.flag,  # above the curves
                text=text[here],
                hoverinfo="text",
                **place,
            )
    if curve:
        figure.add_hline(y=1.0, line={"dash": "dash", "width": 1}, **place)
    figure.update_xaxes(title_text=label_of(part, inner[-1] if curve else inner[0]), **place)
    figure.update_yaxes(title_text="gain" if curve else label_of(part, inner[1]), **place)


def _hover(part: "xarray.Dataset", columns: dict[str, Any]) -> Any:
    """What hovering over each run shows."""
    flags, gain = part["verdict"].values.ravel(), part["gain"].values.ravel()
    reasons = part["reason"].values.ravel()
    staying = part[STAYING].values.ravel() if ran_devices(part) else flags
    lines = [
        [f"{label_of(part, name)}: {values[i]:.5g}" for name, values in columns.items()]
        + [f"gain {gain[i]:.4g}", f"{Verdict.of(flags[i])}, {Reason.of(reasons[i])}"]
        + ([f"{staying[i]:.0%} of the devices stay to the end"] if ran_devices(part) else [])
        for i in range(flags.size)
    ]
    return np.array(["<br>".join(line) for line in lines])


def _column(dataset: "xarray.Dataset", name: str) -> Any:
    flat = dataset[name].broadcast_like(dataset["verdict"]).transpose(*dataset["verdict"].dims).values.ravel()
    return flat / _scale(dataset, name)


def save_html(figure: Any, path: str | Path) -> None:
    """Write an interactive figure as one file that needs nothing from elsewhere.

    Raises
    ------
    FileError
        Where it cannot be written; nothing is left behind.
    """
    with replacing(path) as beside:
        tall = f"{figure.layout.height:.0f}px"
        page = figure.to_html(include_plotlyjs=True, full_html=True, div_id="sweep", default_height=tall)
        beside.write_text(page, encoding="utf-8")
