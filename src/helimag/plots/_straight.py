"""Straight runs beside each other: height over time, with what was measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from helimag.plots._style import BLUE, GREY, MM, ORANGE, PALE, SKY, Size, legend_below, styled

Floats = NDArray[np.float64]

COLUMNS, NARROW_COLUMNS = 4, 2
ROW_HEIGHT = 48.0 * MM


@dataclass(frozen=True, kw_only=True)
class StraightRun:
    """One panel: heights (m) over time (s) of a run and perturbed ones; ``measured`` is the range (m) that was.

    It reaches down from the start; negative, up. Floor and surface are heights (m), None where there is none.
    """

    title: str
    remark: str
    time: Floats
    height: Floats
    perturbed: Sequence[tuple[Floats, Floats]]
    measured: float
    floor: float | None
    surface: float | None


def draw_straight_runs(runs: Sequence[StraightRun], *, size: Size = "print") -> Figure:
    """Draw each run in a panel: its height, perturbed runs as thin lines, the measured range, floor and surface.

    Returns
    -------
    matplotlib.figure.Figure
        In mm and s; 88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    with styled(size) as sheet:
        columns = min(NARROW_COLUMNS if sheet.narrow else COLUMNS, len(runs))
        rows = -(-len(runs) // columns)
        figure = sheet.figure(rows * ROW_HEIGHT + 8.0 * MM)
        grid = np.atleast_2d(figure.subplots(rows, columns, squeeze=False))
        for axes, run in zip(grid.flat, runs, strict=False):
            _draw(axes, run)
        for axes in grid.flat[len(runs) :]:
            axes.set_visible(False)
        for axes in grid[:, 0]:
            axes.set_ylabel("height (mm)")
        handles, names = grid.flat[0].get_legend_handles_labels()
        legend_below(figure, handles, most=len(names))
    return figure


def _draw(axes: Axes, run: StraightRun) -> None:
    low, high = sorted((0.0, -1e3 * run.measured))
    axes.axhspan(low, high, color=PALE, zorder=0, label="measured range; in brackets: measured")
    for number, (time, height) in enumerate(run.perturbed):
        label = "perturbed runs" if number == 0 else None
        axes.plot(time, 1e3 * height, color=SKY, linewidth=0.4, alpha=0.7, zorder=1, label=label)
    axes.plot(run.time, 1e3 * run.height, color=BLUE, zorder=3, label="computed")
    for wall, colour, label in ((run.surface, ORANGE, "surface"), (run.floor, GREY, "floor")):
        if wall is not None:
            axes.axhline(1e3 * wall, color=colour, linewidth=0.7, linestyle="--", label=label)
    reach = 1e3 * max(abs(run.measured), float(np.abs(run.height).max()))
    axes.set_ylim(-1.25 * reach - 1.0, min(1.25 * reach, 4.0) + 1.0)
    axes.set_title(f"{run.title}\n{run.remark}", loc="left", fontsize=5.6)
    axes.set_xlabel("time (s)")
