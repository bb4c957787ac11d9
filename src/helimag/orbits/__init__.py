"""Orbits: what a run repeats turn by turn in the frame of the drive, whether it attracts, and where that ends."""

from helimag.orbits._crossings import CODIMENSION_TWO
from helimag.orbits._inputs import Input
from helimag.orbits.attraction import Basin, basin
from helimag.orbits.averaging import SlowFlow, averaged_paths, averaged_rates, averaging_error, slow_flow
from helimag.orbits.boundary import BoundaryCurve, boundary_of
from helimag.orbits.branch import Branch, Change, Event, Point
from helimag.orbits.continuation import follow
from helimag.orbits.find import find_orbit, find_orbits, list_orbits
from helimag.orbits.growth import ObservedGrowth, observed_growth
from helimag.orbits.intervals import Interval, stable_interval, stable_segments
from helimag.orbits.mapping import StabilityMap, stability_map
from helimag.orbits.orbit import Orbit, OrbitStatus
from helimag.orbits.outlook import Future, Outlook, explain
from helimag.orbits.robust_inputs import Design, design

__all__ = [
    "CODIMENSION_TWO",
    "Basin",
    "BoundaryCurve",
    "Branch",
    "Change",
    "Design",
    "Event",
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
    "averaged_paths",
    "averaged_rates",
    "averaging_error",
    "basin",
    "boundary_of",
    "design",
    "explain",
    "find_orbit",
    "find_orbits",
    "follow",
    "list_orbits",
    "observed_growth",
    "slow_flow",
    "stability_map",
    "stable_interval",
    "stable_segments",
]
