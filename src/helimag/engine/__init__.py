"""The engine: scenarios in, runs out. The only time loop, on CPU threads or a GPU.

A run goes through these modules in order: ``packing`` (scenarios to the kernels' structures), ``system`` (which
formulas), ``methods`` with ``control`` (one step and its size), ``events``, ``synchrony`` and ``samples`` (what is
watched), ``loop`` (the kernel), ``batch`` and ``running`` (launches on threads), ``history`` and ``simulation``
(results).
"""

from helimag.engine.accuracy import SURE, Accuracy, accuracy_of, refined
from helimag.engine.batch import TOLERANCE
from helimag.engine.control import Control
from helimag.engine.dense import KEPT
from helimag.engine.events import FALL_LIMIT
from helimag.engine.history import History
from helimag.engine.kernels import ready
from helimag.engine.medium import OPEN_WATER, Medium
from helimag.engine.methods import DEFAULT, DOP853, METHODS, MULTIREVOLUTION, Method, method_named
from helimag.engine.moving import shifted, to_lab, to_moving
from helimag.engine.packing import (
    initial_gap,
    pack_bodies,
    pack_drives,
    pack_magnets,
)
from helimag.engine.patience import announced
from helimag.engine.running import Underway, advance, advancing
from helimag.engine.simulation import simulate, simulate_many, trajectory_of
from helimag.engine.slow_times import slow_times
from helimag.engine.start import angles_of_start, carrying_velocity, forward, start_attitude, start_state
from helimag.engine.synchrony import lag_vector
from helimag.engine.system import (
    MAGNET_MODELS,
    System,
    build_balance,
    build_load,
    build_rates,
    build_rates_at,
    frame_moves,
    system_of,
)

__all__ = [
    "DEFAULT",
    "DOP853",
    "FALL_LIMIT",
    "KEPT",
    "MAGNET_MODELS",
    "METHODS",
    "MULTIREVOLUTION",
    "OPEN_WATER",
    "SURE",
    "TOLERANCE",
    "Accuracy",
    "Control",
    "History",
    "Medium",
    "Method",
    "System",
    "Underway",
    "accuracy_of",
    "advance",
    "advancing",
    "angles_of_start",
    "announced",
    "build_balance",
    "build_load",
    "build_rates",
    "build_rates_at",
    "carrying_velocity",
    "forward",
    "frame_moves",
    "initial_gap",
    "lag_vector",
    "method_named",
    "pack_bodies",
    "pack_drives",
    "pack_magnets",
    "ready",
    "refined",
    "shifted",
    "simulate",
    "simulate_many",
    "slow_times",
    "start_attitude",
    "start_state",
    "system_of",
    "to_lab",
    "to_moving",
    "trajectory_of",
]
