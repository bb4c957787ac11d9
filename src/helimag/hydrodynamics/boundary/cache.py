"""Solutions kept on disk, named by all that decides them."""

import contextlib
import hashlib
import json
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from helimag.errors import FileError
from helimag.files import replacing
from helimag.hydrodynamics.boundary.device import device_surfaces
from helimag.hydrodynamics.boundary.refine import Solution, refined
from helimag.hydrodynamics.boundary.solve import Plane
from helimag.scenario import Device

VERSION = 1  # of the solver: raised whenever its numbers change
TOLERANCE = 0.01  # where the scenario gives none

LOG = logging.getLogger(__name__)

_memory: dict[str, Solution] = {}  # of this process: a sweep asks for the same device thousands of times


def solution(device: Device, plane: Plane | None = None) -> Solution:
    """The device's resistance by the boundary model, from the disk where it has been solved before.

    Parameters
    ----------
    device
        Its shape and ``hydrodynamics.tolerance`` count.
    plane
        A floor or surface beside the device; open water without.

    Returns
    -------
    Solution
        Per viscosity. Kept in the user's folder for caches (``XDG_CACHE_HOME`` where set); a folder that cannot be
        written costs time only, and a file that is not whole is solved again.

    Raises
    ------
    InputError
        Where the device's body is no closed surface, where it reaches through the plane, or where the tolerance is out
        of reach.
    """
    key = _digest(question(device, plane))
    if key not in _memory:
        path = folder() / f"{key}.json"
        found = _read(path)
        LOG.info(
            "drag of this device by the boundary model: %s %s",
            "to be solved, not in" if found is None else "from",
            path,
        )
        if found is None:
            found = refined(device_surfaces(device), _tolerance(device), plane)
            _write(path, found)
        _memory[key] = found
    return _memory[key]


def folder() -> Path:
    """Where solutions are kept."""
    from platformdirs import user_cache_path

    return user_cache_path("helimag") / "resistance"


def question(device: Device, plane: Plane | None) -> str:
    """All that decides a solution, as text."""
    body = None if device.body is None else device.body.model_dump(exclude={"file"})
    helix = None if device.helix is None else device.helix.model_dump()
    head = None if device.head is None else device.head.model_dump()
    beside = None if plane is None else [plane.kind, *plane.normal, plane.distance]
    return json.dumps([VERSION, _tolerance(device), helix, head, body, beside], sort_keys=True)


def _tolerance(device: Device) -> float:
    given = device.hydrodynamics.tolerance
    return TOLERANCE if given is None else given


def _write(path: Path, found: Solution) -> None:
    data = {
        "resistance": found.resistance.tolist(),
        "error_estimate": found.error_estimate,
        "triangles": found.triangles,
        "levels": [level.tolist() for level in found.levels],
    }
    text = json.dumps(data)
    with contextlib.suppress(FileError, OSError), kept_at(path) as beside:
        beside.write_text(f"{text}\n{_digest(text)}", encoding="utf-8")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


@contextlib.contextmanager
def kept_at(path: Path) -> Iterator[Path]:
    """Give a file to write that becomes a file of the cache when the block has succeeded.

    A cache that cannot be written raises FileError or OSError; the caller's result is none the worse for it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as beside:
        yield beside


def _read(path: Path) -> Solution | None:
    """The solution in a file; None where there is none, or not as it was written: its last line tells the hash."""
    try:
        text, _, digest = path.read_text(encoding="utf-8").rpartition("\n")
        if digest != _digest(text):
            return None
        data = json.loads(text)
        levels = tuple(np.array(level, dtype=np.float64) for level in data["levels"])
        resistance = np.array(data["resistance"], dtype=np.float64)
        return Solution(resistance, float(data["error_estimate"]), tuple(data["triangles"]), levels)
    except (OSError, ValueError):
        return None
