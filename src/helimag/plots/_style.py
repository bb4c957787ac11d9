"""Looks: sizes that suit a two-column paper, and colours that the colour-blind can tell apart."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import matplotlib as mpl

MM = 1.0 / 25.4  # inches
FULL_WIDTH = 180.0 * MM  # of a two-column page

# Okabe and Ito, "Color universal design" (2008)
BLUE = "#0072B2"
VERMILLION = "#D55E00"
GREEN = "#009E73"
SKY = "#56B4E9"
ORANGE = "#E69F00"
PURPLE = "#CC79A7"
YELLOW = "#F0E442"
GREY = "#7F7F7F"
PALE = "#D9D9D9"
LIGHT = "#CCCCCC"  # of what is undecided: no colour comes near it for any eye
DARK = "#404040"
WHITE = "#FFFFFF"

TIME_COLOURS = "viridis"  # even in lightness, so it survives grey printing

STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 7.0,
    "axes.labelsize": 7.0,
    "axes.titlesize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "lines.linewidth": 0.9,
    "grid.linewidth": 0.4,
    "grid.color": "#E5E5E5",
    "savefig.dpi": 300,
    "svg.fonttype": "path",
    "svg.hashsalt": "helimag",
    "pdf.fonttype": 42,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in helimag's style without changing the caller's."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(cast(Any, STYLE))
        yield
