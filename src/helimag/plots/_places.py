"""Figure of orbits of one scenario: where they are around the magnet, and their multipliers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from helimag.orbits import Orbit
from helimag.plots._portraits import draw_magnet, explain, magnet_key, three_panels
from helimag.plots._style import BLUE, GREY, VERMILLION, Size, head, styled
from helimag.scenario import drive_inputs

PLANES = ((0, 2), (0, 1))
LOOKS: dict[bool, Any] = {
    True: {"color": BLUE, "markerfacecolor": BLUE},
    False: {"color": VERMILLION, "markerfacecolor": "white"},
}
NAMES = {True: "stable orbit", False: "unstable orbit"}
MARGIN = 0.15  # around orbits and magnet, of their spread


def draw_orbits(orbits: Sequence[Orbit], *, size: Size = "print") -> Figure:
    """Draw orbits of one scenario: side view and plan with the magnet, and Floquet multipliers in the complex plane.

    Parameters
    ----------
    orbits
        That were found; at least one.
    size
        "small", "print" or "slide".

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide; mm, moving frame. Stable ones full, others open; a multiplier within the
        unit circle decays.
    """
    scenario = orbits[0].scenario
    with styled(size) as sheet:
        figure, axes = three_panels(sheet)
        for axis, (i, j) in zip(axes, PLANES, strict=False):
            _draw_places(axis, orbits, i, j)
        _draw_multipliers(axes[2], orbits)
        kinds = [stable for stable in (True, False) if any(orbit.stable is stable for orbit in orbits)]
        handles = [
            Line2D([], [], marker="o", linestyle="none", markersize=4.5, label=NAMES[stable], **LOOKS[stable])
            for stable in kinds
        ]
        explain(figure, handles + magnet_key(axes[:2]), most=4)
        head(figure, f"{scenario.title}\n{drive_inputs(scenario)}")
    return figure


def _draw_places(axis: Axes, orbits: Sequence[Orbit], i: int, j: int) -> None:
    draw_magnet(axis, orbits[0].scenario, float(orbits[0].position[3 - i - j]), i, j)
    for orbit in orbits:
        axis.plot(
            1e3 * orbit.position[i], 1e3 * orbit.position[j], "o", markersize=4.5, zorder=5, **LOOKS[orbit.stable]
        )
    points = np.concatenate([np.stack(line.get_data(), axis=1).astype(float) for line in axis.lines])
    low, high = points.min(axis=0), points.max(axis=0)
    beside = MARGIN * float((high - low).max())
    axis.set(xlim=(low[0] - beside, high[0] + beside), ylim=(low[1] - beside, high[1] + beside))
    axis.set_aspect("equal")
    axis.set(xlabel=f"{'xyz'[i]} (mm)", ylabel=f"{'xyz'[j]} (mm)")
    axis.set_title("from the side" if j == 2 else "from above")


def _draw_multipliers(axis: Axes, orbits: Sequence[Orbit]) -> None:
    axis.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=GREY, linewidth=0.8))
    axis.axhline(0.0, color=GREY, linewidth=0.4)
    axis.axvline(0.0, color=GREY, linewidth=0.4)
    for orbit in orbits:
        values = orbit.multipliers
        axis.plot(values.real, values.imag, "o", markersize=3.5, zorder=5, **LOOKS[orbit.stable])
    reach = 1.12 * max(1.0, *(float(np.abs(orbit.multipliers).max()) for orbit in orbits))
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="real part", ylabel="imaginary part")
    axis.set_aspect("equal")
    axis.set_title("multipliers of a turn,\nunit circle")
