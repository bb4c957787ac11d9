"""Looks: sizes that suit a two-column paper and a slide, and colours that the colour-blind can tell apart."""

import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, cast, get_args

import matplotlib as mpl
from matplotlib.figure import Figure, SubFigure
from matplotlib.text import Text

from helimag.errors import InputError

MM = 1.0 / 25.4  # inches
JOINED = "\N{NO-BREAK SPACE}"
FILLED = 0.96  # of the width, by a heading or a legend
TYPE = 7.0  # points, of the words in a paper's figure

Size = Literal["small", "print", "slide"]

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

FONTS = {  # points
    "font.size": TYPE,
    "figure.titlesize": 7.5,
    "axes.labelsize": 7.0,
    "axes.titlesize": 8.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
}
STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "lines.linewidth": 0.9,
    "grid.linewidth": 0.4,
    "grid.color": "#E5E5E5",
    "savefig.dpi": 300,
    "svg.fonttype": "path",
    "svg.hashsalt": "helimag",
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class Sheet:
    """What a figure is drawn on: its width and, where it is given, height (inches); the size of its words (points).

    A ``narrow`` one has its panels below each other, a ``wide`` one beside each other.
    """

    width: float
    height: float | None = None
    type: float = TYPE

    @property
    def narrow(self) -> bool:
        """Whether one panel fills the width."""
        return self.width < 100.0 * MM

    @property
    def wide(self) -> bool:
        """Whether the height is given, and panels must share the width."""
        return self.height is not None

    def figure(
        self, height: float, *, share: float = 1.0, layout: Literal["constrained"] | None = "constrained"
    ) -> Figure:
        """A figure that would like to be so high (inches), and as wide as a share of a paper's page."""
        size = (self.width if self.narrow else self.width * share, height)
        return Figure(figsize=size if self.height is None else (self.width, self.height), layout=layout)

    def points(self, size: float) -> float:
        """The size of words that are so large (points) in a paper."""
        return size * self.type / TYPE


# a column and the page of a two-column paper; and a slide of 160 mm by 90 mm, as LaTeX's beamer has it: blown up to the
# 339 mm of other programmes' slides, its words have 18 points
SHEETS: dict[str, Sheet] = {
    "small": Sheet(88.0 * MM),
    "print": Sheet(180.0 * MM),
    "slide": Sheet(160.0 * MM, 90.0 * MM, 8.5),
}


_DRAWING = threading.RLock()


@contextmanager
def styled(size: Size = "print") -> Iterator[Sheet]:
    """Draw in helimag's style without changing the caller's; one thread at a time, as Matplotlib has one style for all.

    Yields
    ------
    Sheet
        To take figures from.

    Raises
    ------
    InputError
        Where there is no such size.
    """
    if size not in SHEETS:
        raise InputError(f"size must be one of {', '.join(get_args(Size))}; got '{size}'")
    sheet = SHEETS[size]
    with _DRAWING, mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(cast(Any, STYLE | {name: sheet.points(points) for name, points in FONTS.items()}))
        yield sheet


def head(figure: Figure | SubFigure, text: str, **looks: Any) -> None:
    """A heading over all of a figure, broken into lines where it is wider."""
    fill(figure.suptitle("", **looks), text, FILLED * figure.bbox.width)


def fill(artist: Text, text: str, width: float) -> None:
    """Set a text, broken into lines where it is wider (dots), but not between a number and its unit or its name."""
    lines = []
    for line in re.sub(r"(?<=\d) (?=[A-Za-z°%])|(?<=[a-z]) (?=\d)", JOINED, text).split("\n"):
        first, *words = line.split(" ")
        lines.append(first)
        for word in words:
            artist.set_text(f"{lines[-1]} {word}")
            if artist.get_window_extent().width > width:
                lines.append(word)
            else:
                lines[-1] += f" {word}"
    artist.set_text("\n".join(lines).replace(JOINED, " "))


def legend_below(figure: Figure, handles: Sequence[Any], *, most: int) -> None:
    """A legend below all of a figure, in as many columns as fit into its width."""
    for columns in range(most, 0, -1):
        legend = figure.legend(handles=list(handles), loc="outside lower center", ncols=columns)
        if columns == 1 or legend.get_window_extent().width <= FILLED * figure.bbox.width:
            return
        legend.remove()
