"""The same figures of sweeps as pages that answer to the mouse: every run with its inputs, gain, verdict and reason."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError, MissingExtra
from helimag.files import replacing
from helimag.outcomes import Reason, Verdict
from helimag.plots._likely import STAYING, ran_devices
from helimag.plots.sweeps import (
    COLOURS,
    border_of,
    boundary_shown,
    column_shown,
    heading,
    is_plane,
    label_of,
    panels_of,
    plane_of,
    value_label,
)
from helimag.runs.shares import in_percent
from helimag.sweeps import axis_names

if TYPE_CHECKING:
    import xarray

BLACK = {"color": "black"}


def interactive_sweep(dataset: "xarray.Dataset") -> Any:
    """Draw a sweep as :func:`draw_sweep` does, as a plotly figure.

    Returns
    -------
    plotly.graph_objects.Figure
        On hovering over a run, its inputs, gain, verdict and reason; over the boundary, where it is and how exactly.

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
        raise MissingExtra.of("an interactive figure", "plotly", "sweeps") from None
    if not np.any(dataset["verdict"].values):
        raise InputError("there is nothing to draw: no run of this sweep has been computed")
    panels = list(panels_of(dataset))
    columns = min(len(panels), 3)
    rows = -(-len(panels) // columns)
    titles = [title for title, _ in panels] if len(panels) > 1 else None
    figure = make_subplots(rows=rows, cols=columns, subplot_titles=titles)
    for place, (_, part) in enumerate(panels):
        _add_panel(figure, part, {"row": place // columns + 1, "col": place % columns + 1})
    _add_legend(figure, dataset)
    title = heading(dataset).replace("\n", "<br>")
    figure.update_layout(title=title, template="plotly_white", height=max(640, 360 * rows))
    return figure


def _add_legend(figure: Any, dataset: "xarray.Dataset") -> None:
    """Each verdict and line once in the legend, all panels' together: the verdicts by a mark of their colour."""
    flags = dataset["verdict"].values
    for verdict in Verdict:
        if verdict != Verdict.NOT_COMPUTED and np.any(flags == verdict):
            mark = {"color": COLOURS[verdict], "size": 9, "symbol": "square"}
            figure.add_scatter(x=[None], y=[None], mode="markers", marker=mark, name=str(verdict), hoverinfo="skip")
    named: set[str] = set()
    for trace in figure.data:
        trace.update(legendgroup=trace.name, showlegend=bool(trace.name) and trace.name not in named)
        named.add(str(trace.name))


def _add_panel(figure: Any, part: "xarray.Dataset", place: dict[str, int]) -> None:
    """Draw one panel as its figure on paper: a curve, points, or a map of verdicts."""
    names = axis_names(part)
    inner = [name for name in names if part[name].ndim] or names
    if part["verdict"].dims == ("point",) and len(inner) >= 2:
        _add_points(figure, part, inner[:2], place)
    elif is_plane(part):
        _add_map(figure, part, place)
    else:
        _add_curves(figure, part, inner, place)


def _add_curves(figure: Any, part: "xarray.Dataset", inner: Sequence[str], place: dict[str, int]) -> None:
    """Gain along the last axis, a curve for each value of the other; runs of one verdict beside each other joined."""
    x, gain = column_shown(part, inner[-1]), part["gain"].values.ravel()
    flags = part["verdict"].values.ravel()
    rows = part["verdict"].values.reshape(-1, part["verdict"].shape[-1]).shape
    places = np.arange(flags.size).reshape(rows)
    for number, row in enumerate(places):
        name = value_label(part.isel({part["verdict"].dims[0]: number}), inner[0]) if len(places) > 1 else "gain"
        for piece in np.split(row, np.flatnonzero(np.diff(flags[row])) + 1):
            look = {"width": 1, **(BLACK if len(places) == 1 else {})}
            figure.add_scatter(x=x[piece], y=gain[piece], mode="lines", line=look, name=name, hoverinfo="skip", **place)
    _add_runs(figure, part, x, gain, place)
    figure.add_hline(y=1.0, line={"dash": "dash", "width": 1}, **place)
    figure.update_xaxes(title_text=label_of(part, inner[-1]), **place)
    figure.update_yaxes(title_text="gain", **place)


def _add_points(figure: Any, part: "xarray.Dataset", names: Sequence[str], place: dict[str, int]) -> None:
    """Runs at points of a plane, and the boundary with its error bars."""
    _add_runs(figure, part, column_shown(part, names[0]), column_shown(part, names[1]), place)
    points, error = boundary_shown(part, names)
    if len(points):
        told = [
            "<br>".join(
                f"boundary at {label_of(part, name)}: {value:.5g} \u00b1 {off:.2g}"
                for name, value, off in zip(names, point, offs, strict=True)
            )
            for point, offs in zip(points, error, strict=True)
        ]
        figure.add_scatter(
            x=points[:, 0],
            y=points[:, 1],
            error_x={"array": error[:, 0], "thickness": 1, "width": 0},
            error_y={"array": error[:, 1], "thickness": 1, "width": 0},
            mode="markers",
            marker={"color": "black", "size": 3},
            name="boundary",
            text=told,
            hoverinfo="text",
            **place,
        )
    figure.update_xaxes(title_text=label_of(part, names[0]), **place)
    figure.update_yaxes(title_text=label_of(part, names[1]), **place)


def _add_map(figure: Any, part: "xarray.Dataset", place: dict[str, int]) -> None:
    """Cells in the verdicts' colours, the border of the bounded ones, and the contour of gain 1."""
    x, y = (name for name in axis_names(part) if part[name].ndim)
    across, up = column_shown(part, x, whole=False), column_shown(part, y, whole=False)
    flags, gain = plane_of(part, "verdict"), plane_of(part, "gain")
    figure.add_heatmap(
        x=across,
        y=up,
        z=flags,
        colorscale=_scale_of_colours(),
        zmin=-0.5,
        zmax=max(verdict.flag for verdict in Verdict) + 0.5,
        showscale=False,
        text=_hover(part).reshape(part["verdict"].shape).T,
        hoverinfo="text",
        **place,
    )
    edges = border_of(across, up, flags == Verdict.BOUNDED)
    if len(edges):
        line = np.concatenate([edges, np.full((len(edges), 1, 2), np.nan)], axis=1).reshape(-1, 2)
        look = {"width": 2, **BLACK}
        where = (f"{label_of(part, name)}: %{{{axis}:.5g}}" for name, axis in ((x, "x"), (y, "y")))
        told = "<br>".join(["edge of bounded runs", *where])
        figure.add_scatter(
            x=line[:, 0],
            y=line[:, 1],
            mode="lines",
            line=look,
            name="edge of bounded runs",
            hovertemplate=f"{told}<extra></extra>",
            **place,
        )
    if np.nanmin(gain) < 1.0 < np.nanmax(gain):
        figure.add_contour(
            x=across,
            y=up,
            z=gain,
            contours={"start": 1.0, "end": 1.0, "size": 1.0, "coloring": "none"},
            line={"dash": "dash", "width": 1, "smoothing": 0, **BLACK},
            showscale=False,
            name="gain 1",
            hoverinfo="skip",
            **place,
        )
    figure.update_xaxes(title_text=label_of(part, x), **place)
    figure.update_yaxes(title_text=label_of(part, y), **place)


def _scale_of_colours() -> list[tuple[float, str]]:
    """The verdicts' colours as steps, each the width of one number."""
    colours = [COLOURS[verdict] for verdict in sorted(Verdict, key=lambda each: each.flag)]
    return [(at, colour) for i, colour in enumerate(colours) for at in (i / len(colours), (i + 1) / len(colours))]


def _add_runs(figure: Any, part: "xarray.Dataset", x: Any, y: Any, place: dict[str, int]) -> None:
    """Every run as a mark in its verdict's colour, with what hovering over it says."""
    flags, text = part["verdict"].values.ravel(), _hover(part)
    for verdict in Verdict:
        here = (flags == verdict) & (verdict != Verdict.NOT_COMPUTED)
        if np.any(here):
            figure.add_scatter(
                x=x[here],
                y=y[here],
                mode="markers",
                marker={"color": COLOURS[verdict], "size": 7},
                text=text[here],
                hoverinfo="text",
                **place,
            )


def _hover(part: "xarray.Dataset") -> NDArray[np.str_]:
    """What hovering over each run shows."""
    columns = {name: column_shown(part, name) for name in axis_names(part)}
    flags, gain = part["verdict"].values.ravel(), part["gain"].values.ravel()
    reasons = part["reason"].values.ravel()
    staying = part[STAYING].values.ravel() if ran_devices(part) else flags
    lines = [
        [f"{label_of(part, name)}: {values[i]:.5g}" for name, values in columns.items()]
        + [f"gain {gain[i]:.4g}", f"{Verdict.of(flags[i])}, {Reason.of(reasons[i])}"]
        + ([f"{in_percent(staying[i])}% of the devices stay to the end"] if ran_devices(part) else [])
        for i in range(flags.size)
    ]
    return np.array(["<br>".join(line) for line in lines])


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
