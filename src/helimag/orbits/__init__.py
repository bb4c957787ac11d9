"""Orbits: what a run repeats turn by turn in the frame of the drive, whether it attracts, and where that ends."""

from helimag.orbits._crossings import CODIMENSION_TWO
from helimag.orbits._inputs import Input
from helimag.orbits.against import Case, Comparison, Why, compare_with_orbits
from helimag.orbits.attraction import Agreement, Basin, agreement, basin
from helimag.orbits.averaging import SlowFlow, averaged_paths, averaged_rates, averaging_error, slow_flow
from helimag.orbits.boundary import BoundaryCurve, boundary_of
from helimag.orbits.branch import Branch, Change, Event, Point
from helimag.orbits.continuation import follow
from helimag.orbits.datasets import (
    Along,
    basin_dataset,
    branches_dataset,
    comparison_dataset,
    flow_dataset,
    map_dataset,
    save_dataset,
)
from helimag.orbits.find import find_orbit, find_orbits, list_orbits
from helimag.orbits.fixed_points import Counterpart, FixedPoint, counterparts, fixed_points
from helimag.orbits.growth import ObservedGrowth, observed_growth
from helimag.orbits.intervals import Interval, stable_interval, stable_segments
from helimag.orbits.mapping import StabilityMap, stability_map
from helimag.orbits.orbit import Orbit, OrbitStatus
from helimag.orbits.outlook import Future, Outlook, explain
from helimag.orbits.robust_inputs import Design, design
from helimag.orbits.survey import survey

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
    "Design",
    "Event",
    "FixedPoint",
    "Future",
    "Input",
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
    "design",
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
