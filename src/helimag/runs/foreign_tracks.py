"""Tables that tracking programs write, brought to helimag's own heads: time, x, y, z, each with its unit."""

import re

from helimag.errors import InputError
from helimag.runs.tables import Cells

_MATLAB = re.compile(r"(time|t|x|y|z)_([A-Za-z]+)")
_TRACKER = re.compile(r"(t|x|y|z)\s*(?:[\[(]\s*(\w+)\s*[\])])?")
_DLTDV = re.compile(r"pt_?\d+_(cam_?\d+_)?[xyz]", re.IGNORECASE)
_TRACKMATE = {"POSITION_T": "time", "POSITION_X": "x", "POSITION_Y": "y", "POSITION_Z": "z"}
_UNITS = {"sec": "s", "second": "s", "seconds": "s", "micron": "um", "microns": "um"}
_UNCALIBRATED = ("", "pixel", "pixels", "frame", "frames")


def canonical(table: list[Cells]) -> tuple[str, list[Cells]]:
    """Recognise what TrackMate, Tracker, MATLAB, DeepLabCut or DLTdv wrote, and give it helimag's heads.

    Parameters
    ----------
    table
        Lines with their numbers, the heads first.

    Returns
    -------
    tuple
        The program's name and its table; an empty name and the same table where it is none of these.

    Raises
    ------
    InputError
        Where the program is recognised and its table cannot be a track in space, with what to do.
    """
    heads = [cell.strip() for cell in table[0][1]]
    if {"POSITION_X", "POSITION_T"} <= {head.upper() for head in heads}:
        return "TrackMate", _trackmate(table)
    if heads[0].startswith("<?xml"):
        raise InputError("it is an XML file and no table; of TrackMate, export the spots as CSV")
    if heads[0].lower() == "scorer" and any(cells[0].strip() == "bodyparts" for _, cells in table[1:3]):
        if any(cells[0].strip() == "coords" and "z" in cells for _, cells in table[2:4]):
            raise InputError(
                "it is a table of DeepLabCut in space, without times and units: write one line of heads, 'time [s]', "
                "'x [mm]', 'y [mm]', 'z [mm]', with z up in the lab"
            )
        raise InputError(
            "it is a table of DeepLabCut: places in one camera's picture (px), and a track needs time, x, y, z in the "
            "lab; triangulate both cameras' tables first, or give the films to 'helimag vision track'"
        )
    if any(heads) and all(_DLTDV.fullmatch(head) for head in heads if head):
        what = "places in the cameras' pictures" if any("cam" in head.lower() for head in heads) else "x, y, z"
        raise InputError(
            f"it is a table of DLTdv ({what}) without times and units: add a column 'time [s]', and name the columns "
            f"of the point's place with their unit: 'x [mm]', 'y [mm]', 'z [mm]'"
        )
    for name, read in (("Tracker", _tracker), ("MATLAB", _matlab)):
        if (found := read(table)) is not None:
            return name, found
    return "", table


def _trackmate(table: list[Cells]) -> list[Cells]:
    """Spots of TrackMate: names for the program, names to read twice, units, and a line a spot."""
    heads = [cell.strip().upper() for cell in table[0][1]]
    table = [(i, cells + [""] * (len(heads) - len(cells))) for i, cells in table]  # a line may have been cut
    twice = [key for key in _TRACKMATE if heads.count(key) > 1]
    if twice:
        raise InputError(f"it is a table of TrackMate and must have {twice[0]} once; it has {', '.join(heads)}")
    places = {name: heads.index(key) for key, name in _TRACKMATE.items() if key in heads}
    if len(places) < len(_TRACKMATE):
        raise InputError(f"it is a table of TrackMate and must have {', '.join(_TRACKMATE)}; it has {', '.join(heads)}")
    begin = next((k for k, (_, cells) in enumerate(table) if k and _is_number(cells[places["x"]])), len(table))
    rows = table[begin:]
    if not rows or begin == 1:
        raise InputError("it is a table of TrackMate and must have a line of units, such as (mm) and (sec), and spots")
    track = heads.index("TRACK_ID") if "TRACK_ID" in heads else None
    if track is not None and len({cells[track] for _, cells in rows if cells[track].strip()}) > 1:
        raise InputError("it is a table of TrackMate and must hold one track; filter it to the device's")
    units = [table[begin - 1][1][place].strip(" ()[]") for place in places.values()]
    if any(unit.lower() in _UNCALIBRATED for unit in units):
        raise InputError(
            f"it is a table of TrackMate in {', '.join(unit or 'no unit' for unit in units)}: set pixel size and frame "
            f"interval there (Image > Properties) and export again"
        )
    first = [f"{name} [{_UNITS.get(unit.lower(), unit)}]" for name, unit in zip(places, units, strict=True)]
    timed = all(_is_number(cells[places["time"]]) for _, cells in rows)  # what is none is refused by its line
    ordered = sorted(rows, key=lambda row: float(row[1][places["time"]])) if timed else rows
    return [(table[0][0], first), *((i, [cells[place] for place in places.values()]) for i, cells in ordered)]


def _tracker(table: list[Cells]) -> list[Cells] | None:
    """Table of Tracker (Open Source Physics): perhaps the mass's name, then heads such as ``t (s)``."""
    for number, (line, cells) in enumerate(table[:3]):
        matches = [_TRACKER.fullmatch(cell.strip()) for cell in cells]
        names = [match.group(1) if match else "" for match in matches]
        if names[0] != "t" or "x" not in names:
            continue
        if not {"x", "y", "z"} <= set(names):
            raise InputError(
                f"it is a table of Tracker in a plane ({', '.join(name for name in names if name)}); a track needs "
                f"t, x, y and z"
            )
        if not all(match.group(2) for match in matches if match):
            raise InputError(
                "it is a table of Tracker without units; name them in its heads: t (s), x (m), y (m), z (m)"
            )
        first = [
            f"{'time' if match.group(1) == 't' else match.group(1)} [{match.group(2)}]" if match else cell
            for match, cell in zip(matches, cells, strict=True)
        ]
        return [(line, first), *table[number + 1 :]]
    return None


def _matlab(table: list[Cells]) -> list[Cells] | None:
    """Table of MATLAB's ``writetable``, whose names can hold no brackets: ``time_s``, ``x_mm``."""
    line, cells = table[0]
    matches = [_MATLAB.fullmatch(cell.strip()) for cell in cells]
    names = {match.group(1) for match in matches if match}
    if not ({"x", "y", "z"} <= names and names & {"t", "time"}):
        return None
    first = [
        f"{'time' if match.group(1) == 't' else match.group(1)} [{match.group(2)}]"
        if match and match.group(2) != "sd"
        else cell
        for match, cell in zip(matches, cells, strict=True)
    ]
    return [(line, first), *table[1:]]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
