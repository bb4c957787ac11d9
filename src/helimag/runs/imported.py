"""Tracks made by other tools: a CSV file whose columns carry their units."""

import csv
import json
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import FileError, InputError
from helimag.runs.gain import End
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

_HEADER = re.compile(r"\s*(\w+?)\s*[\[(]\s*([^\])]+?)\s*[\])]\s*")
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


def import_track(path: str | Path, *, initial_gap: float, name: str | None = None) -> Trajectory:
    """Read a track: columns ``time``, ``x``, ``y``, ``z`` of the head, and where known ``attack_angle`` and standard
    deviations.

    Each column's head names its unit, such as ``x [mm]`` or ``time (s)``; z points up. Rows with an empty position are
    gaps, and are left out.

    Parameters
    ----------
    initial_gap
        Height of the magnet above the device at the start (m).

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where a column or a unit is missing, a number is none, or times do not rise.
    """
    if not (np.isfinite(initial_gap) and initial_gap > 0.0):
        raise InputError(f"initial_gap must be a length greater than zero; got {initial_gap} m")
    columns = _columns(Path(path))
    there = np.all([np.isfinite(columns[axis]) for axis in ("x", "y", "z")], axis=0)
    time = columns["time"]
    if not np.all(np.isfinite(time)) or not np.all(np.diff(time) > 0.0):
        raise InputError(f"{path} must have times that rise from row to row, without empty ones")
    if there.sum() < 2:
        raise InputError(f"{path} must have at least two rows with a position; it has {int(there.sum())}")
    interval = float(np.median(np.diff(time)))
    kept = {key: values[there] for key, values in columns.items()}
    variables: dict[str, Floats] = {"position": np.stack([kept["x"], kept["y"], kept["z"]], axis=1)}
    if {"x_sd", "y_sd", "z_sd"} <= set(kept):
        spread = np.stack([kept["x_sd"], kept["y_sd"], kept["z_sd"]], axis=1)
        variables["position_covariance"] = spread[:, :, None] ** 2 * np.eye(3)
    variables |= {key: kept[key] for key in ("attack_angle", "attack_angle_sd") if key in kept}
    for key, values in variables.items():
        if not np.all(np.isfinite(values)):
            raise InputError(f"{path} must have a number in every row that has a position; {key} has empty ones")
    times = kept["time"]
    wide = np.flatnonzero(np.diff(times) > 1.6 * interval)
    gaps = [[float(times[i] - times[0]), float(times[i + 1] - times[0]), "no position in the file"] for i in wide]
    variables["segment"] = np.concatenate([[0.0], np.cumsum(np.diff(times) > 1.6 * interval)])
    attributes: dict[str, object] = {
        "name": name or Path(path).stem,
        "source": f"imported from {Path(path).name}",
        "initial_gap": initial_gap,
        "end": str(End.HORIZON),
        "gaps": json.dumps(gaps),
        "frame_interval": interval,
    }
    return Trajectory.from_arrays(times - times[0], variables, attributes)


def _columns(path: Path) -> dict[str, Floats]:
    """The file's columns in SI; NaN where a cell is empty."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(line for line in file if not line.startswith("#")) if row]
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path} is not a CSV file: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{path} must have a head and at least two rows; it is empty")
    columns: dict[str, Floats] = {}
    for place, head in enumerate(rows[0]):
        match = _HEADER.fullmatch(head)
        key = (match.group(1) if match else head).strip().lower()
        if key not in COLUMNS:
            continue
        if match is None:
            raise InputError(f"{path}: the column '{key}' must name its unit, such as '{key} [{COLUMNS[key].shown}]'")
        factor = q.parse(f"1 {match.group(2)}", COLUMNS[key])
        columns[key] = factor * np.array([_number(row, place, number, path) for number, row in enumerate(rows[1:], 2)])
    missing = [key for key in NEEDED if key not in columns]
    if missing:
        raise InputError(f"{path} must have the columns {', '.join(NEEDED)}; {', '.join(missing)} missing")
    return columns


def _number(row: list[str], place: int, line: int, path: Path) -> float:
    text = row[place].strip() if place < len(row) else ""
    if text.lower() in ("", "nan", "na"):
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{path}, row {line}: '{text}' is not a number") from None
