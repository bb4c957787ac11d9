"""Tables of numbers as people keep them: CSV whose columns carry their units. The one reader of logs and tracks."""

import csv
import io
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.errors import InputError
from helimag.files import bytes_of

Floats = NDArray[np.float64]
Line = tuple[int, str]  # its number in the file, and its text
Cells = tuple[int, list[str]]  # its number in the file, and its cells
Translation = Callable[[list[Cells]], tuple[str, list[Cells]]]  # also names the program that wrote the table

_HEAD = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]\s*)?")
_SLASHED = re.compile(r"\s*([A-Za-z_ -]+?)\s*/\s*(\S.*?)\s*")  # x / mm
_DECIMAL_COMMA = re.compile(r"[-+]?(\d+,\d*|,\d+)([eE][-+]?\d+)?")
_STATED = re.compile(r"\s*sep=([,;\t])\s*", re.IGNORECASE)
_EMPTY = ("", "nan", "na")
_SHOWN = 12  # heads that a refusal lists


@dataclass(frozen=True)
class Columns:
    """What a table holds.

    Attributes
    ----------
    values
        The columns by name, (n,) each, SI; nan where a cell is empty that may be.
    lines
        (n,): the number of each row's line in the file, for messages.
    comments
        Lines that begin with ``#``, without it, in order.
    program
        That wrote the table, where its heads tell.
    """

    values: dict[str, Floats]
    lines: NDArray[np.int64]
    comments: tuple[str, ...]
    program: str = ""

    def check_rises(self, name: str) -> None:
        """Raise InputError, naming the line, where a column does not rise from row to row."""
        late = np.flatnonzero(~(np.diff(self.values[name]) > 0.0))
        if late.size:
            raise InputError(f"line {self.lines[late[0] + 1]}: {name} must rise from row to row")


def read_table(
    path: str | Path,
    kinds: Mapping[str, q.Kind],
    *,
    needed: Sequence[str],
    gaps: Collection[str] = (),
    translate: Translation | None = None,
) -> Columns:
    """Read the columns of a table that are wanted; others are passed over.

    The first line that is neither blank nor a comment (``#``) holds the heads, each a name and a unit: ``x [mm]``,
    ``X (mm)`` or ``x / mm``. Upper and lower case are the same, and so are blank, hyphen and underscore within a name.
    Cells are separated by commas, semicolons or tabs; with the latter two, numbers may have decimal commas. The text is
    UTF-8, with or without byte-order mark, UTF-16 with one, or Windows-1252 (of which printable Latin-1 is a part). A
    first line such as ``sep=;`` is heeded.

    Parameters
    ----------
    path
        The file.
    kinds
        What may be read: the kind of quantity by the column's name.
    needed
        Names that must be there.
    gaps
        Names whose cells may be empty, ``nan`` or ``na``.
    translate
        Brings the heads of other programs' tables to those above.

    Returns
    -------
    Columns
        SI, by name.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it is no such table: the message names file and line.
    """
    try:
        return _table(_text(Path(path)), kinds, needed, gaps, translate)
    except (InputError, csv.Error) as error:
        raise InputError(f"{path}: {error}") from None


def _text(path: Path) -> str:
    content = bytes_of(path)
    try:
        text = content.decode("utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    if "\0" in text:
        raise InputError("it is not a text file")
    return text


def _table(
    text: str,
    kinds: Mapping[str, q.Kind],
    needed: Sequence[str],
    gaps: Collection[str],
    translate: Translation | None,
) -> Columns:
    written = [(i, line.rstrip("\n")) for i, line in enumerate(io.StringIO(text, newline=None), start=1)]
    comments = tuple(line.lstrip().removeprefix("#") for _, line in written if line.lstrip().startswith("#"))
    lines = [(i, line) for i, line in written if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise InputError("it is empty; a table has a line of heads, such as 'time [s], x [mm]', and two rows or more")
    stated = _STATED.fullmatch(lines[0][1])  # as spreadsheets write it for each other
    lines = lines[1:] if stated and len(lines) > 1 else lines
    separator = stated[1] if stated else next((mark for mark in ";\t" if mark in lines[0][1]), ",")
    fields = {i: next(csv.reader([line], delimiter=separator)) for i, line in lines}
    table = [(i, cells) for i, cells in ((i, _cells(line)) for i, line in fields.items()) if cells]
    if not table:
        raise InputError("it holds nothing but separators")
    program, table = translate(table) if translate else ("", table)
    first, heads = table[0]
    places = _places(heads, first, kinds, needed)
    rows = table[1:]
    if len(rows) < 2:
        raise InputError(f"a table has a line of heads and two rows or more; it has {len(rows)} below its heads")
    for i, cells in rows:
        if len(cells) > len(heads):
            raise _uncounted(i, len(cells), heads)
    values = {
        name: factor * _numbers(rows, place, heads[place], separator, name in gaps)
        for name, (place, factor) in places.items()
    }
    read = [place for place, _ in places.values()]
    _one_decimal_mark(rows, read)
    if separator == ",":
        _no_decimal_commas(rows, heads, read, fields)
    return Columns(values, np.array([i for i, _ in rows], dtype=np.int64), comments, program)


def _cells(fields: Sequence[str]) -> list[str]:
    """The cells of a line, without blanks around them and without empty ones at its end."""
    cells = [cell.strip() for cell in fields]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _uncounted(line: int, cells: int, heads: Sequence[str]) -> InputError:
    """A line with more or fewer cells than there are heads."""
    return InputError(
        f"line {line}: there are {cells} cells below {len(heads)} heads; numbers with a decimal comma need semicolons "
        "or tabs between them, and a cell without a value its comma"
    )


def _no_decimal_commas(
    rows: Sequence[Cells], heads: Sequence[str], read: Sequence[int], fields: Mapping[int, Sequence[str]]
) -> None:
    """Refuse a table between commas whose numbers may have decimal commas: cells would be read from the next column.

    One row of ``0,1,5`` is 0, 1 and 5, or 0 and 1.5 with nothing in the third column: only who wrote it can tell.
    """
    for i, _ in rows:
        if i in fields and len(fields[i]) < len(heads):
            raise _uncounted(i, len(fields[i]), heads)
    last = max(read)
    if len(heads) > last + 1 and not any("." in cells[place] for _, cells in rows for place in read if cells[place:]):
        raise InputError(
            f"line {rows[0][0]}: no number has a decimal point, and behind '{heads[last]}' there is "
            f"'{heads[last + 1]}', so that the commas may be decimal ones; put semicolons or tabs between the cells, "
            "leave that column out, or write one number with a point (0.0)"
        )


def _places(
    heads: Sequence[str], line: int, kinds: Mapping[str, q.Kind], needed: Sequence[str]
) -> dict[str, tuple[int, float]]:
    """Where each wanted column stands, and what its unit is in SI."""
    found: dict[str, tuple[int, float]] = {}
    for place, head in enumerate(heads):
        match = _SLASHED.fullmatch(head) or _HEAD.fullmatch(head)
        name = "_".join(match[1].lower().replace("-", " ").replace("_", " ").split()) if match else ""
        if match is None or name not in kinds:
            continue
        if name in found:
            raise InputError(f"line {line}: the column '{name}' is there twice; {_listed(heads)}")
        if not match[2]:
            raise InputError(f"line {line}: column '{head}' must name its unit, such as '{name} [{kinds[name].shown}]'")
        try:
            found[name] = (place, q.parse(f"1 {match[2]}", kinds[name]))
        except InputError as error:
            raise InputError(f"line {line}: the unit of column '{head}' {error}") from None
    lost = [name for name in needed if name not in found]
    if lost:
        wanted = ", ".join(f"{name} [{kinds[name].shown}]" for name in needed)
        raise InputError(
            f"line {line}: a table needs columns such as {wanted}; it lacks {', '.join(lost)}; {_listed(heads)}"
        )
    return found


def _listed(heads: Sequence[str]) -> str:
    more = f" and {len(heads) - _SHOWN} more" if len(heads) > _SHOWN else ""
    return f"its heads are {', '.join(repr(head) for head in heads[:_SHOWN])}{more}"


def _numbers(rows: Sequence[tuple[int, list[str]]], place: int, head: str, separator: str, gaps: bool) -> Floats:
    """A column; nan where a cell is empty that may be."""
    values = np.empty(len(rows))
    for row, (line, cells) in enumerate(rows):
        cell = cells[place] if place < len(cells) else ""
        values[row] = _number(cell, separator)
        if not math.isfinite(values[row]) and not (gaps and cell.lower() in _EMPTY):
            got = repr(cell) if cell else "nothing"
            raise InputError(f"line {line}: column {place + 1}, '{head}', must be a finite number; got {got}")
    return values


def _number(cell: str, separator: str) -> float:
    """The number in a cell; nan where there is none."""
    if separator != "," and _DECIMAL_COMMA.fullmatch(cell):
        cell = cell.replace(",", ".")
    cell = cell.replace("\u2212", "-")
    try:
        return math.nan if "_" in cell else float(cell)  # Python, unlike everyone else, reads 1_000 as a thousand
    except ValueError:
        return math.nan


def _one_decimal_mark(rows: Sequence[tuple[int, list[str]]], places: Sequence[int]) -> None:
    """Refuse a table with decimal commas and points: one of them then means thousands."""
    marked: dict[str, Line] = {}
    for line, cells in rows:
        for place in places:
            for mark in ",.":
                if place < len(cells) and mark in cells[place]:
                    marked.setdefault(mark, (line, cells[place]))
    if len(marked) > 1:
        (first, one), (second, other) = sorted(marked.values())
        raise InputError(
            f"line {second}: {other!r} and {one!r} (line {first}) do not have the same decimal mark; write numbers "
            "without marks between thousands"
        )
