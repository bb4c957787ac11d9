"""A finished sweep's grid, node by node: the scenario that was run there, and its verdict."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import Verdict
from helimag.scenario import Scenario, parse
from helimag.sweeps.plan import parse_plan
from helimag.sweeps.resolved import ResolvedAxis, resolve

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Nodes:
    """Nodes of a sweep over a grid.

    Attributes
    ----------
    base
        What the runs have in common; of a sweep with an ensemble, with its likeliest device.
    axes
        Each swept field with its values, SI or text, and the dimension that it runs along: zipped ones share one.
    dimensions
        Of the grid, in order.
    verdicts
        Of the grid's shape, text; empty where a run failed or is missing.
    scenario_at
        The scenario of an index; None where the values make none.
    values_at
        The swept fields of an index and their values, SI or text.
    """

    base: Scenario
    axes: tuple[ResolvedAxis, ...]
    dimensions: tuple[str, ...]
    verdicts: NDArray[np.str_]
    scenario_at: Callable[[tuple[int, ...]], Scenario | None]
    values_at: Callable[[tuple[int, ...]], dict[str, float | str]]


def nodes_of(dataset: "xarray.Dataset") -> Nodes:
    """Nodes of a sweep, as opened by :func:`helimag.load_sweep`.

    Returns
    -------
    Nodes
        Scenarios and verdicts by index.

    Raises
    ------
    InputError
        Where the sweep's points are not on a grid.
    """
    plan = parse_plan(dataset.attrs["plan"])
    if plan.sample is not None or plan.boundary is not None:
        raise InputError("the sweep's points must lie on a grid; this plan samples them or chooses them on the way")
    base = parse(dataset.attrs["scenario"])
    resolved = resolve(plan.model_copy(update={"base": base, "changes": {}, "duration": None, "ensemble": None}))
    flags = dataset["verdict"].transpose(*resolved.shape).values

    def values_at(index: tuple[int, ...]) -> dict[str, float | str]:
        at = dict(zip(resolved.shape, index, strict=True))
        return {axis.field: axis.values[at[axis.dimension]] for axis in resolved.axes}

    def scenario_at(index: tuple[int, ...]) -> Scenario | None:
        try:
            return resolved.scenario(values_at(index))
        except InputError:
            return None

    names = {verdict.flag: str(verdict) if verdict.judged else "" for verdict in Verdict}
    verdicts = np.vectorize(names.__getitem__, otypes=[str])(flags)
    return Nodes(base, resolved.axes, tuple(resolved.shape), verdicts, scenario_at, values_at)
