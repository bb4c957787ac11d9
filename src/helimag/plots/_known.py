"""Figures of what files about orbits hold."""

from typing import TYPE_CHECKING

from helimag.orbits import Basin, Branch, KnownFlow, KnownMap
from helimag.plots._orbits import draw_branches, draw_stability
from helimag.plots._places import draw_orbits
from helimag.plots._portraits import draw_basin, draw_flow
from helimag.plots._style import Size

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from helimag.orbits import Known


def draw_known(known: "Known", *, size: Size = "print") -> "Figure":
    """Draw what :func:`helimag.orbits.known_in` found in a file: the figure that its command makes.

    Returns
    -------
    matplotlib.figure.Figure
        As :func:`draw_orbits`, :func:`draw_branches`, :func:`draw_stability`, :func:`draw_flow` or :func:`draw_basin`
        give it.
    """
    if isinstance(known, KnownMap):
        return draw_stability(known.map, known.boundary, size=size)
    if isinstance(known, KnownFlow):
        return draw_flow(known.flow, known.orbit, known.captured, fixed_points=known.fixed_points, size=size)
    if isinstance(known, Basin):
        return draw_basin(known, size=size)
    if isinstance(known[0], Branch):
        return draw_branches(known, size=size)
    return draw_orbits(known, size=size)
