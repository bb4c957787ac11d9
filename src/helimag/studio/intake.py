"""What comes in from a browser, read strictly: scenarios as text and in links, runs as files.

Nothing that a browser sends may name a file of this machine, and no name that it gives is used for one: what a library
reads from disk only is put into a folder of the studio's own, under the studio's own name, and is gone afterwards.
"""

import base64
import binascii
import tempfile
import tomllib
import zlib
from pathlib import Path
from typing import Any

from helimag.calibration import Posterior
from helimag.errors import FileError, InputError
from helimag.runs import Trajectory, import_track
from helimag.scenario import Scenario, parse
from helimag.studio.hdf5 import attribute_of, check_netcdf

MOST_TEXT = 256 * 2**10  # bytes of a scenario
MOST_PLAN = 2 * 2**20  # bytes of a calibration's plan, which holds a scenario for each of its runs
MOST_RUN = 16 * 2**20  # bytes of a run
DEEPEST = 12  # levels of a scenario's tables and lists; it has six
LONGEST_RUN = 36_000.0  # s that a browser may ask for
MOST_TURNS = 200_000.0
MOST_SAMPLES = 50_000.0


def scenario_from_text(text: str, source: str = "the file") -> Scenario:
    """A scenario that someone uploaded or sent as a link.

    Raises
    ------
    InputError
        Where it is too large, no scenario, names a file, or would keep the server busy for hours.
    """
    tables_of(text, source, MOST_TEXT)
    return bounded(parse(text, source))


def tables_of(text: str, source: str, most: int) -> dict[str, Any]:
    """TOML that someone sent, not too large or deep, and without a file of this machine in it.

    Raises
    ------
    InputError
        Where it is none of that.
    """
    if len(text.encode("utf-8", "replace")) > most:
        raise InputError(f"{source} must have {most // 1024} kB at most")
    if max(_depth(text), 0) > DEEPEST:
        raise InputError(f"{source} must not be nested deeper than {DEEPEST} levels")
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise InputError(f"{source} is not valid TOML: {str(error)[:200]}") from None
    if _names_a_file(data):
        raise InputError(f"{source} must not name a file of this machine (device.body.file); use the command line")
    return data


def _names_a_file(data: Any) -> bool:
    """Whether there is a body with a file somewhere; tables lie no deeper than was checked."""
    if isinstance(data, list):
        return any(_names_a_file(each) for each in data)
    if not isinstance(data, dict):
        return False
    body = data.get("body")
    return (isinstance(body, dict) and "file" in body) or any(_names_a_file(each) for each in data.values())


def bounded(scenario: Scenario) -> Scenario:
    """The scenario, if a page may ask for it.

    Raises
    ------
    InputError
        Where the run would take the server too long, or too much memory.
    """
    run, turns = scenario.run, abs(scenario.drive.frequency) * scenario.run.duration
    if run.duration > LONGEST_RUN or turns > MOST_TURNS or run.duration / run.sample_interval > MOST_SAMPLES:
        raise InputError(
            f"a run in the studio must have {LONGEST_RUN:g} s, {MOST_TURNS:g} turns and {MOST_SAMPLES:g} samples at "
            "most; use the command line for longer ones"
        )
    return scenario


def _depth(text: str) -> int:
    """How deep brackets nest, those in strings included: an upper bound."""
    deepest = depth = 0
    for character in text:
        if character in "[{":
            depth += 1
            deepest = max(deepest, depth)
        elif character in "]}":
            depth -= 1
    return deepest


def link_of(scenario: Scenario) -> str:
    """A scenario as text that fits into an address."""
    return base64.urlsafe_b64encode(zlib.compress(scenario.to_toml().encode(), 9)).decode().rstrip("=")


def scenario_from_link(text: str) -> Scenario:
    """The scenario that :func:`link_of` wrote.

    Raises
    ------
    InputError
        Where it is none.
    """
    try:
        packed = base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
        unpacker = zlib.decompressobj()
        written = unpacker.decompress(packed, MOST_TEXT + 1).decode("utf-8")
    except (binascii.Error, zlib.error, ValueError):
        raise InputError("the link is damaged: it does not hold a scenario") from None
    if not unpacker.eof:
        raise InputError("the link is damaged or too large: its scenario does not end")
    return scenario_from_text(written, "the link")


def scenario_from_bytes(content: bytes) -> Scenario:
    """A scenario uploaded as a file.

    Raises
    ------
    InputError
        Where it is none.
    """
    if len(content) > MOST_TEXT:
        raise InputError(f"a scenario's file must have {MOST_TEXT // 1024} kB at most; it has {len(content) // 1024}")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("a scenario's file must be text (TOML); this one is not") from None
    return scenario_from_text(text)


def run_from_bytes(content: bytes, suffix: str, initial_gap: float) -> Trajectory:
    """A run uploaded as a file: netCDF of this package, or a table of a measured track.

    Parameters
    ----------
    content
        Of the file.
    suffix
        Of its name, ``.nc`` or ``.csv``; all that is used of it.
    initial_gap
        Height of the magnet above the device at the start (m), for a table.

    Raises
    ------
    InputError
        Where it is neither.
    FileError
        Where it is damaged.
    """
    if len(content) > MOST_RUN:
        raise InputError(f"a run's file must have {MOST_RUN // 2**20} MB at most; it has {len(content) // 2**20}")
    if suffix not in {".nc", ".csv"}:
        raise InputError("a run's file must end in .nc (from 'helimag simulate -o') or .csv (a measured track)")
    if suffix == ".nc":
        check_netcdf(content)
    with tempfile.TemporaryDirectory(prefix="helimag-studio-") as folder:
        place = Path(folder) / f"upload{suffix}"
        place.write_bytes(content)
        try:
            if suffix == ".nc":
                return Trajectory.load(place)
            return import_track(place, initial_gap=initial_gap, name="measured")
        except (InputError, FileError) as error:
            raise type(error)(str(error).replace(str(place), "the file")) from None


def fit_from_bytes(content: bytes) -> Posterior:
    """A calibration uploaded as a file, as ``helimag calibrate`` writes it.

    Raises
    ------
    InputError
        Where it is none, or its plan names a file of this machine.
    FileError
        Where it is damaged.
    """
    if len(content) > MOST_RUN:
        raise InputError(f"a calibration must have {MOST_RUN // 2**20} MB at most; it has {len(content) // 2**20}")
    check_netcdf(content)
    tables = tables_of(attribute_of(content, "plan"), "the calibration's plan", MOST_PLAN)
    runs = tables.get("run")
    whole = isinstance(runs, list) and all(isinstance(run, dict) and isinstance(run.get("base"), dict) for run in runs)
    if not runs or not whole:
        raise InputError("the calibration's plan must hold the scenarios of its runs; make it with helimag calibrate")
    with tempfile.TemporaryDirectory(prefix="helimag-studio-") as folder:
        place = Path(folder) / "upload.nc"
        place.write_bytes(content)
        try:
            return Posterior.load(place)
        except (InputError, FileError) as error:
            raise type(error)(str(error).replace(str(place), "the file")) from None
