"""Runs beside each other, each with others that start almost the same: the layout of the paper's Fig. 3."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

from helimag.plots import _series as series
from helimag.plots._path import draw_path
from helimag.plots._quantities import Shown, shown
from helimag.plots._style import FULL_WIDTH, GREY, MM, SKY, styled
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

HEIGHT = 138.0 * MM
LINE = 44  # characters that fit above a column

PUBLISHED: dict[str, Any] = {"color": GREY, "linewidth": 0.7, "linestyle": "-."}


@dataclass(frozen=True, kw_only=True)
class Case:
    """One column: a run, heading and remark, perturbed runs (times in s, heights in m), and a published time (s)."""

    trajectory: Trajectory
    title: str
    remark: str = ""
    twins: Sequence[tuple[Floats, Floats]] = ()
    published_time: float | None = None


def draw_side_by_side(cases: Sequence[Case]) -> Figure:
    """Draw each case in a column: path with the magnet's, then height over time with the perturbed runs as thin lines.

    Parameters
    ----------
    cases
        Two to four suit a page.

    Returns
    -------
    matplotlib.figure.Figure
        180 mm wide. Lengths are in mm, times in s.
    """
    runs = [shown(case.trajectory) for case in cases]
    until = max(run.time[-1] for run in runs)
    width = 1.0 / len(cases)
    with styled():
        figure = Figure(figsize=(FULL_WIDTH, HEIGHT))
        for column, (case, run) in enumerate(zip(cases, runs, strict=True)):
            left = column * width
            _head(figure, left + 0.012, case, run)
            path = figure.add_axes((left - 0.019, 0.39, 0.96 * width, 0.44), projection="3d")
            line = draw_path(path, run, until=until)
            heights = figure.add_axes((left + 0.21 * width, 0.15, 0.61 * width, 0.18))
            _draw_heights(heights, case, run, until)
            if column > 0:
                heights.set_ylabel("")
        _draw_key(figure, path, line)
    return figure


def _draw_key(figure: Figure, path: Axes, line: Line3DCollection) -> None:
    """Colours of time and what the marks mean, below all columns."""
    bar = figure.add_axes((0.07, 0.06, 0.22, 0.012))
    figure.colorbar(line, cax=bar, orientation="horizontal").set_label("time along the path (s)", labelpad=1.0)
    marks, names = path.get_legend_handles_labels()
    figure.legend(
        [*marks, Line2D([], [], color=SKY, linewidth=0.8), Line2D([], [], **PUBLISHED)],
        [*names, "starts 0.05 mm off", "time given in the paper"],
        loc="center left",
        bbox_to_anchor=(0.33, 0.055),
        ncols=3,
        columnspacing=1.0,
        handletextpad=0.3,
        handlelength=1.2,
    )


def _head(figure: Figure, left: float, case: Case, run: Shown) -> None:
    figure.text(left, 0.985, case.title, weight="bold", fontsize=8.0, va="top")
    verdict = re.sub(r"(?<=\d) (?=(s|mm)\b)", "\N{NO-BREAK SPACE}", run.verdict)
    text = "\n".join(textwrap.wrap(verdict, LINE) + case.remark.splitlines())
    figure.text(left, 0.953, text, fontsize=6.5, va="top", linespacing=1.35)


def _draw_heights(axes: Axes, case: Case, run: Shown, until: float) -> None:
    for time, height in case.twins:
        axes.plot(time, 1e3 * height, color=SKY, linewidth=0.35, alpha=0.6, zorder=1)
    series.draw_height(axes, run)
    if case.published_time is not None:
        axes.axvline(case.published_time, **PUBLISHED)
    axes.set(xlim=(0.0, until), xlabel="time (s)")
    axes.grid(axis="y")
    axes.set_axisbelow(True)
