"""Panels over time; each draws one quantity of a run into given axes."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from helimag.plots._limits import limits_met
from helimag.plots._quantities import Shown, lag_in_step, slipping_spans, touching_spans
from helimag.plots._style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION

Floats = NDArray[np.float64]


def draw_height(axes: Axes, run: Shown) -> None:
    """Height of the head with its range between samples, of its start, and of the magnet (mm)."""
    axes.fill_between(run.time, run.low, run.high, color=BLUE, alpha=0.35, linewidth=0.0)
    axes.plot(run.time, run.position[:, 2], color=BLUE)
    start = float(run.position[0, 2])
    axes.axhline(start, color=GREY, linewidth=0.6, linestyle=":")
    levels = [met.level for met in limits_met(run) if met.axis == 2]
    low, high = float(np.nanmin(run.low)), float(np.nanmax(run.high))
    room = 0.12 * (max(high, *levels) - min(low, *levels)) if levels else 0.0
    if all(abs(level - start) > room for level in levels):
        _margin_label(axes, start, "start", GREY)
    if run.magnet is not None and _fits(float(run.magnet[-1, 2]), np.append(run.position[:, 2], start)):
        axes.plot(run.time, run.magnet[:, 2], color=GREY, linewidth=0.8, linestyle="--")
        _margin_label(axes, float(run.magnet[-1, 2]), "magnet", GREY)
    for met in limits_met(run):
        if met.axis == 2:
            axes.axhline(met.level, color=met.colour, linewidth=1.2)
            _margin_label(axes, met.level, str(met.limit), met.colour)
    axes.set_ylabel("height z (mm)")


def draw_gap(axes: Axes, run: Shown) -> None:
    """Distance between the centres of head and magnet, and where they touch (mm)."""
    if run.gap is not None:
        axes.plot(run.time, run.gap, color=GREEN)
    contact = np.nan if run.scenario is None else 1e3 * run.scenario.contact_distance
    if run.gap is not None and _fits(contact, run.gap):
        axes.axhline(contact, color=VERMILLION, linewidth=0.6, linestyle="--")
        _margin_label(axes, contact, "contact", VERMILLION)
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel("gap (mm)")


def draw_attack(axes: Axes, run: Shown) -> None:
    """Attack angle of the long axis: mean between samples, and standard deviation within (deg)."""
    if run.attack is not None:
        spread = 0.0 if run.attack_spread is None else run.attack_spread
        low, high = run.attack - spread, run.attack + spread
        axes.fill_between(run.time, low, high, color=ORANGE, alpha=0.35, linewidth=0.0)
        axes.plot(run.time, run.attack, color=ORANGE)
    axes.axhline(0.0, color=GREY, linewidth=0.6, linestyle=":")
    axes.set_ylabel("attack angle\n(deg)")


def draw_lag(axes: Axes, run: Shown) -> None:
    """Phase lag behind the field at the samples where the device is in step with it (deg)."""
    axes.plot(run.time, lag_in_step(run), ".", color=PURPLE, markersize=1.8, markeredgewidth=0.0)
    axes.set(ylim=(-190.0, 190.0), yticks=[-180, -90, 0, 90, 180])
    axes.set_ylabel("phase lag\n(deg)")


def shade_slips(axes: Axes, run: Shown) -> None:
    """Shade where the device slips against the field."""
    for start, end in slipping_spans(run):
        axes.axvspan(start, end, color="#EDEDED", linewidth=0.0, zorder=0)


def mark_contacts(axes: Axes, run: Shown) -> None:
    """A bar along the time axis where a wall pushes the device."""
    for start, end in touching_spans(run):
        axes.axvspan(start, end, 0.0, 0.035, color=VERMILLION, linewidth=0.0, zorder=1)


def limits_of_time(axes: Axes, run: Shown) -> None:
    """From the first sample to the last."""
    if run.time[-1] > run.time[0]:
        axes.set_xlim(run.time[0], run.time[-1])
    axes.grid(axis="y")
    axes.set_axisbelow(True)


def _fits(level: float, curve: Floats) -> bool:
    """Whether a level can be shown without flattening the curve: with it, the curve still has a tenth of the height."""
    low, high = float(np.nanmin(curve)), float(np.nanmax(curve))
    return high - low > 0.1 * (max(high, level) - min(low, level))


def _margin_label(axes: Axes, height: float, text: str, colour: str) -> None:
    """Name a level line in the margin to the right of the axes, where no curve can run through the text."""
    if np.isfinite(height):
        axes.annotate(
            text,
            (1.01, height),
            xycoords=("axes fraction", "data"),
            color=colour,
            fontsize="small",
            va="center",
            ha="left",
        )
