"""Tables that tracking programs write, brought to helimag's own heads: time, x, y, z, each with its unit."""

import re

from helimag.errors import InputError

Table = list[list[str]]

_UNIT = re.compile(r"^\s*[\[(]?\s*([^\])]*?)\s*[\])]?\s*$")
_MATLAB = re.compile(r"^(time|t|x|y|z)_([A-Za-z]+)$")
_TRACKER = re.compile(r"^(t|x|y|z)\s*(?:[\[(]\s*(\w+)\s*[\])])?$")
_DLTDV = re.compile(r"^pt\d+_(cam\d+_)?[xyz]$", re.IGNORECASE)
_TRACKMATE = {"POSITION_T": "time", "POSITION_X": "x", "POSITION_Y": "y", "POSITION_Z": "z"}
_SECONDS = {"sec": "s", "second": "s", "seconds": "s", "micron": "um", "microns": "um"}


def canonical(table: Table, path: object) -> Table:
    """Recognise what TrackMate, Tracker, MATLAB, DeepLabCut or DLTdv wrote, and give it helimag's heads.

    Parameters
    ----------
    table
        Rows of cells, the head first; a table of nobody's comes back as it is.
    path
        To name in messages.

    Raises
    ------
    InputError
        Where the program is recognised and its table cannot be a track in space, with what to do.
    """
    heads = [cell.strip() for cell in table[0]] if table else []
    if {"POSITION_X", "POSITION_T"} <= {head.upper() for head in heads}:
        return _trackmate(table, path)
    if heads and heads[0].lower() == "scorer" and len(table) > 1 and table[1][:1] == ["bodyparts"]:
        raise InputError(
            f"{path} is a table of DeepLabCut: places in one camera's picture (px), and a track needs x, y, z in the "
            f"lab; triangulate both cameras' tables first, or give the films to 'helimag vision track'"
        )
    if heads and all(_DLTDV.match(head) for head in heads if head):
        what = "places in the cameras' pictures" if any("cam" in head.lower() for head in heads) else "x, y, z"
        raise InputError(
            f"{path} is a table of DLTdv ({what}) without times and units: add a column 'time [s]', and name the "
            f"columns of the point's place 'x [mm]', 'y [mm]', 'z [mm]' with their unit"
        )
    return _tracker(table, path) or _matlab(table) or table


def _trackmate(table: Table, path: object) -> Table:
    """Spots of TrackMate: names for the program, names to read twice, units, and a row a spot."""
    heads = [cell.strip().upper() for cell in table[0]]
    places = {name: heads.index(key) for key, name in _TRACKMATE.items() if key in heads}
    if len(places) < len(_TRACKMATE):
        raise InputError(
            f"{path} is a table of TrackMate and must have {', '.join(_TRACKMATE)}; it has {', '.join(heads)}"
        )
    rows = table[1:]
    while rows and not _is_number(rows[0][places["x"]]):
        rows = rows[1:]
    above = table[len(table) - len(rows) - 1]
    track = heads.index("TRACK_ID") if "TRACK_ID" in heads else None
    if track is not None and len({row[track] for row in rows if row[track].strip()}) > 1:
        raise InputError(f"{path} is a table of TrackMate and must hold one track; filter it to the device's")
    units = [_unit(above[place]) for place in places.values()]
    if not all(units) or any(unit in ("pixel", "frame") for unit in units):
        raise InputError(
            f"{path} is a table of TrackMate in {', '.join(unit or 'no unit' for unit in units)}: calibrate the "
            f"picture's size and times there (Image > Properties) and export again"
        )
    first = [f"{name} [{unit}]" for name, unit in zip(places, units, strict=True)]
    ordered = sorted(rows, key=lambda row: float(row[places["time"]]))
    return [first, *([row[place] for place in places.values()] for row in ordered)]


def _tracker(table: Table, path: object) -> Table | None:
    """Table of Tracker (Open Source Physics): perhaps the mass's name, then heads such as ``t (s)``."""
    for number, row in enumerate(table[:3]):
        matches = [_TRACKER.match(cell.strip()) for cell in row]
        names = [match.group(1) if match else None for match in matches]
        if names[:1] != ["t"] or "x" not in names:
            continue
        if not {"x", "y", "z"} <= set(names):
            raise InputError(
                f"{path} is a table of Tracker in a plane ({', '.join(name for name in names if name)}); a track needs "
                f"x, y and z"
            )
        units = [match.group(2) if match else None for match in matches]
        if not all(unit for unit, name in zip(units, names, strict=True) if name):
            raise InputError(f"{path} is a table of Tracker without units; name them in its head: t (s), x (m), …")
        first = [
            f"{'time' if name == 't' else name} [{unit}]" if name else cell
            for name, unit, cell in zip(names, units, row, strict=True)
        ]
        return [first, *table[number + 1 :]]
    return None


def _matlab(table: Table) -> Table | None:
    """Table of MATLAB's ``writetable``, whose names can hold no brackets: ``time_s``, ``x_mm``."""
    matches = [_MATLAB.match(cell.strip()) for cell in table[0]] if table else []
    names = {match.group(1) for match in matches if match}
    if not ({"x", "y", "z"} <= names and names & {"t", "time"}):
        return None
    first = [
        f"{'time' if match.group(1) == 't' else match.group(1)} [{match.group(2)}]" if match else cell
        for match, cell in zip(matches, table[0], strict=True)
    ]
    return [first, *table[1:]]


def _unit(cell: str) -> str | None:
    match = _UNIT.match(cell)
    text = match.group(1) if match else ""
    return _SECONDS.get(text.lower(), text) or None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
