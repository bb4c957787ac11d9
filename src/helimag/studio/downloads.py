"""Files that a run is saved to, made in memory or in a folder of the studio's own that is gone afterwards."""

import io
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from helimag.files import csv_text
from helimag.runs import Trajectory

FORMATS = {
    "png": "Figure (PNG)",
    "svg": "Figure (SVG)",
    "csv": "Time series (CSV)",
    "nc": "Run (NetCDF)",
    "mp4": "Film (MP4, some seconds)",
}
COLUMNS = ("gap", "attack_angle", "phase_lag", "height_low", "height_high", "slips")


def written(run: Trajectory, kind: str, progress: Callable[[float], None]) -> bytes:
    """A run as a file of one of the ``FORMATS``.

    Raises
    ------
    MissingExtra
        Where figures or films need what is not installed.
    """
    if kind == "csv":
        return as_csv(run)
    with tempfile.TemporaryDirectory(prefix="helimag-studio-") as folder:
        place = Path(folder) / f"run.{kind}"
        if kind == "nc":
            run.save(place)
        else:
            from helimag import plots

            if kind == "mp4":
                plots.animate(run, place, progress=progress)
            else:
                plots.save(plots.draw_run(run), place)
        return place.read_bytes()


def as_csv(run: Trajectory) -> bytes:
    """Time, place and what the charts show, in SI with units in the heads; reads back as a track."""
    data = run.dataset
    columns = {"time [s]": data["time"].values}
    columns |= {f"{axis} [m]": data["position"].values[:, i] for i, axis in enumerate("xyz")}
    for name in COLUMNS:
        if name in data:
            unit = str(data[name].attrs.get("units", "1"))
            columns[name if unit == "1" else f"{name} [{unit}]"] = data[name].values
    rows = ([float(value) for value in row] for row in np.column_stack(list(columns.values())))
    return csv_text([list(columns), *rows]).encode()


def zipped(texts: dict[str, bytes]) -> bytes:
    """Some files as one."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in texts.items():
            archive.writestr(name, content)
    return packed.getvalue()


def file_name(title: str) -> str:
    """A file's name made of a run's title: letters, digits and hyphens."""
    words = "".join(c if c.isascii() and c.isalnum() else " " for c in title).split()
    return "-".join(words)[:60] or "run"
