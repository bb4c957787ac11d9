"""Times of a film's frames, as a CSV file beside it."""

import csv
import io
import itertools
from collections.abc import Sequence
from pathlib import Path

from helimag.errors import InputError
from helimag.files import text_of


def read_times(path: Path) -> list[float]:
    """Times (s) of a film's frames: the column ``time_s`` of a CSV file.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where there is no such column, or the times do not rise.
    """
    try:
        rows = csv.DictReader(io.StringIO(text_of(path), newline=""))
        times = [float(row["time_s"]) for row in rows]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path} must have a column time_s with one number a row") from None
    if not all(later > earlier for earlier, later in itertools.pairwise(times)):
        raise InputError(f"{path} must have times that rise from row to row")
    return times


def write_times(path: Path, times: Sequence[float]) -> None:
    """Write the times (s) of a film's frames as CSV."""
    path.write_text("time_s\n" + "".join(f"{time:.6f}\n" for time in times), encoding="utf-8")
