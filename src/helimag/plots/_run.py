"""One run in one figure: path, height, gap, attack angle, phase lag, and the verdict in words."""

from collections.abc import Callable
from math import isnan

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from helimag.plots import _series as series
from helimag.plots._path import draw_path
from helimag.plots._quantities import Shown, shown, slipping_spans, touching_spans
from helimag.plots._style import FULL_WIDTH, MM, styled
from helimag.runs.trajectory import Trajectory
from helimag.scenario import drive_inputs

HEAD_HEIGHT = 17.0 * MM
PANEL_HEIGHT = 26.0 * MM
LEAST_HEIGHT = 95.0 * MM
FOOT = 10.5 * MM  # below the colour bar
LABELS = 12.5 * MM  # between the colour bar and the axes of the path


def draw_run(trajectory: Trajectory) -> Figure:
    """Draw a run, simulated or measured, after the manner of the paper's Fig. 3; what it does not hold is left out.

    Parameters
    ----------
    trajectory
        The run.

    Returns
    -------
    matplotlib.figure.Figure
        180 mm wide. Lengths are in mm, times in s, angles in degrees.

    Raises
    ------
    InputError
        Where the run has nothing that can be drawn.
    """
    run = shown(trajectory)
    panels = _panels(run)
    with styled():
        height = max(LEAST_HEIGHT, HEAD_HEIGHT + PANEL_HEIGHT * len(panels))
        figure = Figure(figsize=(FULL_WIDTH, height), layout="constrained")
        figure.suptitle("\n" + _title(run), x=0.012, ha="left", fontsize=7.5, linespacing=1.4, wrap=True)
        figure.text(0.012, 0.99, run.name, va="top", weight="bold", fontsize=8.0)
        left, right = np.asarray(figure.subfigures(1, 2, width_ratios=(1.0, 1.2)))
        _draw_path(left, run)
        _draw_series(right, panels, run)
    return figure


def _panels(run: Shown) -> list[Callable[[Axes, Shown], None]]:
    """The panels that the run has data for, from the top."""
    optional = [(run.gap, series.draw_gap), (run.attack, series.draw_attack), (run.lag, series.draw_lag)]
    return [series.draw_height, *(draw for values, draw in optional if values is not None)]


def _draw_path(figure: SubFigure, run: Shown) -> None:
    """Path, its markers explained above and its colours below; placed by hand, as layout engines fail in 3-D."""
    inch = figure.dpi / figure.bbox.height
    foot, bottom = FOOT * inch, (FOOT + LABELS) * inch
    axes = figure.add_axes((0.0, bottom, 0.93, 0.89 - bottom), projection="3d")
    line = draw_path(axes, run)
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="upper left",
        bbox_to_anchor=(0.0, 0.98),
        ncols=2,
        columnspacing=1.0,
        handletextpad=0.2,
    )
    bar = figure.add_axes((0.2, foot, 0.6, 0.018))
    figure.colorbar(line, cax=bar, orientation="horizontal", label="time (s)")


def _draw_series(figure: SubFigure, panels: list[Callable[[Axes, Shown], None]], run: Shown) -> None:
    first: Axes | None = None
    for row, draw in enumerate(panels):
        axes = figure.add_subplot(len(panels), 1, row + 1, sharex=first)
        first = first or axes
        draw(axes, run)
        series.shade_slips(axes, run)
        series.mark_contacts(axes, run)
        series.limits_of_time(axes, run)
        axes.tick_params(labelbottom=row == len(panels) - 1)
    slips = "; grey: slipping against the field" if slipping_spans(run) else ""
    contacts = "; red bar: a wall pushes" if touching_spans(run) else ""
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
