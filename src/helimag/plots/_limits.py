"""Floor, surface and walls: which of them a run meets, and how they are drawn."""

import math
from dataclasses import dataclass

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from helimag.outcomes import End, Limit
from helimag.plots._quantities import Shown
from helimag.plots._style import ORANGE, SKY

Floats = NDArray[np.float64]

# of each limit: the coordinate that it bounds, and whether from above
SIDES = {
    Limit.FLOOR: (2, 0),
    Limit.SURFACE: (2, 1),
    Limit.LOW_X: (0, 0),
    Limit.HIGH_X: (0, 1),
    Limit.LOW_Y: (1, 0),
    Limit.HIGH_Y: (1, 1),
}
ENDS: dict[End | None, tuple[Limit, ...]] = {
    End.FLOOR: (Limit.FLOOR,),
    End.SURFACE: (Limit.SURFACE,),
    End.WALL: tuple(SIDES)[2:],
}
COLOURS = {Limit.SURFACE: SKY}
COLOUR = ORANGE


@dataclass(frozen=True)
class Met:
    """A limit that ends a run or holds the device: along which coordinate (0, 1, 2) it lies, and where (mm)."""

    limit: Limit
    axis: int
    level: float

    @property
    def colour(self) -> str:
        """What it is drawn in."""
        return COLOURS.get(self.limit, COLOUR)


def limits_met(run: Shown) -> list[Met]:
    """What a run ends at, and what it touches on the way."""
    if run.scenario is None:
        return []
    box = run.scenario.workspace.box
    known = [
        Met(limit, axis, 1e3 * box[upper][axis])
        for limit, (axis, upper) in SIDES.items()
        if math.isfinite(box[upper][axis])
    ]
    touched = {touch.wall for touch in run.judgement.touches} if run.judgement is not None else set()
    ending = [each for each in known if each.limit in ENDS.get(run.end, ())]
    last = run.position[np.isfinite(run.position).all(axis=1)][-1]
    ending.sort(key=lambda each: abs(float(last[each.axis]) - each.level))  # which upright wall, is not recorded
    touched |= {each.limit for each in ending[:1]}
    return [each for each in known if each.limit in touched]


def draw_limits(axes: Axes3D, run: Shown, low: Floats, high: Floats) -> None:
    """Draw what a run meets as panes across a box (mm)."""
    for met in limits_met(run):
        across, up = (i for i in range(3) if i != met.axis)
        corners = np.full((4, 3), met.level)
        corners[:, across] = low[across], high[across], high[across], low[across]
        corners[:, up] = low[up], low[up], high[up], high[up]
        pane = Poly3DCollection([corners], facecolor=met.colour, edgecolor=met.colour, linewidth=0.6, alpha=0.22)
        pane.set(label=str(met.limit), zorder=0)
        axes.add_collection3d(pane)
