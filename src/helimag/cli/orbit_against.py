"""The command orbit against: verdicts of a sweep beside the orbits of its inputs."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    stored,
    write_outputs,
)
from helimag.cli._shared import print_json, progress_bar

if TYPE_CHECKING:
    from helimag.orbits import Along, BoundaryCurve, OrbitCase, OrbitComparison
    from helimag.sweeps import Nodes, ResolvedAxis


def against(store: Path, *, output: Outputs = None, size: FigureSize = None, common: Common = PLAIN) -> None:
    """Set the verdicts of a sweep beside the orbits of its inputs, and explain each that does not agree.

    Parameters
    ----------
    store
        A sweep's store (.zarr) whose points lie on a grid.
    output
        Write a figure (.png, .svg, .pdf) or the data (.nc) to this file. May be repeated.
    """
    check_outputs(output, FIGURE, DATA, size=size)
    from helimag import orbits
    from helimag.sweeps import load_sweep, nodes_of

    dataset = load_sweep(store)
    nodes = nodes_of(dataset)
    with progress_bar(f"orbits of {store.name}") as progress:
        result = orbits.compare_with_orbits(nodes.scenario_at, nodes.verdicts, progress=progress)
    base = nodes.base
    if output:
        curves = _boundary(nodes, result)
        write_outputs(
            output,
            {
                FIGURE: Drawing(lambda plots, size: plots.draw_sweep(dataset, curves=curves, size=size)),
                DATA: stored(lambda: orbits.comparison_dataset(result, base, _inputs(nodes), nodes.dimensions)),
            },
            size=size,
        )
    if common.json:
        print_json(_report(nodes, result) | files_report(output))
        return
    print(f"{store.name}: {result.text}")
    for case in result.cases:
        values = nodes.values_at(case.node)
        place = ", ".join(_shown(axis, values[axis.field]) for axis in nodes.axes)
        edge = "" if result.away[case.node] else " (beside the boundary)"
        print(f"  {place}{edge}: {case.text}")
    print_files(output)


def _boundary(nodes: "Nodes", result: "OrbitComparison") -> "list[BoundaryCurve]":
    """Where stability ends, of a sweep over two numbers; none of any other."""
    from helimag.orbits import boundary_of, map_of

    known = map_of(result, nodes.base, [(axis.field, axis.values) for axis in nodes.axes])
    if known is None:
        return []
    with progress_bar("following the boundary of stability") as progress:
        return boundary_of(known, progress=progress)


def _inputs(nodes: "Nodes") -> "dict[str, Along]":
    from helimag.orbits import Along

    units = ["1" if axis.kind is None else axis.kind.si for axis in nodes.axes]
    return {axis.field: Along(axis.dimension, unit, axis.values) for axis, unit in zip(nodes.axes, units, strict=True)}


def _shown(axis: "ResolvedAxis", value: float | str) -> str:
    from helimag.quantities import show

    if isinstance(value, str):
        return value
    return f"{axis.name} {value:g}" if axis.kind is None else show(value, axis.kind)


def _report(nodes: "Nodes", result: "OrbitComparison") -> dict[str, Any]:
    def case(one: "OrbitCase") -> dict[str, Any]:
        return {
            "inputs": nodes.values_at(one.node),
            "verdict": str(one.verdict),
            "stable": one.stable,
            "later_verdict": None if one.later is None else str(one.later),
            "later_end_s": one.later_end,
            "why": str(one.why),
            "away_from_boundary": bool(result.away[one.node]),
        }

    return {
        "nodes": result.verdicts.size,
        "away_from_boundary": int(result.away.sum()),
        "decided": int(result.decided.sum()),
        "agreement": _number(result.share()),
        "agreement_beside_orbit": _number(result.share(beside=True)),
        "cases": [case(one) for one in result.cases],
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value
