"""Sweeps: many runs by plan, a store that survives interruption, threads or a cluster, a verdict's boundary."""

from helimag.sweeps.boundary import BoundaryLine, boundary_line
from helimag.sweeps.export import axis_names, counts, export, load_sweep, swept_in
from helimag.sweeps.nodes import Nodes, nodes_of
from helimag.sweeps.plan import (
    Axis,
    Boundary,
    EnsembleTable,
    Plan,
    Sampling,
    load_plan,
    parse_plan,
    with_ensemble,
)
from helimag.sweeps.resolved import ResolvedAxis, ResolvedPlan, resolve
from helimag.sweeps.run import SweepProgress, sweep
from helimag.sweeps.trial import Estimate, estimate

__all__ = [
    "Axis",
    "Boundary",
    "BoundaryLine",
    "EnsembleTable",
    "Estimate",
    "Nodes",
    "Plan",
    "ResolvedAxis",
    "ResolvedPlan",
    "Sampling",
    "SweepProgress",
    "axis_names",
    "boundary_line",
    "counts",
    "estimate",
    "export",
    "load_plan",
    "load_sweep",
    "nodes_of",
    "parse_plan",
    "resolve",
    "sweep",
    "swept_in",
    "with_ensemble",
]
