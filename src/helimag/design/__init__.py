"""Design: inputs for a wanted motion that forgive errors."""

from helimag.design.robust_inputs import Design, design

__all__ = ["Design", "design"]
