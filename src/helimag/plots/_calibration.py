"""Figure of a calibration: each free input and each pair, and what the runs of the posterior say beside the data."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray

from helimag.calibration import Posterior, shown_unit
from helimag.plots._style import BLUE, DARK, GREY, MM, PALE, VERMILLION, Sheet, Size, head, styled

Floats = NDArray[np.float64]

BINS = 20
MARGIN = 0.08  # beside the samples, of their range
ROW = 7.0 * MM  # of an observation
MOST_SAMPLES = 500  # dots in a pair's panel
WIDEST = 6.0  # standard deviations of the data that the bands' axis reaches at most


def draw_fit(fit: Posterior, *, size: Size = "print") -> Figure:
    """Draw a posterior.

    Parameters
    ----------
    fit
        As :func:`helimag.calibration.calibrate` gives it.
    size
        "small", where what is said to be right is below; "print", or "slide".

    Returns
    -------
    Figure
        88, 180 or 160 mm wide. Left: histograms of each free input, behind them what they share with its prior's 5 to
        95 %, and samples of each pair, the best marked.
        Right: what each observation would be in the runs of the posterior, less what was observed, in standard
        deviations of the data.
    """
    labels = list(dict.fromkeys(fit.labels))
    inputs = len(fit.names)
    pairs, bands = 25.0 * MM * (inputs + 0.6), 22.0 * MM + ROW * len(labels)
    with styled(size) as sheet:
        if sheet.narrow:
            figure = sheet.figure(pairs + bands)
            grid = figure.add_gridspec(2, 1, height_ratios=(pairs, bands))
        else:
            figure = sheet.figure(max(pairs, bands))
            grid = figure.add_gridspec(1, 2, width_ratios=(1.7, 1.0))
        left, right = (figure.add_subfigure(part) for part in (grid[0], grid[1]))
        _draw_pairs(left, fit, sheet)
        _draw_bands(right.subplots(), fit, labels, sheet)
    return figure


def _draw_pairs(figure: SubFigure, fit: Posterior, sheet: Sheet) -> None:
    count = len(fit.names)
    panels = np.atleast_2d(figure.subplots(count, count, squeeze=False))
    scaled, prior = fit.samples.copy(), fit.prior.copy()
    titles = []
    for i, name in enumerate(fit.names):
        scale, unit = shown_unit(fit, i)
        scaled[:, i] /= scale
        prior[:, i] /= scale
        titles.append(f"{_short(name)}\n({unit})" if unit else _short(name))
    best = scaled[fit.place]
    for row in range(count):
        for column in range(count):
            panel = panels[row, column]
            if column > row:
                panel.remove()
            elif column == row:
                _draw_one(panel, scaled[:, row], prior[:, row], best[row])
            else:
                panel.plot(*scaled[:MOST_SAMPLES, [column, row]].T, ".", color=BLUE, ms=1.5, alpha=0.6)
                panel.plot(best[column], best[row], "+", color=VERMILLION, ms=6.0)
            if column <= row:
                panel.set_xlim(*_range(scaled[:, column]))
                _label(panel, titles, row, column, count)
    title = f"{fit.plan.name}: posterior (blue), 5 to 95 % of the prior (grey), best (red)"
    head(figure, title, fontsize=sheet.points(7.0))


def _draw_one(panel: Axes, values: Floats, prior: Floats, best: float) -> None:
    panel.axvspan(prior[0], prior[2], color=PALE, lw=0)
    panel.hist(values, bins=BINS, color=BLUE)
    panel.axvline(best, color=VERMILLION)
    panel.set_yticks([])


def _range(values: Floats) -> tuple[float, float]:
    """Of a column's axis: all samples, and a little beside them."""
    beside = MARGIN * float(np.ptp(values)) or 1e-12
    return float(values.min()) - beside, float(values.max()) + beside


def _label(panel: Axes, titles: list[str], row: int, column: int, count: int) -> None:
    panel.locator_params(axis="x", nbins=3)
    if row != column:
        panel.locator_params(axis="y", nbins=3)
    if row == count - 1:
        panel.set_xlabel(titles[column])
    else:
        panel.set_xticklabels([])
    if column == 0 and row > 0:
        panel.set_ylabel(titles[row])
    elif row != column:
        panel.set_yticklabels([])


def _short(name: str) -> str:
    """The last part of a path; of a component, with what it is of."""
    parts = name.split(".")
    return " ".join(parts[-2:] if len(parts[-1]) == 1 else parts[-1:]).replace("_", " ")


def _draw_bands(panel: Axes, fit: Posterior, labels: list[str], sheet: Sheet) -> None:
    off = fit.off
    own = np.array(fit.labels)
    panel.axvspan(-1.0, 1.0, color=PALE, lw=0)
    panel.axvline(0.0, color=GREY)
    for place, label in enumerate(labels):
        part = off[:, own == label]
        low, middle, high = np.clip(np.quantile(part, (0.05, 0.5, 0.95)), -WIDEST, WIDEST)
        panel.plot([low, high], [place, place], color=BLUE, lw=2.5, solid_capstyle="butt")
        panel.plot(middle, place, "o", color=DARK, ms=3.0)
        if part.shape[1] == 1:
            panel.plot(np.clip(part[fit.place, 0], -WIDEST, WIDEST), place, "+", color=VERMILLION, ms=6.0)
    panel.set_title("90 % of them (blue),\nmiddle (dot), best (red)", fontsize=sheet.points(7.0))
    panel.set_yticks(range(len(labels)), labels)
    panel.set_ylim(len(labels) - 0.5, -0.5)
    reach = 1.15 * max(2.0, float(np.abs(panel.get_xlim()).max()))
    panel.set_xlim(-min(reach, WIDEST + 0.3), min(reach, WIDEST + 0.3))
    panel.set_xlabel("runs of the posterior\nless data (sd of the data)")
