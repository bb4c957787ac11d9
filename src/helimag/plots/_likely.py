"""How likely a device stays, over the points of a sweep with an ensemble: maps of shares, and bands of gain."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from helimag.plots._style import BLUE, TIME_COLOURS, VERMILLION

if TYPE_CHECKING:
    import xarray

STAYING = "probability_inside"
EVEN, LIKELY = 0.5, 0.9  # shares at which a map has lines
LINES: dict[str, dict[str, Any]] = {
    "half of the devices": {"color": "black", "linewidth": 0.8, "linestyle": "--"},
    "nine in ten": {"color": "black", "linewidth": 0.8},
    "the likeliest device stays": {"color": VERMILLION, "linewidth": 1.2, "linestyle": ":"},
}
SHARES: dict[str, Any] = {"vmin": 0.0, "vmax": 1.0, "cmap": colormaps[TIME_COLOURS]}


def ran_devices(dataset: "xarray.Dataset") -> bool:
    """Whether each point of a sweep was run with devices of an ensemble."""
    return STAYING in dataset


def draw_shares(axes: Axes, part: "xarray.Dataset", x: Any, y: Any) -> None:
    """The share of the devices that stay as colours, y first, with lines at even and at nine in ten."""
    share = part[STAYING].values
    axes.pcolormesh(x, y, share, shading="nearest", linewidth=0, **SHARES)
    nominal = np.isnan(part["escape_time"].values).astype(float)
    for field, level, look in zip((share, share, nominal), (EVEN, LIKELY, 0.5), LINES.values(), strict=True):
        if np.nanmin(field) < level <= np.nanmax(field):
            axes.contour(
                x,
                y,
                field,
                levels=[level],
                colors=look["color"],
                linewidths=look["linewidth"],
                linestyles=look.get("linestyle", "-"),
            )


def draw_shares_at(axes: Axes, part: "xarray.Dataset", x: Any, y: Any) -> None:
    """The same at points of a plane."""
    axes.scatter(x, y, c=part[STAYING].values, s=10, edgecolors="black", linewidths=0.3, **SHARES)


def add_scale(figure: Figure) -> list[Line2D]:
    """The colours' scale, and a line of each look for the legend."""
    scale = ScalarMappable(Normalize(0.0, 1.0), SHARES["cmap"])
    figure.colorbar(scale, ax=figure.axes, label="share of devices that stay to the end")
    return [Line2D([], [], label=label, **look) for label, look in LINES.items()]


def draw_band(axes: Axes, row: "xarray.Dataset", values: Any, top: float) -> None:
    """5 to 95 % of the devices' gains below a curve, and the share that stays on an axis at the right."""
    low, high = (np.minimum(row[name].values, top) for name in ("gain_p05", "gain_p95"))
    axes.fill_between(values, low, high, color=BLUE, alpha=0.25, linewidth=0, zorder=0)
    right = axes.twinx()
    right.plot(values, row[STAYING].values, color=BLUE, linewidth=0.8, linestyle="--")
    right.set_ylim(0.0, 1.05)
    right.set_ylabel("share that stays", color=BLUE)
