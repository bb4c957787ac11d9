"""Tracks made by other tools: a CSV file whose columns carry their units."""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError
from helimag.outcomes import End
from helimag.runs.foreign_tracks import canonical
from helimag.runs.tables import read_table
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

COLUMNS = {
    "time": q.TIME,
    "x": q.LENGTH,
    "y": q.LENGTH,
    "z": q.LENGTH,
    "x_sd": q.LENGTH,
    "y_sd": q.LENGTH,
    "z_sd": q.LENGTH,
    "attack_angle": q.ANGLE,
    "attack_angle_sd": q.ANGLE,
}
NEEDED = ("time", "x", "y", "z")
# sizes (m, rad) that no laboratory's track has: beyond them a unit or a digit is wrong
MOST = {"x": 100.0, "y": 100.0, "z": 100.0, "x_sd": 1.0, "y_sd": 1.0, "z_sd": 1.0, "attack_angle": np.pi / 2}
MOST["attack_angle_sd"] = np.pi
JUMP = 5.0  # usual steps from row to row: farther there and back again, nothing swims


def import_track(path: str | Path, *, initial_gap: float, name: str | None = None) -> Trajectory:
    """Read a track: columns ``time``, ``x``, ``y``, ``z`` of the head, and where known ``attack_angle`` and standard
    deviations.

    A table as :func:`helimag.runs.read_table` reads it: each column's head names its unit, such as ``x [mm]`` or
    ``time (s)``; tables of TrackMate, Tracker and MATLAB's ``writetable`` are understood. z points up. Rows with an
    empty position are gaps, and are left out.

    Parameters
    ----------
    initial_gap
        Height of the magnet above the device at the start (m).

    Returns
    -------
    Trajectory
        A measured run.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where a column or a unit is missing, a number is none, or times do not rise.
    """
    if not (np.isfinite(initial_gap) and initial_gap > 0.0):
        raise InputError(f"initial_gap must be a length greater than zero; got {initial_gap} m")
    table = read_table(path, COLUMNS, needed=NEEDED, gaps=COLUMNS.keys() - {"time"}, translate=canonical)
    columns = table.values
    there = np.all([np.isfinite(columns[axis]) for axis in ("x", "y", "z")], axis=0)
    time = columns["time"]
    try:
        table.check_rises("time")
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if there.sum() < 2:
        raise InputError(f"{path} must have at least two rows with a position; it has {int(there.sum())}")
    interval = float(np.median(np.diff(time)))
    kept = {key: values[there] for key, values in columns.items()}
    variables: dict[str, Floats] = {"position": np.stack([kept["x"], kept["y"], kept["z"]], axis=1)}
    if {"x_sd", "y_sd", "z_sd"} <= set(kept):
        spread = np.stack([kept["x_sd"], kept["y_sd"], kept["z_sd"]], axis=1)
        variables["position_covariance"] = spread[:, :, None] ** 2 * np.eye(3)
    variables |= {key: kept[key] for key in ("attack_angle", "attack_angle_sd") if key in kept}
    for key, values in kept.items():
        empty = np.flatnonzero(~np.isfinite(values))
        if empty.size:
            line = table.lines[there][empty[0]]
            raise InputError(f"{path}: line {line}: {key} must have a number in every row that has a position")
        _check_size(key, values, table.lines[there], path)
    _check_placeholders(variables["position"], table.lines[there], path)
    times = kept["time"]
    wide = np.flatnonzero(np.diff(times) > 1.6 * interval)
    gaps = [[float(times[i] - times[0]), float(times[i + 1] - times[0]), "no position in the file"] for i in wide]
    variables["segment"] = np.concatenate([[0.0], np.cumsum(np.diff(times) > 1.6 * interval)])
    attributes: dict[str, object] = {
        "name": name or Path(path).stem,
        "source": f"imported from {Path(path).name}{f', a table of {table.program}' if table.program else ''}",
        "initial_gap": initial_gap,
        "end": str(End.HORIZON),
        "gaps": json.dumps(gaps),
        "frame_interval": interval,
    }
    return Trajectory.from_arrays(times - times[0], variables, attributes)


def _check_size(key: str, values: Floats, lines: NDArray[np.int64], path: str | Path) -> None:
    """Refuse what no track holds: places beyond any laboratory, negative standard deviations."""
    most, least = MOST.get(key, np.inf), 0.0 if key.endswith("_sd") else -np.inf
    bad = np.flatnonzero((np.abs(values) > most * (1.0 + 1e-9)) | (values < least))
    if bad.size:
        kind = COLUMNS[key]
        bound = f"at most {q.show(float(most), kind)}" + ("" if key.endswith("_sd") else " either way")
        sign = "not negative and " if key.endswith("_sd") else ""
        raise InputError(
            f"{path}: line {lines[bad[0]]}: {key} must be {sign}{bound}; got '{q.show(float(values[bad[0]]), kind)}'; "
            f"check its unit"
        )


def _check_placeholders(position: Floats, lines: NDArray[np.int64], path: str | Path) -> None:
    """Refuse a row of three zeros far from its neighbours: some programs write a frame without a device so."""
    if position.shape[0] < 3:
        return
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    zero = np.all(position == 0.0, axis=1)
    usual = steps[~zero[:-1] & ~zero[1:] & (steps > 0.0)]  # those to and from such a row are none
    far = JUMP * float(np.median(usual)) if usual.size else 0.0
    lost = np.flatnonzero(zero[1:-1] & (steps[:-1] > far) & (steps[1:] > far))
    if lost.size:
        raise InputError(
            f"{path}: line {lines[lost[0] + 1]}: x, y and z are 0, far from the rows before and after; leave the cells "
            "of a frame without a position empty"
        )
