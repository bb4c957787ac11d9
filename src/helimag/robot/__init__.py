"""From a scenario to a programme that an arm can run, checked before it moves; and back from what an arm really did."""

from helimag.robot.arm import (
    Arm,
    ArmPlan,
    Capsules,
    Cell,
    MagnetPath,
    Offence,
    Solutions,
    capsules,
    forward,
    inverse_kinematics,
    joint_rates,
    load_arm,
    load_cell,
    magnet_path,
    plan,
    within_limits,
)
from helimag.robot.jitter import Jitter, load_jitter, measured_jitter, study
from helimag.robot.krl import Deviation, Playback, checked_name, deviation, krl_texts, play, write_krl
from helimag.robot.logs import Log, log_of_playback, read_log, replayed
from helimag.robot.programme import feasible_or_refused, programme_texts, write_programme
from helimag.robot.rehearsal import as_programmed, rehearse
from helimag.robot.report import report, with_unwinding
from helimag.robot.timed import TimedPath, read_timed, timed_table

__all__ = [
    "Arm",
    "ArmPlan",
    "Capsules",
    "Cell",
    "Deviation",
    "Jitter",
    "Log",
    "MagnetPath",
    "Offence",
    "Playback",
    "Solutions",
    "TimedPath",
    "as_programmed",
    "capsules",
    "checked_name",
    "deviation",
    "feasible_or_refused",
    "forward",
    "inverse_kinematics",
    "joint_rates",
    "krl_texts",
    "load_arm",
    "load_cell",
    "load_jitter",
    "log_of_playback",
    "magnet_path",
    "measured_jitter",
    "plan",
    "play",
    "programme_texts",
    "read_log",
    "read_timed",
    "rehearse",
    "replayed",
    "report",
    "study",
    "timed_table",
    "with_unwinding",
    "within_limits",
    "write_krl",
    "write_programme",
]
