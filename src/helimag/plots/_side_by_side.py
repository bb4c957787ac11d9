"""Runs beside each other, each with others that start almost the same: the layout of the paper's Fig. 3."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

from helimag.plots import _series as series
from helimag.plots._path import draw_path
from helimag.plots._quantities import Shown, shown
from helimag.plots._style import GREY, MM, SKY, Sheet, Size, styled
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

HEIGHT = 138.0 * MM
ROW_HEIGHT, KEY_HEIGHT = 68.0 * MM, 25.0 * MM  # where the cases are below each other
WORDS, LETTER = 6.5, 1.363 * MM  # size of the words (points), and how wide a letter is then, on average
# of path and heights: bottom and height, in shares of the figure
PRINT_ROWS = (0.39, 0.44), (0.15, 0.18)
SLIDE_ROWS = (0.43, 0.35), (0.22, 0.105)
TITLE = 4.4 * MM  # from a title's top to the words below it

PUBLISHED: dict[str, Any] = {"color": GREY, "linewidth": 0.7, "linestyle": "-."}


@dataclass(frozen=True, kw_only=True)
class Case:
    """One column: a run, heading and remark, perturbed runs (times in s, heights in m), and a published time (s)."""

    trajectory: Trajectory
    title: str
    remark: str = ""
    perturbed: Sequence[tuple[Floats, Floats]] = ()
    published_time: float | None = None


class Slot(NamedTuple):
    """Where a case is drawn, in shares of the figure: its words' upper left corner, its path and its heights.

    The latter two as left, bottom, width and height; and how many characters fit on a line of words.
    """

    words: tuple[float, float]
    path: tuple[float, float, float, float]
    heights: tuple[float, float, float, float]
    line: int


def draw_side_by_side(cases: Sequence[Case], *, size: Size = "print") -> Figure:
    """Draw each case in a column: path with the magnet's, then height over time with the perturbed runs as thin lines.

    In a column of a paper, the cases are below each other.

    Parameters
    ----------
    cases
        Two to four suit a page.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide. Lengths are in mm, times in s.
    """
    runs = [shown(case.trajectory) for case in cases]
    until = max(run.time[-1] for run in runs)
    with styled(size) as sheet:
        figure = sheet.figure(ROW_HEIGHT * len(cases) + KEY_HEIGHT if sheet.narrow else HEIGHT, layout=None)
        for number, (slot, case, run) in enumerate(zip(_slots(sheet, figure, len(cases)), cases, runs, strict=True)):
            _words(figure, slot, case, run, sheet)
            path = figure.add_axes(slot.path, projection="3d")
            line = draw_path(path, run, until=until, ticks=2 if sheet.wide else 6)
            heights = figure.add_axes(slot.heights)
            _draw_heights(heights, case, run, until)
            if number > 0 and not sheet.narrow:
                heights.set_ylabel("")
            elif sheet.wide:
                heights.set_ylabel("z (mm)")
        _draw_key(figure, path, line, sheet)
    return figure


def _slots(sheet: Sheet, figure: Figure, count: int) -> list[Slot]:
    """Columns; in a column of a paper, rows."""
    line = int(sheet.width / LETTER * WORDS / _words_size(sheet))
    if sheet.narrow:
        row, key = ROW_HEIGHT / figure.get_figheight(), KEY_HEIGHT / figure.get_figheight()
        bottoms = [key + row * (count - 1 - number) for number in range(count)]
        return [
            Slot(
                (0.02, bottom + 0.97 * row),
                (-0.06, bottom + 0.09 * row, 0.58, 0.57 * row),
                (0.69, bottom + 0.19 * row, 0.19, 0.42 * row),
                line,
            )
            for bottom in bottoms
        ]
    width = 1.0 / count
    (path_bottom, path_height), (bottom, height) = SLIDE_ROWS if sheet.wide else PRINT_ROWS
    return [
        Slot(
            (left + 0.012, 0.985),
            (left - 0.024, path_bottom, 0.96 * width, path_height),
            (left + (0.24 if sheet.wide else 0.21) * width, bottom, (0.52 if sheet.wide else 0.61) * width, height),
            line // count,
        )
        for left in (number * width for number in range(count))
    ]


def _draw_key(figure: Figure, path: Axes, line: Line3DCollection, sheet: Sheet) -> None:
    """Colours of time and what the marks mean, below all cases."""
    key = KEY_HEIGHT / figure.get_figheight()
    along = (0.1, 0.86 * key, 0.8, 0.06 * key) if sheet.narrow else (0.07, 0.1 if sheet.wide else 0.06, 0.22, 0.012)
    bar = figure.add_axes(along)
    figure.colorbar(line, cax=bar, orientation="horizontal").set_label("time along the path (s)", labelpad=1.0)
    marks, names = path.get_legend_handles_labels()
    figure.legend(
        [*marks, Line2D([], [], color=SKY, linewidth=0.8), Line2D([], [], **PUBLISHED)],
        [*names, "starts 0.05 mm off", "time given in the paper"],
        **({"loc": "lower center"} if sheet.narrow else {"loc": "center left", "bbox_to_anchor": (0.33, 0.055)}),
        ncols=2 if sheet.narrow else 3,
        columnspacing=1.0,
        handletextpad=0.3,
        handlelength=1.2,
        fontsize=sheet.points(5.0 if sheet.wide else 6.5),
    )


def _words_size(sheet: Sheet) -> float:
    """Points."""
    return sheet.points(5.6 if sheet.wide else WORDS)


def _words(figure: Figure, slot: Slot, case: Case, run: Shown, sheet: Sheet) -> None:
    left, top = slot.words
    figure.text(left, top, case.title, weight="bold", fontsize=sheet.points(8.0), va="top")
    told = run.verdict.partition(":")[0] if sheet.wide else run.verdict  # a slide has no room for why
    verdict = re.sub(r"(?<=\d) (?=(s|mm)\b)", "\N{NO-BREAK SPACE}", told)
    lines = [part for line in (verdict, *case.remark.splitlines()) for part in textwrap.wrap(line, slot.line)]
    below = top - sheet.points(TITLE) / figure.get_figheight()
    figure.text(left, below, "\n".join(lines), fontsize=_words_size(sheet), va="top", linespacing=1.35)


def _draw_heights(axes: Axes, case: Case, run: Shown, until: float) -> None:
    for time, height in case.perturbed:
        axes.plot(time, 1e3 * height, color=SKY, linewidth=0.35, alpha=0.6, zorder=1)
    series.draw_height(axes, run)
    if case.published_time is not None:
        axes.axvline(case.published_time, **PUBLISHED)
    axes.set(xlim=(0.0, until), xlabel="time (s)")
    axes.grid(axis="y")
    axes.set_axisbelow(True)
