"""A box of inputs made longer, cell by cell: each is a proof of its own, its guess taken over from its neighbour."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from time import perf_counter as now

import numpy as np

from helimag.errors import InputError
from helimag.orbits import Watch
from helimag.proof.balls import arithmetic
from helimag.proof.bending import bent_waves
from helimag.proof.bounds import Report, silent
from helimag.proof.certificate import Certificate
from helimag.proof.exact import Inputs, parts, written
from helimag.proof.guess import guess_around
from helimag.proof.motion import LENGTH, Swimming
from helimag.proof.proving import in_floats
from helimag.proof.row import Row, interval
from helimag.proof.tolerance import leaning_over, proved_within, rooms, rounded
from helimag.proof.tube import Tube
from helimag.scenario import Scenario

SHARES = (1.0, 0.8, 0.6)  # of the neighbour's width along the row
LAPPED = Fraction(999, 1000)  # of the distance at which two cells touch: they overlap by the rest
DIGITS = 12


def grown(
    cell: Certificate,
    along: str,
    *,
    seconds: float,
    progress: Report = silent,
    keep: Callable[[Row], None] = lambda _: None,
) -> Row:
    """A row of boxes around one, along an input, as long as can be proved in a time: to either side in turn.

    Parameters
    ----------
    cell
        The certificate of a box of inputs, as :func:`helimag.proof.tolerated` gives it.
    along
        One of its inputs.
    seconds
        Time to take, about: after the first, no cell is begun that would end later by more than half of itself.
    progress
        Told which part of the time is over, from 0 to 1; what it raises stops the work.
    keep
        Given what is proved so far, each time that there is more.

    Returns
    -------
    Row
        Of one cell where no time was left for another.

    Raises
    ------
    InputError
        Where the certificate is of no box, or the input is not one of its.
    """
    if along not in cell.within:
        raise InputError(f"a row of boxes must be along one of {', '.join(cell.within) or 'its inputs'}; got '{along}'")
    begun, row, watch = now(), Row(along, (cell,)), Watch(progress)
    open_ends, longest = [1, -1], 0.0
    while open_ends and now() - begun + longest / 2.0 < seconds:
        side, started = open_ends.pop(0), now()
        done = (started - begun) / seconds
        share = (longest or seconds / 10.0) / seconds

        def told(part: float, done: float = done, share: float = share) -> None:
            watch(done + part * share)

        found = _beside(row.cells[-1 if side > 0 else 0], along, side, told)
        if found is not None:
            row = Row(along, (*row.cells, found) if side > 0 else (found, *row.cells))
            keep(row)
            open_ends.append(side)
        longest = max(longest, now() - started)
    return row


def _beside(cell: Certificate, along: str, side: int, progress: Report) -> Certificate | None:
    """The proof of a box that touches another on a side; None where there is none that long as is tried."""
    for share in SHARES:
        widths = dict(cell.within) | {along: f"{share * float(cell.within[along]):.4e}"}
        scenario = _moved(cell, along, side, Fraction(widths[along]))
        tube = _tube_around(scenario, cell.tube, widths)
        found = None if tube is None else proved_within(scenario, widths, tube, progress)
        if found is not None:
            return found
    return None


def _moved(cell: Certificate, along: str, side: int, width: Fraction) -> Scenario:
    """The scenario of a cell of this half width whose interval begins just before another's ends."""
    _, unit = parts(written(cell.scenario, along))
    low, high = interval(cell, along)
    middle = (high + width * LAPPED) if side > 0 else (low - width * LAPPED)
    return cell.scenario.replaced({along: f"{float(middle):.{DIGITS}g} {unit}".strip()})


def _tube_around(scenario: Scenario, like: Tube, widths: dict[str, str]) -> Tube | None:
    """A tube of the same radii around the orbit near another curve, with leaning and second-order terms of its own."""
    with arithmetic():
        floats = Swimming(in_floats(Inputs(scenario).constants()))
    begin = like.waves.values(np.zeros(1))[: Swimming.components, 0]
    guess = guess_around(floats, np.concatenate([begin[:3] * float(LENGTH), begin[3:]]))
    if isinstance(guess, str) or guess.blocks != like.blocks:
        return None
    tube = replace(like, waves=guess.waves, decay=guess.decay, swing=guess.swing, odd=guess.odd)
    given = leaning_over(scenario, tube, {path: Fraction(width) for path, width in widths.items()})
    _, bent, signs = max(
        (
            (room.scaled(np.ones(len(widths)), np.array(tube.radii)), bent, signs)
            for room, bent, signs in rooms(tube, given)
        ),
        key=lambda each: each[0],
    )
    return replace(tube, lean=rounded(given.lean), bent=bent_waves(bent, signs))
