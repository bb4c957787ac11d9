"""Curves where stability ends, over whatever is drawn of the same two inputs."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, Stroke

from helimag.orbits import CODIMENSION_TWO, BoundaryCurve, Change
from helimag.scenario import Input, Scenario, parse, varied
from helimag.sweeps import axis_names, parse_plan

if TYPE_CHECKING:
    import xarray

DASHES = {Change.FOLD: "-", Change.NEIMARK_SACKER: (0, (3.5, 1.2)), Change.PERIOD_DOUBLING: (0, (1.0, 1.0))}
WIDTH, CASING = 1.3, 2.7  # points; a white casing sets the lines off from any colour
NAMED = {"Bogdanov-Takens": "D", "1:2 resonance": "^"}  # marks of codimension-two points; others are circles


def draw_curves(
    axes: Axes, curves: Sequence[BoundaryCurve], *, scales: tuple[float, float], swapped: bool = False
) -> list[Line2D]:
    """Draw curves as lines by kind, and mark the codimension-two points at which they end.

    Parameters
    ----------
    scales
        What one SI unit of each of the curves' inputs is on the axes.
    swapped
        Draw the second input along x.

    Returns
    -------
    list of Line2D
        One of each look, labelled, for a legend.
    """
    looks: dict[str, Line2D] = {}
    for curve in curves:
        x, y = curve.first * scales[0], curve.second * scales[1]
        x, y = (y, x) if swapped else (x, y)
        marker = "" if len(x) > 1 else "x"
        (line,) = axes.plot(x, y, color="black", linewidth=WIDTH, linestyle=DASHES.get(curve.kind, "-"), marker=marker)
        line.set_path_effects([Stroke(linewidth=CASING, foreground="white"), Normal()])
        line.set(label=str(curve.kind), zorder=4, markersize=3)
        looks.setdefault(str(curve.kind), line)
        for at, end in ((0, curve.ends[0]), (-1, curve.ends[1])):
            if end in CODIMENSION_TWO:
                (mark,) = axes.plot(x[at], y[at], NAMED.get(end, "o"), color="black", markersize=4.5, zorder=5)
                mark.set(markeredgecolor="white", markeredgewidth=0.6, label=end)
                looks.setdefault(end, mark)
    return list(looks.values())


def belongs(curve: BoundaryCurve, part: "xarray.Dataset") -> bool:
    """Whether a curve is over the two inputs of a panel of a sweep, and all else that decides an orbit is the same.

    How long a run lasts and where walls end it decides no orbit.
    """
    across = [name for name in axis_names(part) if part[name].ndim]
    if {part[name].attrs["long_name"] for name in across} != set(curve.paths) or len(across) != 2:
        return False
    panel = _scenario_of(part)
    panel = varied(panel, {path: Input(path).value(curve.scenario) for path in curve.paths})
    return _same(_decisive(panel), _decisive(curve.scenario))


def _scenario_of(part: "xarray.Dataset") -> Scenario:
    """The scenario of a panel: the sweep's, with the values of the axes that are one number there."""
    values: dict[str, float | str] = {}
    swept = {line.field for line in parse_plan(part.attrs["plan"]).axis}
    for coordinate in part.coords.values():
        field = coordinate.attrs.get("long_name")
        if coordinate.ndim or field not in swept:
            continue
        if "flag_meanings" in coordinate.attrs:
            values[field] = coordinate.attrs["flag_meanings"].split()[int(coordinate)].replace("_", " ")
        else:
            values[field] = float(coordinate)
    return varied(parse(part.attrs["scenario"]), values)


def _decisive(scenario: Scenario) -> dict[str, Any]:
    return scenario.model_dump(mode="python", exclude={"name", "provenance", "run", "workspace"})


def _same(a: Any, b: Any) -> bool:
    """Equal, numbers but for rounding."""
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(_same(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, (int, float)):
        return math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-15)
    return bool(a == b)
