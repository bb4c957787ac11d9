"""Figures and films of runs, with matplotlib and PyAV (the extra ``plots``)."""

import logging

from helimag.errors import MissingExtra

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # already its import remarks on folders that it cannot make
try:
    import matplotlib as _matplotlib
except ImportError as _error:
    raise MissingExtra.of("drawing", str(_error.name), "plots") from None
_matplotlib.set_loglevel("ERROR")  # its remarks on fonts and caches are no part of a command's output

from helimag.plots._calibration import draw_fit  # noqa: E402
from helimag.plots._film import animate, check_filming  # noqa: E402
from helimag.plots._known import draw_known  # noqa: E402
from helimag.plots._orbits import draw_branches, draw_stability  # noqa: E402
from helimag.plots._pages import interactive_sweep, save_html  # noqa: E402
from helimag.plots._places import draw_orbits  # noqa: E402
from helimag.plots._portraits import draw_basin, draw_flow  # noqa: E402
from helimag.plots._run import draw_run  # noqa: E402
from helimag.plots._save import save  # noqa: E402
from helimag.plots._side_by_side import Case, draw_side_by_side  # noqa: E402
from helimag.plots._straight import StraightRun, draw_straight_runs  # noqa: E402
from helimag.plots._style import Size  # noqa: E402
from helimag.plots.compare import draw_comparison  # noqa: E402
from helimag.plots.robot import draw_cell, draw_joints, draw_timed, save_plan  # noqa: E402
from helimag.plots.sweeps import Passes, draw_passes, draw_sweep  # noqa: E402

__all__ = [
    "Case",
    "Passes",
    "Size",
    "StraightRun",
    "animate",
    "check_filming",
    "draw_basin",
    "draw_branches",
    "draw_cell",
    "draw_comparison",
    "draw_fit",
    "draw_flow",
    "draw_joints",
    "draw_known",
    "draw_orbits",
    "draw_passes",
    "draw_run",
    "draw_side_by_side",
    "draw_stability",
    "draw_straight_runs",
    "draw_sweep",
    "draw_timed",
    "interactive_sweep",
    "save",
    "save_html",
    "save_plan",
]
