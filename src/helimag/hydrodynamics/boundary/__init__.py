"""The Stokes resistance of a rigid body from its surface: wire and head, or any closed mesh."""

from helimag.hydrodynamics.boundary.cache import solution
from helimag.hydrodynamics.boundary.changes import mobility_changes
from helimag.hydrodynamics.boundary.refine import Solution
from helimag.hydrodynamics.boundary.solve import Plane
from helimag.hydrodynamics.boundary.splines import spline_coefficients
from helimag.hydrodynamics.boundary.tables import WallTable, wall_table

__all__ = ["Plane", "Solution", "WallTable", "mobility_changes", "solution", "spline_coefficients", "wall_table"]
