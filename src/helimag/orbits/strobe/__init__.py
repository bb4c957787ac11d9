"""The stroboscopic map of one turn of the magnet, its fixed points and their stability.

The moving frame yaws and translates with the drive. In it the equations of motion repeat after one turn of the magnet,
so an orbit is a fixed point of the map over one turn.
"""

from helimag.orbits.strobe import chart
from helimag.orbits.strobe.find import classify, find_orbit, find_orbits, list_orbits, orbits_of
from helimag.orbits.strobe.floquet import multipliers_of, rates_of
from helimag.orbits.strobe.newton import Solved, solve
from helimag.orbits.strobe.orbit import Orbit, describe_rates
from helimag.orbits.strobe.problem import Floats, Ints, Measured, Problem, require_periodic
from helimag.orbits.strobe.starts import (
    Strobed,
    attitudes,
    default_box,
    open_water,
    sense_of,
    settle,
    strobed,
    to_lab,
    to_moving,
)
from helimag.orbits.strobe.watching import Watch

__all__ = [
    "Floats",
    "Ints",
    "Measured",
    "Orbit",
    "Problem",
    "Solved",
    "Strobed",
    "Watch",
    "attitudes",
    "chart",
    "classify",
    "default_box",
    "describe_rates",
    "find_orbit",
    "find_orbits",
    "list_orbits",
    "multipliers_of",
    "open_water",
    "orbits_of",
    "rates_of",
    "require_periodic",
    "sense_of",
    "settle",
    "solve",
    "strobed",
    "to_lab",
    "to_moving",
]
