"""The Stokes resistance of a rigid body from its surface: wire and head, or any closed mesh."""

from helimag.hydrodynamics.boundary.cache import solution
from helimag.hydrodynamics.boundary.changes import mobility_changes
from helimag.hydrodynamics.boundary.lookup import look_up
from helimag.hydrodynamics.boundary.refine import Solution
from helimag.hydrodynamics.boundary.solve import Plane
from helimag.hydrodynamics.boundary.tables import LEAST_GAP, WallTable, wall_table

__all__ = ["LEAST_GAP", "Plane", "Solution", "WallTable", "look_up", "mobility_changes", "solution", "wall_table"]
