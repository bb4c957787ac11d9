"""From a scenario to a programme that an arm can run, checked before it moves; and back from what an arm really did."""

from helimag.robot.arm.cell import Arm, Cell, load_arm, load_cell
from helimag.robot.arm.checks import Offence
from helimag.robot.arm.kinematics import Solutions, forward, inverse_kinematics, within_limits
from helimag.robot.arm.path import MagnetPath, magnet_path
from helimag.robot.arm.planning import Plan, plan
from helimag.robot.krl.comparison import Deviation, deviation
from helimag.robot.krl.interpreter import Playback, play
from helimag.robot.krl.writer import write_krl
from helimag.robot.programme import feasible_or_refused, write_programme
from helimag.robot.report import report

__all__ = [
    "Arm",
    "Cell",
    "Deviation",
    "MagnetPath",
    "Offence",
    "Plan",
    "Playback",
    "Solutions",
    "deviation",
    "feasible_or_refused",
    "forward",
    "inverse_kinematics",
    "load_arm",
    "load_cell",
    "magnet_path",
    "plan",
    "play",
    "report",
    "within_limits",
    "write_krl",
    "write_programme",
]
