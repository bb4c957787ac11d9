"""Boxes of inputs in a row, each proved by itself, that make up one: the certificate that lists them, and its check.

Nothing but the cells' own claims is claimed: for each value of the inputs in the whole box some cell says that an orbit
attracts all of a tube. Whether the row has no gap is decided in rational numbers.
"""

from dataclasses import dataclass
from decimal import Context, Decimal, Inexact
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from helimag.errors import InputError
from helimag.files import text_of
from helimag.proof.bounds import Report, silent
from helimag.proof.certificate import Certificate, certificate_from, check, read_certificate, require_tolerances
from helimag.proof.exact import parts, written
from helimag.proof.sealing import Sealed, format_of, opened, reading, require_same

ROW = "helimag proof row 1"
DIGITS = 400  # more than sums of numbers have that a certificate may give
Interval = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Row(Sealed):
    """Certificates of boxes of the same inputs, one beside the other along one of them, in ascending order."""

    along: str
    cells: tuple[Certificate, ...]

    @property
    def box(self) -> dict[str, Interval]:
        """By path, from where to where the input may be, in the unit of the scenario's file, whatever the others are.

        Along the row from its one end to its other; across it what all cells have in common.
        """
        every = {path: [interval(cell, path) for cell in self.cells] for path in self.cells[0].within}
        common = {path: (max(low for low, _ in each), min(high for _, high in each)) for path, each in every.items()}
        ends = every[self.along]
        return common | {self.along: (ends[0][0], ends[-1][1])}

    @property
    def bound(self) -> float:
        """Of the norm of the linearised map of a turn, everywhere in all tubes, each in its own norm."""
        return max(cell.claims.bound for cell in self.cells)

    @property
    def clearance(self) -> float:
        """What all motions in all tubes keep from all around them, m."""
        return min(cell.claims.clearance for cell in self.cells)

    def content(self) -> dict[str, Any]:
        """All but the hash, as JSON has it.

        Returns
        -------
        dict
            Plain numbers, text and lists.
        """
        box = {path: [decimal(end) for end in ends] for path, ends in self.box.items()}
        return {"format": ROW, "along": self.along, "box": box, "cells": [cell.content() for cell in self.cells]}


def decimal(number: Fraction) -> str:
    """A number that decimals were added to, exactly."""
    exactly = Context(prec=DIGITS, traps=[Inexact])
    return f"{exactly.divide(Decimal(number.numerator), Decimal(number.denominator)).normalize():f}"


def interval(cell: Certificate, path: str) -> Interval:
    """From where to where an input may be in a cell, in the unit of the scenario's file."""
    middle, width = parts(written(cell.scenario, path))[0], Fraction(cell.within[path])
    return middle - width, middle + width


def read_row(text: str) -> Row:
    """A row from its text, its hash compared.

    Returns
    -------
    Row
        Its cells fit together; they are not proved again.

    Raises
    ------
    InputError
        Where it is none, or is not as it was written.
    """
    with reading():
        content, recorded = opened(text, ROW)
        row = Row(content["along"], tuple(certificate_from(cell) for cell in content["cells"]))
        require_row(row)
        require_same(row.content(), recorded)
    return row


def require_row(row: Row) -> None:
    """Refuse cells that are not of one scenario but for the place along the row, or that leave a gap in the box.

    Raises
    ------
    InputError
        Naming what does not fit.
    """
    if not row.cells:
        raise InputError("the certificate's row has no cells")
    first = row.cells[0]
    for cell in row.cells:
        require_tolerances(cell)
        if cell.within.keys() != first.within.keys() or row.along not in cell.within:
            raise InputError("the certificate's cells must have tolerances of the same inputs, its row's among them")
        if not cell.covers(first.scenario.replaced({row.along: written(cell.scenario, row.along)})):
            raise InputError(f"the certificate's cells must differ in {row.along} and its tolerances only")
    ends = [interval(cell, row.along) for cell in row.cells]
    for (low, high), (next_low, next_high) in pairwise(ends):
        if not (low < next_low <= high < next_high):
            raise InputError(f"the certificate's cells must lie in ascending order along {row.along}, without a gap")
    if any(not low < high for low, high in row.box.values()):
        raise InputError("the certificate's cells have no box in common across their row")


def check_row(row: Row, *, progress: Report = silent) -> Row:
    """Prove all cells again, and that they make up the box.

    Parameters
    ----------
    progress
        Told which part of the work is done, from 0 to 1; what it raises stops it.

    Returns
    -------
    Row
        The one that was given: its claims hold.

    Raises
    ------
    InputError
        Where a cell does not prove what it claims, or the cells do not fit together.
    """
    require_row(row)
    for n, cell in enumerate(row.cells):
        claims = check(cell, progress=lambda part, n=n: progress((n + part) / len(row.cells)))  # type: ignore[misc]
        if not claims.proved:
            raise InputError(f"the certificate's cell {n + 1} is not of orbits that are proved to attract")
    return row


def read_any(text: str) -> Certificate | Row:
    """A certificate of one cell, or of a row of them; its hash compared.

    Returns
    -------
    Certificate or Row
        Not proved again: that is what :func:`check_file` does.

    Raises
    ------
    InputError
        Where it is none, or was changed.
    """
    with reading():
        return read_row(text) if format_of(text) == ROW else read_certificate(text)


def check_file(path: str | Path, *, progress: Report = silent) -> Certificate | Row:
    """Read a certificate and prove its claims again.

    Parameters
    ----------
    progress
        Told which part of the work is done, from 0 to 1; what it raises stops it.

    Returns
    -------
    Certificate or Row
        Its claims hold.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it is no certificate, was changed, or claims what it does not prove.
    """
    found = read_any(text_of(path))
    if isinstance(found, Row):
        return check_row(found, progress=progress)
    check(found, progress=progress)
    return found
