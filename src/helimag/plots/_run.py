"""One run in one figure: path, height, gap, attack angle, phase lag, and the verdict in words."""

from collections.abc import Callable
from math import isnan

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from helimag.plots import _series as series
from helimag.plots._path import draw_path
from helimag.plots._quantities import Shown, shown, slipping_spans, touching_spans
from helimag.plots._style import MM, Sheet, Size, head, styled
from helimag.runs.trajectory import Trajectory
from helimag.scenario import drive_inputs

HEAD_HEIGHT = 17.0 * MM
HEAD_IN_A_COLUMN = 28.0 * MM
PATH_HEIGHT = 72.0 * MM  # in a column
PANEL_HEIGHT = 26.0 * MM
LEAST_HEIGHT = 95.0 * MM
FOOT = 10.5 * MM  # below the colour bar
LABELS = 12.5 * MM  # between the colour bar and the axes of the path


def draw_run(trajectory: Trajectory, *, size: Size = "print") -> Figure:
    """Draw a run, simulated or measured, after the manner of the paper's Fig. 3; what it does not hold is left out.

    Parameters
    ----------
    trajectory
        The run.
    size
        "small", a column of a paper; "print", its page; or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88 mm, 180 mm, or 160 mm wide and 90 mm high. Lengths are in mm, times in s, angles in degrees.

    Raises
    ------
    InputError
        Where the run has nothing that can be drawn, or there is no such size.
    """
    run = shown(trajectory)
    panels = _panels(run)
    with styled(size) as sheet:
        series_height = PANEL_HEIGHT * len(panels)
        if sheet.narrow:
            figure = sheet.figure(HEAD_IN_A_COLUMN + PATH_HEIGHT + series_height)
            parts = figure.subfigures(2, 1, height_ratios=(PATH_HEIGHT, series_height))
        else:
            figure = sheet.figure(max(LEAST_HEIGHT, HEAD_HEIGHT + series_height))
            parts = figure.subfigures(1, 2, width_ratios=(1.0, 1.5 if sheet.wide else 1.2))
        head(figure, "\n" + _title(run), x=0.012, ha="left", linespacing=1.4)
        figure.text(0.012, 0.99, run.name, va="top", weight="bold", fontsize=sheet.points(8.0))
        path, over_time = np.asarray(parts)
        _draw_path(path, run, sheet)
        _draw_series(over_time, panels, run, columns=2 if sheet.wide else 1)
    return figure


def _panels(run: Shown) -> list[Callable[[Axes, Shown], None]]:
    """The panels that the run has data for, from the top."""
    optional = [(run.gap, series.draw_gap), (run.attack, series.draw_attack), (run.lag, series.draw_lag)]
    return [series.draw_height, *(draw for values, draw in optional if values is not None)]


def _draw_path(figure: SubFigure, run: Shown, sheet: Sheet) -> None:
    """Path, its markers explained above and its colours below; placed by hand, as layout engines fail in 3-D."""
    inch = sheet.points(1.1 * figure.dpi if sheet.wide else figure.dpi) / figure.bbox.height
    foot, bottom = FOOT * inch, (FOOT + LABELS) * inch
    top = 0.72 if sheet.wide else 0.89
    axes = figure.add_axes((0.0, bottom, 0.93, top - bottom), projection="3d")
    line = draw_path(axes, run, ticks=2 if sheet.wide else 6)
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="upper left",
        bbox_to_anchor=(0.0, 0.98),
        ncols=1 if sheet.wide else 2,
        columnspacing=0.5,
        handletextpad=0.2,
    )
    bar = figure.add_axes((0.2, foot, 0.6, 0.018))
    figure.colorbar(line, cax=bar, orientation="horizontal", label="time (s)")


def _draw_series(figure: SubFigure, panels: list[Callable[[Axes, Shown], None]], run: Shown, *, columns: int) -> None:
    first: Axes | None = None
    rows = -(-len(panels) // columns)
    for place, draw in enumerate(panels):
        axes = figure.add_subplot(rows, columns, place + 1, sharex=first)
        first = first or axes
        draw(axes, run)
        series.shade_slips(axes, run)
        series.mark_contacts(axes, run)
        series.limits_of_time(axes, run)
        lowest = place + columns >= len(panels)
        axes.tick_params(labelbottom=lowest)
        if lowest:
            axes.set_xlabel("time (s)")
    slips = "; grey: slipping against the field" if slipping_spans(run) else ""
    contacts = "; red bar: a wall pushes" if touching_spans(run) else ""
    if columns > 1 and (slips or contacts):
        figure.supxlabel(f"{slips}{contacts}".removeprefix("; "), fontsize="medium")
    elif columns == 1:
        axes.set_xlabel(f"time (s){slips}{contacts}")
    figure.align_ylabels()


def _title(run: Shown) -> str:
    """Inputs, verdict and gain."""
    lines = [*([] if run.scenario is None else [drive_inputs(run.scenario)]), run.verdict]
    if run.judgement is not None:
        judgement = run.judgement
        ratio = f"{1e3 * judgement.output:.1f} mm / {1e3 * judgement.input:.1f} mm"
        slips = "" if run.slips is None else f";  slips: {judgement.slips}"
        leads = "" if isnan(run.leading_cosine) else f";  leads: {run.leading_end}, cosine {run.leading_cosine:+.2f}"
        lines.append(f"gain = y / u = {ratio} = {judgement.gain:.3f}{slips}{leads}")
    return "\n".join(lines)
