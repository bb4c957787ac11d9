"""Figures and tables of the paper, computed and set beside what was published."""

from helimag.reproduce._fig3 import Reproduction, fig3

__all__ = ["Reproduction", "fig3"]
