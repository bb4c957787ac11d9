"""Times of a film's frames, as a CSV file beside it."""

import csv
import itertools
from collections.abc import Sequence
from pathlib import Path

from helimag.errors import FileError, InputError


def read_times(path: Path) -> list[float]:
    """Times (s) of a film's frames: the column ``time_s`` of a CSV file.

    Raises
    ------
    InputError
        Where there is no such column, or the times do not rise.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            times = [float(row["time_s"]) for row in csv.DictReader(file)]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path} must have a column time_s with one number a row") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None
    if not all(later > earlier for earlier, later in itertools.pairwise(times)):
        raise InputError(f"{path} must have times that rise from row to row")
    return times


def write_times(path: Path, times: Sequence[float]) -> None:
    """Write the times (s) of a film's frames as CSV."""
    path.write_text("time_s\n" + "".join(f"{time:.6f}\n" for time in times), encoding="utf-8")
