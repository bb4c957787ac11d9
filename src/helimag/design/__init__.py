"""Design: inputs for a wanted motion that forgive errors."""

from helimag.design.result import Design
from helimag.design.robust_inputs import design

__all__ = ["Design", "design"]
