"""What is checked: a tube around a closed curve, in coordinates in which the motion in it is as simple as can be.

Around a curve c(s), s in turns, deviations z of six coordinates obey z' = f(z, s). Six columns Q(s) and symmetric
second-order terms K(s) give coordinates y with z = Q y + K[X, X] / 2, where X are y and, where inputs have a tolerance,
their variables u from -1 to 1. The columns form blocks of one or two, and the tube is where the length of each block's
part of y is at most the block's radius. K takes out of the motion what swings within a turn, to second order.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, pairwise
from typing import TYPE_CHECKING

import numpy as np

from helimag.proof.balls import around_zero, exact, flint, root_of_squares
from helimag.proof.jets import Jet, Pair, Triple
from helimag.proof.waves import Waves

if TYPE_CHECKING:
    from flint import arb, arb_mat

N = 6
SWELL = 1.1
OUTER = 2.0  # times the tube: how wide the box is that all of shrinks into it
NONE = Waves(np.zeros((0, 1)), np.zeros((0, 1)))


@dataclass(frozen=True)
class Tube:
    """Curve and coordinates, blocks and their radii, and how time is cut.

    Attributes
    ----------
    waves
        The curve's components, then the frame's columns one after another.
    blocks
        First column of each block.
    radii
        Of the tube, by block, in the frame's coordinates.
    entry
        Radii from which all comes into the tube. Those of the tube where no more than it is claimed: so it is where
        inputs have a tolerance.
    decay, swing
        By block: the linearised motion is near ``decay + i swing`` in a turn (only used to enclose multipliers).
    odd
        By block: whether its columns come back with the other sign after a turn.
    lean
        Derivatives of the curve's components by each input that has a tolerance, one input after another, over its half
        width: with the inputs, the curve leans to where the orbit then is. No functions where no input has a tolerance.
    bent
        Second-order terms: six functions for each pair of columns and inputs in order, (0, 0), (0, 1) and so on. No
        functions where there are no such terms.
    spans, order, fine, coarse, rough
        Spans of equal time in a turn; coefficients of the series in each: of the linearised motion, of what moves on
        the curve, and of second derivatives; and in how many parts each is cut for third ones.
    """

    waves: Waves
    blocks: tuple[int, ...]
    radii: tuple[float, ...]
    entry: tuple[float, ...]
    decay: tuple[float, ...]
    swing: tuple[float, ...]
    odd: tuple[bool, ...]
    spans: int
    order: int
    fine: int
    coarse: int
    rough: int
    lean: Waves = NONE
    bent: Waves = NONE

    @property
    def columns(self) -> list[range]:
        """The columns of each block."""
        return [range(a, b) for a, b in pairwise((*self.blocks, N))]

    @property
    def reaches_out(self) -> bool:
        """Whether more starts are hoped for than those in the tube."""
        return self.entry != self.radii

    @property
    def outer(self) -> tuple[float, ...]:
        """Radii of the box that all of is to shrink into the tube, fast blocks no wider than the slow ones stir up."""
        return tuple(OUTER * radius for radius in self.radii) if self.reaches_out else self.radii

    @property
    def region(self) -> tuple[float, ...]:
        """Radii that no motion leaves: a little wider than the entry, where motion may swell."""
        return tuple(SWELL * max(pair) for pair in zip(self.entry, self.outer, strict=True))

    @property
    def cuts(self) -> tuple[int, ...]:
        """How time is cut."""
        return self.spans, self.order, self.fine, self.coarse, self.rough

    def parts(self, inputs: int) -> list[range]:
        """The columns of each block, then each input's variable by itself."""
        return [*self.columns, *(range(N + j, N + j + 1) for j in range(inputs))]


def pairs(side: int) -> list[Pair]:
    """Pairs of columns and inputs, in the order in which a tube's second-order terms stand."""
    return list(combinations_with_replacement(range(side), 2))


def triples(side: int) -> list[Triple]:
    """Triples of them."""
    return list(combinations_with_replacement(range(side), 3))


@dataclass(frozen=True)
class Chart:
    """The coordinates at a time, or over a span: ``frame`` (6, 6), and ``bent`` (6,) by pair; or their rates."""

    frame: "list[list[arb]]"
    bent: "list[dict[Pair, arb]]"

    def bend(self, i: int, a: int, b: int) -> "arb":
        """Second-order term of a component by two variables."""
        return self.bent[i].get((a, b) if a <= b else (b, a), exact(0))

    def terms(self, side: int) -> "arb_mat":
        """All second-order terms (6, pairs)."""
        return flint().arb_mat([[row.get(pair, exact(0)) for pair in pairs(side)] for row in self.bent])


def charts_at(tube: Tube, components: int, inputs: int, at: "arb", order: int) -> list[Chart]:
    """Taylor coefficients of the coordinates around every time of a ball."""
    waves = tube.waves.series(at, order)
    bent = tube.bent.series(at, order) if tube.bent.count else None
    by_pair = list(enumerate(pairs(N + inputs)))
    return [
        Chart(
            [[waves[components + N * j + i, n] for j in range(N)] for i in range(N)],
            [{} if bent is None else {pair: bent[N * p + i, n] for p, pair in by_pair} for i in range(N)],
        )
        for n in range(order)
    ]


def chart_at(tube: Tube, components: int, inputs: int, at: "arb") -> Chart:
    """The coordinates at every time of a ball."""
    return charts_at(tube, components, inputs, at, 1)[0]


def deviations(chart: Chart, parts: Sequence[range], radii: "Sequence[float | arb]") -> "list[arb]":
    """Balls that hold the six deviations of everything whose coordinates have no greater lengths than these by part."""
    return [
        around_zero(
            sum((root_of_squares(_first(chart, i, part)) * r for part, r in zip(parts, radii, strict=True)), exact(0))
            + second_order(chart.bent[i], parts, radii)
        )
        for i in range(N)
    ]


def reached(tube: Tube, chart: Chart, radii: "Sequence[float | arb]") -> "list[arb]":
    """The same within radii by block, for all values of the inputs."""
    inputs = side_of(tube) - N
    return deviations(chart, tube.parts(inputs), [*radii, *[exact(1)] * inputs])


def side_of(tube: Tube) -> int:
    """How many coordinates and inputs there are that the second-order terms are of."""
    if not tube.bent.count:
        return N
    return (math.isqrt(8 * (tube.bent.count // N) + 1) - 1) // 2


def second_order(bent: "dict[Pair, arb]", parts: Sequence[range], radii: "Sequence[float | arb]") -> "arb":
    """Bound of half a quadratic form, the lengths of its variables being no greater than these by part."""
    total = exact(0)
    for m, (one, r) in enumerate(zip(parts, radii, strict=True)):
        for n in range(m, len(parts)):
            terms = [bent[a, b] for a in one for b in parts[n] if a <= b and (a, b) in bent]
            # off the diagonal a pair stands twice in the form: within a block it does so in its length too
            terms += [bent[a, b] for a in one for b in parts[n] if m == n and a < b and (a, b) in bent]
            if terms:
                total += root_of_squares(terms) * r * radii[n] / (2 if m == n else 1)
    return total


def _first(chart: Chart, i: int, part: range) -> "list[arb]":
    return [chart.frame[i][a] for a in part if a < N]


def deviation_jets(chart: Chart, parts: Sequence[range], radii: "Sequence[float | arb]") -> list[Jet]:
    """The six deviations as functions of all variables, over everything within radii by part."""
    values, result = deviations(chart, parts, radii), []
    for i in range(N):
        first = {}
        for a in range(parts[-1].stop):
            away = sum(
                (root_of_squares(chart.bend(i, a, b) for b in part) * r for part, r in zip(parts, radii, strict=True)),
                exact(0),
            )
            first[a] = (chart.frame[i][a] if a < N else exact(0)) + around_zero(away)
        result.append(Jet(values[i], first, dict(chart.bent[i])))
    return result
