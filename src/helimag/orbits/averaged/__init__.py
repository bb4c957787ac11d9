"""The slow flow: the motion averaged over a turn, its fixed points, and basins of attraction."""

from helimag.orbits.averaged.agreement import Agreement, agreement
from helimag.orbits.averaged.attraction import Basin, basin, basin_by_flow, comes_to
from helimag.orbits.averaged.averaging import SlowFlow, slow_flow
from helimag.orbits.averaged.fixed_points import Counterpart, FixedPoint, averaged_rates, counterparts, fixed_points
from helimag.orbits.averaged.paths import AveragingError, averaged_paths, averaging_error, averaging_errors
from helimag.orbits.averaged.places import box_around

__all__ = [
    "Agreement",
    "AveragingError",
    "Basin",
    "Counterpart",
    "FixedPoint",
    "SlowFlow",
    "agreement",
    "averaged_paths",
    "averaged_rates",
    "averaging_error",
    "averaging_errors",
    "basin",
    "basin_by_flow",
    "box_around",
    "comes_to",
    "counterparts",
    "fixed_points",
    "slow_flow",
]
