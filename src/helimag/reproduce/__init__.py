"""Figures and tables of the paper, computed and set beside what was published."""

from helimag.reproduce._fig3 import Reproduction, fig3
from helimag.reproduce._fig4 import Fig4, fig4
from helimag.reproduce._straight import fig5, table1

__all__ = ["Fig4", "Reproduction", "fig3", "fig4", "fig5", "table1"]
