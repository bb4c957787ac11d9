"""Orbits beside runs: the outlook of a run, and verdicts of sweeps against orbits."""

from helimag.orbits.beside_runs.against import OrbitCase, OrbitComparison, compare_with_orbits, map_of
from helimag.orbits.beside_runs.growth import ObservedGrowth, observed_growth
from helimag.orbits.beside_runs.outlook import Outlook, explain

__all__ = [
    "ObservedGrowth",
    "OrbitCase",
    "OrbitComparison",
    "Outlook",
    "compare_with_orbits",
    "explain",
    "map_of",
    "observed_growth",
]
