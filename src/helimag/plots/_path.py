"""The path in three dimensions."""

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from helimag.geometry import long_axes
from helimag.plots._limits import draw_limits, limits_met
from helimag.plots._quantities import Shown
from helimag.plots._style import BLUE, DARK, GREY, ORANGE, PALE, TIME_COLOURS, VERMILLION

Floats = NDArray[np.float64]

FILL = 0.94  # of the axes' height by a box on the screen, which leaves room for its labels
DEVICES = 3  # drawn along the path
DEVICE = 0.09  # of the box, their length
MOST_SEGMENTS = 900  # of the coloured line: enough for the eye, and a vector file stays small


def draw_path(axes: Axes3D, run: Shown, *, until: float | None = None, ticks: int = 6) -> Line3DCollection:
    """Draw head and magnet in the lab frame, axes equal (mm).

    Parameters
    ----------
    axes
        Three-dimensional.
    run
        The run.
    until
        Where the colours of time end (s); default the run's end.
    ticks
        About how many numbers stand along the longest side.

    Returns
    -------
    Line3DCollection
        The head's path, coloured by time (s), for a colour bar.
    """
    low, high = extent(run)
    frame_box(axes, low, high, ticks=ticks)
    draw_limits(axes, run, low, high)
    head = run.position[np.isfinite(run.position).all(axis=1)]
    axes.plot(head[:, 0], head[:, 1], low[2], color=PALE, linewidth=0.5, zorder=0)
    if run.magnet is not None:
        axes.plot(*run.magnet.T, color=GREY, linewidth=0.8, zorder=1)
        axes.plot(
            *run.magnet[-1:].T, "s", color=GREY, markersize=4.5, zorder=4, label="magnet at the end, and its path"
        )
    line = time_coloured(run, float(run.time[-1]) if until is None else until)
    axes.add_collection3d(line)
    axes.plot(
        *head[:1].T,
        "o",
        color=BLUE,
        markersize=4,
        markeredgecolor="white",
        markeredgewidth=0.5,
        zorder=5,
        label="start",
    )
    axes.plot(
        *head[-1:].T,
        "D",
        color=VERMILLION,
        markersize=4,
        markeredgecolor="white",
        markeredgewidth=0.5,
        zorder=5,
        label="end",
    )
    _draw_device(axes, run, float((high - low).max()))
    return line


def _draw_device(axes: Axes3D, run: Shown, size: float) -> None:
    """The device at a few places, enlarged: a bar whose dot is the head, so that one sees which end leads."""
    if run.quaternion is None or run.scenario is None:
        return
    whole = np.flatnonzero(np.isfinite(run.position).all(axis=1) & np.isfinite(run.quaternion).all(axis=1))
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(run.position[whole], axis=0), axis=1))])
    wanted = np.linspace(0.0, travelled[-1], DEVICES + 2)[1:-1]
    places = np.unique(whole[np.searchsorted(travelled, wanted).clip(0, whole.size - 1)])
    length = DEVICE * size
    times = max(1, round(length / (1e3 * run.scenario.device.length)))
    for number, (place, nose) in enumerate(zip(places, long_axes(run.quaternion[places]), strict=True)):
        head = run.position[place]
        tail = head - times * 1e3 * run.scenario.device.length * nose
        label = "device's long axis, dot: head" if number == 0 else None
        axes.plot(*np.stack([head, tail], axis=1), color=ORANGE, linewidth=1.4, zorder=4)
        axes.plot(*head[:, None], "o", color=DARK, markersize=2.6, zorder=5)
        if label is not None:
            axes.plot(
                [], [], [], "-o", color=ORANGE, markerfacecolor=DARK, markeredgecolor=DARK, markersize=2.6, label=label
            )


def time_coloured(run: Shown, until: float) -> Line3DCollection:
    """The head's path as short segments coloured by time (s); it breaks where a sample is missing."""
    step = max(1, -(-run.time.size // MOST_SEGMENTS))
    chosen = np.unique(np.append(np.arange(0, run.time.size, step), run.time.size - 1))
    points, times = run.position[chosen], run.time[chosen]
    segments = np.stack([points[:-1], points[1:]], axis=1)
    whole = np.isfinite(segments).all(axis=(1, 2))
    line = Line3DCollection(
        list(segments[whole]),
        cmap=TIME_COLOURS,
        norm=Normalize(run.time[0], until),
        linewidth=1.1,
        capstyle="round",
        zorder=3,
    )
    line.set_array(((times[:-1] + times[1:]) / 2.0)[whole])
    return line


def extent(run: Shown, *, around_magnet: float = 0.0) -> tuple[Floats, Floats]:
    """Lowest and highest corner (mm) of what the run covers, the magnet's path and as much around it, with a margin."""
    points = run.position
    for met in limits_met(run):
        beside = points[np.isfinite(points).all(axis=1)][-1:].copy()
        beside[:, met.axis] = met.level
        points = np.concatenate([points, beside])
    if run.magnet is not None:
        points = np.concatenate([points, run.magnet - around_magnet, run.magnet + around_magnet])
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    size = float((high - low).max())
    # a flat box would hide its own axes: no side shorter than a quarter of the longest
    grow = np.maximum(0.25 * max(size, 1e-3) - (high - low), 0.0) / 2.0 + 0.04 * max(size, 1e-3)
    return low - grow, high + grow


def frame_box(axes: Axes3D, low: Floats, high: Floats, *, ticks: int = 6) -> None:
    """Axes of equal scale with light panes, few ticks, and units."""
    sides = high - low
    tall = sides[2] > 1.3 * max(sides[:2])
    axes.computed_zorder = False  # the path over the magnet's, its ends over both
    axes.patch.set_visible(False)
    axes.set_proj_type("ortho")
    axes.view_init(elev=18.0, azim=-55.0)
    turn, lift = np.radians([axes.azim, axes.elev])
    height = sides @ np.abs([np.cos(turn) * np.sin(lift), np.sin(turn) * np.sin(lift), np.cos(lift)])
    axes.set_box_aspect(tuple(sides), zoom=min(1.1, FILL * np.linalg.norm(sides) / height))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    # matplotlib moves labels away from an axis in proportion to the box' other sides: undo that
    stretch = float(mpl.rcParams["font.size"]) / 7.0 * np.linalg.norm(sides) / np.sqrt(np.sum(sides**2) - sides**2)
    for i, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        axis.set_ticks(_ticks(low[i], high[i], max(2, round(ticks * sides[i] / sides.max()))))
        axis.set_label_text(f"{'xyz'[i]} (mm)")
        axis.set_pane_color((0.975, 0.975, 0.975, 1.0))
        axis._axinfo["grid"].update(color="#E0E0E0", linewidth=0.4)
        axis.labelpad = 11.8 * stretch[i] - 21.0
        axis.set_tick_params(pad=4.6 * stretch[i] - 8.0)
    if tall:  # x and y meet in the front corner of a narrow box: each gives up its tick there
        axes.set_xticks(axes.get_xticks()[:-1])
        axes.set_yticks(axes.get_yticks()[1:])


def _ticks(low: float, high: float, bins: int) -> Floats:
    """Round values strictly inside a range."""
    values = np.asarray(MaxNLocator(nbins=bins, steps=[1, 2, 5, 10]).tick_values(low, high))
    return values[(values > low) & (values < high)]
