"""The arm and its cell: kinematics, what stops it on its way, and the plan of joint angles along a magnet's path."""

from helimag.robot.arm.cell import Arm, Cell, Load, Motor, Obstacle, load_arm, load_cell
from helimag.robot.arm.checks import Offence, joint_rates
from helimag.robot.arm.collision import Capsules, capsules, clearances
from helimag.robot.arm.kinematics import Solutions, forward, inverse_kinematics, within_limits
from helimag.robot.arm.path import MagnetPath, magnet_path
from helimag.robot.arm.planning import ArmPlan, Unwinding, plan

__all__ = [
    "Arm",
    "ArmPlan",
    "Capsules",
    "Cell",
    "Load",
    "MagnetPath",
    "Motor",
    "Obstacle",
    "Offence",
    "Solutions",
    "Unwinding",
    "capsules",
    "clearances",
    "forward",
    "inverse_kinematics",
    "joint_rates",
    "load_arm",
    "load_cell",
    "magnet_path",
    "plan",
    "within_limits",
]
