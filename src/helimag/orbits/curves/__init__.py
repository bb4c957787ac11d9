"""Orbits followed through inputs: branches, stable intervals, maps and boundaries of stability."""

from helimag.orbits.curves.boundary import BoundaryCurve, boundary_of
from helimag.orbits.curves.branch import Branch, Change, Event, Point
from helimag.orbits.curves.continuation import follow
from helimag.orbits.curves.crossings import CODIMENSION_TWO
from helimag.orbits.curves.intervals import StableInterval, stable_interval, stable_segments
from helimag.orbits.curves.mapping import StabilityMap, seeds_within, stability_map
from helimag.orbits.curves.spreading import Node, OrbitGrid
from helimag.orbits.curves.survey import all_branches, survey

__all__ = [
    "CODIMENSION_TWO",
    "BoundaryCurve",
    "Branch",
    "Change",
    "Event",
    "Node",
    "OrbitGrid",
    "Point",
    "StabilityMap",
    "StableInterval",
    "all_branches",
    "boundary_of",
    "follow",
    "seeds_within",
    "stability_map",
    "stable_interval",
    "stable_segments",
    "survey",
]
