"""Orbits: what a run repeats turn by turn in the frame of the drive, whether it attracts, and where that ends."""

from helimag.orbits.beside_runs.against import Case, Comparison, compare_with_orbits
from helimag.orbits.beside_runs.growth import ObservedGrowth, observed_growth
from helimag.orbits.beside_runs.outlook import Outlook, explain
from helimag.orbits.curves.boundary import BoundaryCurve, boundary_of
from helimag.orbits.curves.branch import Branch, Change, Event, Point
from helimag.orbits.curves.continuation import follow
from helimag.orbits.curves.crossings import CODIMENSION_TWO
from helimag.orbits.curves.intervals import Interval, stable_interval, stable_segments
from helimag.orbits.curves.mapping import StabilityMap, stability_map
from helimag.orbits.curves.survey import survey
from helimag.orbits.datasets import (
    Along,
    basin_dataset,
    branches_dataset,
    comparison_dataset,
    flow_dataset,
    map_dataset,
    save_dataset,
)
from helimag.orbits.slow_flow.attraction import Agreement, Basin, agreement, basin
from helimag.orbits.slow_flow.averaging import SlowFlow, averaged_paths, averaged_rates, averaging_error, slow_flow
from helimag.orbits.slow_flow.fixed_points import Counterpart, FixedPoint, counterparts, fixed_points
from helimag.orbits.strobe.find import find_orbit, find_orbits, list_orbits
from helimag.orbits.strobe.orbit import Orbit
from helimag.outcomes import Future, OrbitStatus, Why

__all__ = [
    "CODIMENSION_TWO",
    "Agreement",
    "Along",
    "Basin",
    "BoundaryCurve",
    "Branch",
    "Case",
    "Change",
    "Comparison",
    "Counterpart",
    "Event",
    "FixedPoint",
    "Future",
    "Interval",
    "ObservedGrowth",
    "Orbit",
    "OrbitStatus",
    "Outlook",
    "Point",
    "SlowFlow",
    "StabilityMap",
    "Why",
    "agreement",
    "averaged_paths",
    "averaged_rates",
    "averaging_error",
    "basin",
    "basin_dataset",
    "boundary_of",
    "branches_dataset",
    "compare_with_orbits",
    "comparison_dataset",
    "counterparts",
    "explain",
    "find_orbit",
    "find_orbits",
    "fixed_points",
    "flow_dataset",
    "follow",
    "list_orbits",
    "map_dataset",
    "observed_growth",
    "save_dataset",
    "slow_flow",
    "stability_map",
    "stable_interval",
    "stable_segments",
    "survey",
]
