"""Whether the model's assumptions hold for a scenario: small checks with numbers, grouped over a batch."""

from helimag.checks.check import Check
from helimag.checks.findings import Caution, cautions, examine
from helimag.checks.flow import (
    boundary_drag,
    enclosing_body,
    pitch_angle,
    reynolds,
    slenderness,
    wall_gap,
    wall_resolved,
)
from helimag.checks.magnets import (
    dipole_error,
    field_axis,
    least_field,
    magnet_distance,
    rotation_at_start,
    step_out,
    step_out_frequency,
    weakest_and_strongest,
)

__all__ = [
    "Caution",
    "Check",
    "boundary_drag",
    "cautions",
    "dipole_error",
    "enclosing_body",
    "examine",
    "field_axis",
    "least_field",
    "magnet_distance",
    "pitch_angle",
    "reynolds",
    "rotation_at_start",
    "slenderness",
    "step_out",
    "step_out_frequency",
    "wall_gap",
    "wall_resolved",
    "weakest_and_strongest",
]
