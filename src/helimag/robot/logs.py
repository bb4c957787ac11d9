"""Logs of measured poses as CSV, and any timed tool poses, as the magnet path of a scenario."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.engine import angles_of_start
from helimag.errors import InputError
from helimag.geometry import turn
from helimag.robot.arm.cell import Cell
from helimag.robot.arm.frames import frames, inverse, rotation
from helimag.robot.arm.path import magnet_path, motor_angle
from helimag.robot.krl.comparison import on_path
from helimag.robot.krl.interpreter import Playback
from helimag.robot.timed import Table
from helimag.runs import Columns, read_table
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

_KINDS = {"time": q.TIME, "x": q.LENGTH, "y": q.LENGTH, "z": q.LENGTH, "a": q.ANGLE, "b": q.ANGLE, "c": q.ANGLE}
_CHOICES = {"frame": ("lab", "base"), "pose": ("tool", "flange"), "motor axis": ("along", "against")}
CLOSEST = 1e-3  # s, between samples of a programme: over less, a spline would make speed of rounding
COARSE = math.radians(150.0)  # between rows: nearer to half a turn, forwards and backwards look the same
FARTHEST = 100.0  # m; no arm is so far away, and a unit or a digit is wrong
ROUND = 2.0 * math.pi * (1.0 + 1e-6)  # rad; KUKA's angles are within half a turn either way
_DEFAULTS = {"motor axis": "along"}


@dataclass(frozen=True)
class Log:
    """Timed tool poses in the lab frame: (n,) s from zero, (n, 4, 4) m.

    ``motor`` is the moment's angle (n,) in rad about the tool's x axis from its y axis, or None if not recorded;
    ``reversed_axis`` says that the x axis points against the rotation axis; ``within_turn`` that the motor was recorded
    within a turn, so that whole turns between two rows are not known.
    """

    time: Floats
    tool: Floats
    motor: Floats | None
    reversed_axis: bool
    within_turn: bool = False


def read_log(path: str | Path, cell: Cell) -> Log:
    """Read a log of measured poses.

    Comment lines state the frame (``# frame: lab`` or ``base``), what was measured (``# pose: tool`` or ``flange``)
    and, where it differs, ``# motor axis: against``. The columns are ``time, x, y, z, a, b, c`` and, if there is one,
    ``motor``, in a table as :func:`helimag.runs.read_table` reads it; A, B, C are KUKA's angles. Time is counted from
    the first row.

    Returns
    -------
    Log
        Poses of the tool over time, lab frame, SI.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where a frame, a column or a unit is missing, a value is no number, or time does not rise.
    """
    table = read_table(path, {**_KINDS, "motor": q.ANGLE}, needed=list(_KINDS))
    try:
        table.check_rises("time")
        _check_sizes(table)
        marks = _marks(table.comments)
        recorded = table.values.get("motor")
        motor = None if recorded is None else unwrapped(recorded)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    columns = table.values
    position = np.column_stack([columns[name] for name in "xyz"])
    pose = frames(position, rotation(np.column_stack([columns[name] for name in "abc"])))
    if marks["pose"] == "flange":
        pose = pose @ cell.tool_in_flange
    if marks["frame"] == "base":
        pose = inverse(cell.lab_in_base) @ pose
    time = columns["time"] - columns["time"][0]
    within = recorded is not None and _within_turn(recorded)
    return Log(time, pose, motor, marks["motor axis"] == "against", within)


def _check_sizes(table: Columns) -> None:
    """Refuse places and angles that no arm's log has."""
    for names, most, unit in (("xyz", FARTHEST, "m"), ("abc", ROUND, "rad")):
        for name in names:
            far = np.flatnonzero(np.abs(table.values[name]) > most)
            if far.size:
                got = table.values[name][far[0]]
                raise InputError(
                    f"line {table.lines[far[0]]}: {name} must be within {most:.3g} {unit} either way; got {got:.6g} "
                    f"{unit}; check its unit"
                )


def _within_turn(motor: Floats) -> bool:
    return float(np.ptp(motor)) <= ROUND


def unwrapped(motor: Floats) -> Floats:
    """A motor's angle (n,) in rad without the jumps of one that is recorded within a turn.

    Raises
    ------
    InputError
        Where it turns so far between two rows that its sense cannot be told, or jumps back by more though it is not
        within one turn.
    """
    if not _within_turn(motor):
        onwards = np.diff(motor) * np.sign(np.median(np.diff(motor)))
        if onwards.min() < -COARSE:
            raise InputError(
                f"motor jumps back by {math.degrees(-float(onwards.min())):.0f} deg, and is not within one turn; "
                "record it within a turn, or without jumps"
            )
        return motor
    whole = np.unwrap(motor)
    steps = np.abs(np.diff(whole))
    if steps.size and steps.max() > COARSE:
        raise InputError(
            f"motor turns {math.degrees(float(steps.max())):.0f} deg from row to row within a turn, so that its sense "
            f"cannot be told; record it at least every {math.degrees(COARSE):.0f} deg, or without jumps"
        )
    return np.asarray(whole)


def check_motor(log: Log, scenario: Scenario) -> None:
    """Whether a motor that was recorded within a turn was so often enough for the scenario's drive.

    Raises
    ------
    InputError
        Where whole turns between rows would not show.
    """
    longest, frequency = float(np.diff(log.time).max()), abs(scenario.drive.frequency)
    if log.within_turn and 2.0 * math.pi * frequency * longest > COARSE:
        raise InputError(
            f"motor is recorded within a turn, and rows lie up to {longest:.3g} s apart, in which a drive at "
            f"{frequency:.3g} Hz makes {frequency * longest:.3g} turns; record it at least every "
            f"{COARSE / (2.0 * math.pi * frequency):.2g} s, or without jumps"
        )


def _marks(comments: Sequence[str]) -> dict[str, str]:
    """What the comment lines state, in lower case."""
    stated: dict[str, str] = {}
    for line in comments:
        key, colon, value = (part.strip().lower() for part in line.partition(":"))
        if colon and key in _CHOICES and stated.setdefault(key, value) != value:
            raise InputError(f"comment lines state both '# {key}: {stated[key]}' and '# {key}: {value}'")
    found = {**_DEFAULTS, **stated}
    for key, choices in _CHOICES.items():
        if found.get(key) not in choices:
            raise InputError(
                f"a comment line must state '# {key}: {choices[0]}' or '{choices[1]}'; got {found.get(key)!r}"
            )
    return found


def log_of(table: Table, reversed_axis: bool) -> Log:
    """A plan's own table as if an arm had followed it exactly."""
    keep = np.append(np.diff(table.time) > 1e-9, True)
    return Log(table.time[keep], table.tool[keep], table.motor[keep], reversed_axis)


def log_of_playback(playback: Playback, scenario: Scenario, cell: Cell) -> Log:
    """What a programme does in a cell along its path, as a log without a motor.

    The axis is the way round that fits the start. What comes before the path begins, and the way up at its end, are no
    part of the run.

    Returns
    -------
    Log
        Poses of the tool over time, lab frame, SI.

    Raises
    ------
    InputError
        Where no controller would take the programme.
    """
    if playback.faults:
        raise InputError(f"no controller carries this programme out: {playback.faults[0]}")
    playback = on_path(cell, playback)
    keep = np.append(np.diff(playback.time) > CLOSEST, True) & (playback.time >= -CLOSEST)
    time = playback.time[keep]
    start = magnet_path(scenario).at(np.zeros(1)).axis[0]
    pose = playback.tool(cell)
    return Log(time - time[0], pose[keep], None, bool(pose[0, :3, 0] @ start < 0.0))


def replayed(scenario: Scenario, log: Log, source: str) -> Scenario:
    """The scenario with the magnet's path replaced by a log's, from the log's first row on, as long as both last.

    Where the log holds no motor angle, the motor is taken to turn evenly against the tool at the drive's frequency,
    so that a turn of the tool about the motor's axis turns the magnet with it.

    Returns
    -------
    Scenario
        Its drive a path of samples.

    Raises
    ------
    InputError
        Where the rotation axis comes too close to upright, or the motor may have turned whole turns between rows.
    """
    check_motor(log, scenario)
    axis = (-1.0 if log.reversed_axis else 1.0) * log.tool[:, :3, 0]
    yaw = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    pitch = np.arcsin(np.clip(axis[:, 2], -1.0, 1.0))
    even = 2.0 * math.pi * scenario.drive.frequency * log.time
    facing = turn(2, math.pi if log.reversed_axis else 0.0)
    untilted = np.swapaxes(turn(2, yaw) @ turn(1, -pitch) @ facing, -1, -2) @ log.tool[:, :3, :3]
    roll = np.unwrap(np.arctan2(untilted[:, 2, 1], untilted[:, 1, 1]))
    motor = motor_angle(even, float(roll[0]), log.reversed_axis) if log.motor is None else log.motor
    spin = (math.pi - motor if log.reversed_axis else motor) + (-roll if log.reversed_axis else roll)
    phase = spin - even
    path = {
        "time": log.time.tolist(),
        "position": log.tool[:, :3, 3].tolist(),
        "yaw": yaw.tolist(),
        "pitch": pitch.tolist(),
        "phase": (phase - 2.0 * math.pi * round(float(phase[0]) / (2.0 * math.pi))).tolist(),
    }
    # an arm's first moments say little of where it goes: the end that leads is the scenario's own
    pinned = {} if scenario.drive.heading is None else {"drive.heading": angles_of_start(scenario)}
    return scenario.replaced(
        {
            "drive.path": path,
            "drive.yaw_rate": 0.0,
            "drive.velocity": (0.0, 0.0, 0.0),
            **pinned,
            "run.duration": min(scenario.run.duration, float(log.time[-1])),
            "provenance": {**scenario.provenance, "drive.path": f"measured: {source}"},
        }
    )
