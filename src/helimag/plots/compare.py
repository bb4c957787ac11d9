"""A measured and a simulated run laid over one another."""

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from helimag.plots._style import BLUE, MM, VERMILLION, Sheet, Size, head, styled
from helimag.runs.comparison import Comparison
from helimag.runs.measurement import NORMAL_95, interval_text
from helimag.scenario import drive_inputs, parse

Floats = NDArray[np.float64]

MEASURED, SIMULATED = BLUE, VERMILLION


COLUMN: list[list[Any]] = [["side"], ["above"], ["height"], ["attack"], ["difference"], ["text"]]
PAGE: list[list[Any]] = [["side", "side"], ["above", "above"], ["height", "attack"], ["difference", "text"]]
SLIDE: list[list[Any]] = [["side", "height", "difference"], ["above", "attack", "text"]]
TEXT = 52  # characters beside each other in a page's text
LINE, LINES = 31, 14  # characters beside each other in a slide's text, and lines of it at its usual size


def draw_comparison(comparison: Comparison, *, size: Size = "print") -> Figure:
    """Paths from the side and from above, height and attack angle over time, and the difference with its 95 % band.

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    with styled(size) as sheet:
        figure = sheet.figure((210.0 if sheet.narrow else 157.0) * MM)
        grid = figure.subplot_mosaic(COLUMN if sheet.narrow else SLIDE if sheet.wide else PAGE)
        _draw(grid, comparison, sheet)
        head(figure, _title(comparison), fontsize=sheet.points(8.0))
    return figure


def _draw(grid: dict[str, Axes], comparison: Comparison, sheet: Sheet) -> None:
    time, cuts = comparison.time, _cuts(comparison)
    shown = (comparison.simulated_time >= time[0]) & (comparison.simulated_time <= time[-1])
    measured, simulated = 1e3 * comparison.measured_position, 1e3 * comparison.simulated_path[shown]
    for name, axis, label in (("side", 2, "z (mm)"), ("above", 1, "y (mm)")):
        panel = grid[name]
        panel.plot(simulated[:, 0], simulated[:, axis], color=SIMULATED, lw=1.0, label="simulated")
        _broken(panel, measured[:, 0], measured[:, axis], cuts, label="measured")
        panel.set(xlabel="x (mm)", ylabel=label)
    grid["side"].legend(loc="best")
    grid["height"].plot(comparison.simulated_time[shown], simulated[:, 2], color=SIMULATED, lw=1.0)
    _broken(grid["height"], time, measured[:, 2], cuts)
    grid["height"].set(xlabel="time (s)", ylabel="height (mm)")
    if comparison.measured_attack is not None:
        _broken(grid["attack"], time, np.degrees(comparison.measured_attack), cuts)
    if comparison.simulated_attack is not None:
        grid["attack"].plot(time, np.degrees(comparison.simulated_attack), color=SIMULATED, lw=1.0, zorder=1)
    grid["attack"].set(xlabel="time (s)", ylabel="attack angle\n(deg)")
    _differences(grid["difference"], comparison, cuts)
    grid["text"].axis("off")
    told = _summary(comparison)
    look: dict[str, Any] = {"va": "top", "fontsize": 7.0, "linespacing": 1.5}
    if sheet.wide:
        parts = [textwrap.wrap(line, LINE, subsequent_indent="  ") for line in told.split("\n")]
        lines = [line for part in parts for line in part]
        told = "\n".join(lines)
        look |= {"fontsize": sheet.points(5.0) * min(1.0, LINES / len(lines)), "linespacing": 1.25}
    grid["text"].text(0.0, 1.0, told, transform=grid["text"].transAxes, **look)


def _title(comparison: Comparison) -> str:
    """Both runs by name, and the inputs of the simulated one."""
    names = [str(run.attributes.get("name", "run")) for run in (comparison.measured, comparison.simulated)]
    toml = comparison.simulated.scenario_toml
    inputs = "" if toml is None else f"\n{drive_inputs(parse(toml, 'the simulated run'))}"
    return f"measured: {names[0]}; simulated: {names[1]}{inputs}"


def _cuts(comparison: Comparison) -> NDArray[np.int64]:
    """Where the measured samples have a gap."""
    steps = np.diff(comparison.time)
    return np.flatnonzero(steps > 1.6 * np.median(steps)) + 1 if steps.size else np.zeros(0, np.int64)


def _broken(panel: Any, across: Floats, up: Floats, cuts: NDArray[np.int64], label: str | None = None) -> None:
    parts = zip(np.split(across, cuts), np.split(up, cuts), strict=True)
    for number, (x, y) in enumerate(parts):
        mark = "." if x.size == 1 else ""
        panel.plot(x, y, color=MEASURED, lw=0.9, marker=mark, ms=2, label=label if number == 0 else None)


def _differences(panel: Any, comparison: Comparison, cuts: NDArray[np.int64]) -> None:
    for axis, (name, colour) in enumerate((("x", "#009E73"), ("y", "#CC79A7"), ("z", "#0072B2"))):
        off = 1e3 * comparison.difference[:, axis]
        band = 1e3 * NORMAL_95 * comparison.difference_sd[:, axis]
        for number, part in enumerate(np.split(np.arange(comparison.time.size), cuts)):
            at = comparison.time[part]
            panel.plot(at, off[part], color=colour, lw=0.8, label=name if number == 0 else None)
            panel.fill_between(at, (off - band)[part], (off + band)[part], color=colour, alpha=0.2, lw=0)
    panel.axhline(0.0, color="0.6", lw=0.6, zorder=0)
    panel.set(xlabel="time (s)", ylabel="measured less\nsimulated (mm)")
    panel.legend(ncols=3, handlelength=1.0, columnspacing=0.8)


def _summary(comparison: Comparison) -> str:
    numbers = comparison.numbers
    measured, simulated = numbers["measured"], numbers["simulated"]
    note = [] if comparison.really_measured else [f"'measured' is a simulation itself ({measured['source']})"]
    doubtful = textwrap.wrap(f"doubtful: {', '.join(comparison.doubts)}", TEXT) if comparison.doubts else []
    return "\n".join(
        [
            *note,
            *doubtful,
            f"common time {numbers['from_s']:.2f} s to {numbers['until_s']:.2f} s",
            f"gain measured {measured['gain']:.4f}, {interval_text(measured['gain_95'], 4)}",
            f"gain simulated {simulated['gain']:.4f}",
            f"|y| measured {1e3 * measured['output_y_m']:.3f} mm, simulated {1e3 * simulated['output_y_m']:.3f} mm",
            f"verdict measured {measured['verdict']}, simulated {simulated['verdict']}",
            f"difference {1e3 * numbers['difference_rms_m']:.3f} mm rms, "
            f"{1e3 * numbers['difference_worst_m']:.3f} mm at most",
            f"simulated run moved by {numbers['time_shift_s']:.2f} s, turned by {numbers['yaw_deg']:.2f} deg,",
            "moved by " + ", ".join(f"{1e3 * value:.2f}" for value in numbers["translation_m"]) + " mm",
        ]
    )
