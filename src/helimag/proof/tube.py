"""A tube around a closed curve that is shown, by enclosures, to draw in all that moves in it: the heart of a proof.

Around a curve c(s), s in turns, the deviations z of six coordinates obey z' = f(z, s). A frame Q(s) of six columns
gives coordinates y with z = Q y, in which y' = F(y, s) = W (f(Q y, s) - Q' y), W the inverse of Q. The columns form
blocks of one or two, and a tube is where the length of each block's part of y is at most the block's radius. For every
span of time the enclosures give bounds of g = F(0, s), of G = D F(0, s), by series in time with Taylor's remainder,
and of the second derivatives of F over the whole region in question. What follows from these numbers
is said in :mod:`helimag.proof.theorem`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from helimag.proof.balls import arithmetic, around_zero, exact, flint, root_of_squares, size
from helimag.proof.jets import Jet, Value, variables
from helimag.proof.waves import Waves, basis

if TYPE_CHECKING:
    from flint import arb, arb_mat

N = 6
SWELL = 1.1


class Dynamics(Protocol):
    """Rates of six deviations from a curve: see :class:`helimag.proof.motion.Swimming`."""

    @property
    def components(self) -> int:
        """How many numbers make up a point of the curve."""

    @property
    def plain(self) -> bool:
        """Whether the inputs are taken as they are, without derivatives by them."""

    def rates(
        self, clock: tuple[Value, Value], curve: Sequence[Value], slope: Sequence[Value], deviation: Sequence[Jet]
    ) -> list[Jet]:
        """The rates, in a turn."""


NO_LEAN = Waves(np.zeros((0, 1)), np.zeros((0, 1)))


@dataclass(frozen=True)
class Tube:
    """What is checked: curve and frame, blocks of the frame's columns and their radii, and how time is cut.

    Attributes
    ----------
    waves
        The curve's components, then the frame's columns one after another.
    blocks
        First column of each block.
    radii
        Of the tube, by block, in the frame's coordinates.
    entry
        Radii of a wider region, from which all comes into the tube; at least those of the tube.
    decay, swing
        By block: the linearised motion is near ``decay + i swing`` in a turn (only used to enclose multipliers).
    odd
        By block: whether its columns come back with the other sign after a turn.
    lean
        Derivatives of the curve's components by each input that has a tolerance, one input after another, over its half
        width: with the inputs, the curve leans to where the orbit then is. No functions where no input has a tolerance.
    spans, order, fine, coarse
        Spans of equal time in a turn; coefficients of the series in each: for G, for g and for second derivatives.
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
    lean: Waves = NO_LEAN

    @property
    def columns(self) -> list[range]:
        """The columns of each block."""
        return [range(a, b) for a, b in pairwise((*self.blocks, N))]

    @property
    def region(self) -> tuple[float, ...]:
        """Radii over which second derivatives are enclosed: a little wider than the entry, where motion may swell."""
        return tuple(SWELL * max(pair) for pair in zip(self.entry, self.radii, strict=True))


@dataclass(frozen=True)
class Straight:
    """What holds on the curve over a span: ``push`` bounds g by block, ``linear`` encloses G (6, 6).

    ``curve`` and ``frame`` enclose the curve's components and the frame (6, 6).
    """

    push: "list[arb]"
    linear: "list[list[arb]]"
    curve: "list[arb]"
    frame: Any


@dataclass(frozen=True)
class Span:
    """Upper bounds that hold over a span of time, by block.

    Attributes
    ----------
    push
        Length of g.
    rate
        Greatest eigenvalue of the symmetric part of G's diagonal block.
    change
        Norm of what G's diagonal block differs from the constant one.
    mixed
        Norms of G's blocks off the diagonal, zero on it.
    bend
        [I][J][K]: norm of the change of block I, J of D F along block K, over its length, anywhere in the region.
    twist
        [I][K]: the same of the symmetric part of the diagonal block I.
    straight
        What they were made of.
    """

    push: "list[arb]"
    rate: "list[arb]"
    change: "list[arb]"
    mixed: "list[list[arb]]"
    bend: "list[list[list[arb]]]"
    twist: "list[list[arb]]"
    straight: Straight


@dataclass(frozen=True)
class Views:
    """The same equations at the inputs' middle, there with derivatives by the inputs, and over all their values."""

    middle: Dynamics
    leaning: Dynamics
    over: Dynamics


def views_of(dynamics: Dynamics) -> Views:
    """Of equations whose inputs have no tolerance."""
    return Views(dynamics, dynamics, dynamics)


def straights_of(views: Views, tube: Tube) -> "list[Straight]":
    """What holds on the curve, for every span of a turn; within :func:`helimag.proof.balls.arithmetic`."""
    return [_straight(views, tube, k) for k in range(tube.spans)]


def spans_of(views: Views, tube: Tube, straights: "Sequence[Straight]") -> list[Span]:
    """The bounds of every span of a turn, in order; within :func:`helimag.proof.balls.arithmetic`."""
    return [_span(views.over, tube, k, straight) for k, straight in enumerate(straights)]


def _time(tube: Tube, k: int) -> "tuple[arb, arb]":
    """Middle and half length of a span."""
    return exact(2 * k + 1) / (2 * tube.spans), exact(1) / (2 * tube.spans)


def _straight(views: Views, tube: Tube, k: int) -> Straight:
    middle, half = _time(tube, k)
    wide = flint().arb(middle, half)
    linear = _over_span(
        _linear(views.middle, tube, middle, tube.order), _linear(views.middle, tube, wide, tube.order + 1), half
    )
    off = _over_span(_off(views.leaning, tube, middle, tube.fine), _off(views.leaning, tube, wide, tube.fine + 1), half)
    # each input's variable is at most one
    push = [
        size(sum((root_of_squares(off[i][j] for i in rows) for j in range(len(off[0]))), exact(0)))
        for rows in tube.columns
    ]
    components = views.middle.components
    curve, frame = _curve_and_frame(components, tube.waves.matrix * basis(tube.waves.cos.shape[1], wide, 1))
    return Straight(
        push, linear, [p[0] + lean for p, lean in zip(curve, leans(tube, components, wide), strict=True)], frame[0]
    )


def leans(tube: Tube, components: int, at: "arb") -> "list[arb]":
    """Balls of how far the curve's components lean, at all values of the inputs, at every time of a ball."""
    total = [exact(0)] * components
    if len(tube.lean.cos):
        series = tube.lean.matrix * basis(tube.lean.cos.shape[1], at, 1)
        for i in range(len(tube.lean.cos)):
            total[i % components] += around_zero(series[i, 0])
    return total


def _span(dynamics: Dynamics, tube: Tube, k: int, straight: Straight) -> Span:
    middle, half = _time(tube, k)
    wide = flint().arb(middle, half)
    second = _over_span(
        _bends(dynamics, tube, middle, tube.coarse, wide), _bends(dynamics, tube, wide, tube.coarse + 1, wide), half
    )
    blocks, linear, count = tube.columns, straight.linear, range(len(tube.blocks))
    inputs = len(tube.lean.cos) // dynamics.components
    leaning, length = range(N, N + inputs), exact(inputs).sqrt()  # of the inputs' variables, none above one
    own = [
        root_of_squares(linear[i][j] - _constant(tube, b, i - rows[0], j - rows[0]) for i in rows for j in rows)
        for b, rows in enumerate(blocks)
    ]
    return Span(
        push=[
            straight.push[b] + _norm(second, rows, leaning, leaning) * length * length / 2
            for b, rows in enumerate(blocks)
        ],
        rate=[
            (_logarithmic_norm(linear, rows) + _symmetric_norm(second, rows, leaning) * length).upper()
            for rows in blocks
        ],
        change=[own[b] + _norm(second, rows, rows, leaning) * length for b, rows in enumerate(blocks)],
        mixed=[
            [
                exact(0)
                if rows is columns
                else root_of_squares(linear[i][j] for i in rows for j in columns)
                + _norm(second, rows, columns, leaning) * length
                for columns in blocks
            ]
            for rows in blocks
        ],
        bend=[[[_norm(second, blocks[i], blocks[j], blocks[m]) for m in count] for j in count] for i in count],
        twist=[[_symmetric_norm(second, blocks[i], blocks[m]) for m in count] for i in count],
        straight=straight,
    )


def _side(second: "list[list[arb]]") -> int:
    """Coordinates and inputs together, by which second derivatives are taken."""
    return math.isqrt(len(second[0]))


def _norm(second: "list[list[arb]]", rows: range, columns: range, along: range) -> "arb":
    """Bound of the norm of second derivatives as a map from two blocks to a third."""
    side = _side(second)
    return root_of_squares(second[i][side * j + k] for i in rows for j in columns for k in along)


def _symmetric_norm(second: "list[list[arb]]", rows: range, along: range) -> "arb":
    """The same for the symmetric part of a diagonal block."""
    side = _side(second)
    pairs = ((i, j, k) for i in rows for j in rows for k in along)
    return root_of_squares((second[i][side * j + k] + second[j][side * i + k]) / 2 for i, j, k in pairs)


def frame_at(motion: Dynamics, tube: Tube, at: "arb") -> "arb_mat":
    """The frame's columns at a time."""
    _, frame = _curve_and_frame(motion.components, tube.waves.matrix * basis(tube.waves.cos.shape[1], at, 1))
    return frame[0]


def _curve_and_frame(components: int, coefficients: "arb_mat") -> "tuple[list[list[arb]], list[arb_mat]]":
    """Taylor coefficients of the curve's components, and of the frame as matrices, from those of all functions."""
    library, order = flint(), coefficients.ncols()
    curve = [[coefficients[i, n] for n in range(order)] for i in range(components)]
    frame = [
        library.arb_mat([[coefficients[components + N * j + i, n] for j in range(N)] for i in range(N)])
        for n in range(order)
    ]
    return curve, frame


def _linear(dynamics: Dynamics, tube: Tube, at: "arb", order: int) -> "list[arb_mat]":
    """Taylor coefficients in time of G (6, 6), around every time of a ball."""
    library = flint()
    rates, frame = _rates(dynamics, tube, at, order, first=True)
    field = [
        library.arb_mat([[_coefficient(rate.g.get(j), n) for j in range(N)] for rate in rates]) for n in range(order)
    ]
    moved = _convolved(field, frame, order)
    return _unturned(frame, [moved[n] - (n + 1) * frame[n + 1] for n in range(order)], order)


def _off(dynamics: Dynamics, tube: Tube, at: "arb", order: int) -> "list[arb_mat]":
    """The same of g and its derivatives by the inputs (6, 1 + inputs)."""
    library = flint()
    rates, frame = _rates(dynamics, tube, at, order, first=False)
    inputs = range(N, N + len(tube.lean.cos) // dynamics.components)
    field = [
        library.arb_mat(
            [[_coefficient(rate.v, n), *(_coefficient(rate.g.get(j), n) for j in inputs)] for rate in rates]
        )
        for n in range(order)
    ]
    return _unturned(frame, field, order)


def _rates(
    dynamics: Dynamics, tube: Tube, at: "arb", order: int, *, first: bool, reach: "list[arb] | None" = None
) -> "tuple[list[Jet], list[arb_mat]]":
    """Series of the rates around every time of a ball, on the curve or anywhere in reach of it; and the frame's.

    With ``first`` derivatives by the deviations are kept, with a reach second ones too.
    """
    library = flint()
    # one coefficient more, for the slopes
    turns = basis(3, at, order + 1)
    curve, frame = _curve_and_frame(
        dynamics.components, tube.waves.matrix * basis(tube.waves.cos.shape[1], at, order + 1)
    )
    with arithmetic(library.ctx.prec, order):
        series = library.arb_series
        clock = tuple(series([turns[row, n] for n in range(order)]) for row in (2, 5))
        lean = [] if dynamics.plain else _leaning(dynamics, tube, at, order + 1)
        point = _curve_jets([part[:order] for part in curve], [[p[:order] for p in each] for each in lean], reach)
        slope = _curve_jets(_slopes(curve), [_slopes(each) for each in lean], reach)
        if first:
            balls = [series([0])] * N if reach is None else [series([ball]) for ball in reach]
            deviation = variables(balls, second=reach is not None, one=series([1]))
        else:
            deviation = [Jet(series([0]))] * N
        return dynamics.rates((clock[0], clock[1]), point, slope, deviation), frame


def _slopes(parts: "list[list[arb]]") -> "list[list[arb]]":
    return [[n * part[n] for n in range(1, len(part))] for part in parts]


def _leaning(dynamics: Dynamics, tube: Tube, at: "arb", order: int) -> "list[list[list[arb]]]":
    """Taylor coefficients of the curve's derivatives by each input."""
    count = dynamics.components
    if not len(tube.lean.cos):
        return []
    series = tube.lean.matrix * basis(tube.lean.cos.shape[1], at, order)
    rows = [[series[i, n] for n in range(order)] for i in range(len(tube.lean.cos))]
    return [rows[i : i + count] for i in range(0, len(rows), count)]


def _curve_jets(parts: "list[list[arb]]", lean: "list[list[list[arb]]]", reach: object) -> list[Value]:
    """Series of the curve's components; with inputs, jets in their variables, over all their values where in reach."""
    series, result = flint().arb_series, []
    for i, part in enumerate(parts):
        value = series(part)
        if lean:
            by = {N + j: series(each[i]) for j, each in enumerate(lean)}
            if reach is None:
                result.append(Jet(value, by))
                continue
            value = sum((each * series([flint().arb(0, 1)]) for each in by.values()), value)
            result.append(Jet(value, by, {}))
        else:
            result.append(value)
    return result


def _coefficient(series: Any, n: int) -> "arb":
    if series is None:
        return flint().arb(0)
    if isinstance(series, flint().arb):  # what does not depend on time
        return series if n == 0 else flint().arb(0)
    return series[n]


def _unturned(frame: "list[arb_mat]", turned: "list[arb_mat]", order: int) -> "list[arb_mat]":
    """The frame's inverse times what is given, as Taylor coefficients: Q X = Y solved order by order."""
    inverse = frame[0].inv()
    result: list[Any] = []
    for n in range(order):
        rest = turned[n]
        for k in range(1, n + 1):
            rest = rest - frame[k] * result[n - k]
        result.append(inverse * rest)
    return result


def _over_span(thin: "list[arb_mat]", wide: "list[arb_mat]", half: "arb") -> "list[list[arb]]":
    """Enclosures (6, columns) over a span by Taylor's theorem: coefficients at its middle, the last one over all."""
    order = len(thin)
    result = []
    for i in range(N):
        row = []
        for j in range(thin[0].ncols()):
            value, power = thin[0][i, j], half
            for n in range(1, order):
                value = value + around_zero(thin[n][i, j] * power)
                power = power * half
            row.append(value + around_zero(wide[order][i, j] * power))
        result.append(row)
    return result


def _bends(dynamics: Dynamics, tube: Tube, at: "arb", order: int, span: "arb") -> "list[arb_mat]":
    """Taylor coefficients in time of second derivatives of F by y and the inputs, enclosed over region and inputs.

    A row of (6 + inputs) squared for each of the six components. The region is that of the whole span around the time,
    as the deviation is held while time is expanded.
    """
    library = flint()
    over = frame_at(dynamics, tube, span)
    rates, frame = _rates(dynamics, tube, at, order, first=True, reach=deviations(tube, over, tube.region))
    side = N + len(tube.lean.cos) // dynamics.components
    right = [_extended(part, side, int(n == 0)) for n, part in enumerate(frame)]
    left = [part.transpose() for part in right]
    turned: list[list[arb_mat]] = []
    for rate in rates:
        second = rate.h or {}
        pure = [
            library.arb_mat(
                [[_coefficient(second.get((min(j, k), max(j, k))), n) for k in range(side)] for j in range(side)]
            )
            for n in range(order)
        ]
        turned.append(_convolved(left, _convolved(pure, right, order), order))
    rows = [
        library.arb_mat([[turned[i][n][j, k] for j in range(side) for k in range(side)] for i in range(N)])
        for n in range(order)
    ]
    return _unturned(frame, rows, order)


def _extended(frame: "arb_mat", side: int, one: int) -> "arb_mat":
    """The frame with the inputs as they are beside it."""
    return flint().arb_mat(
        [[frame[i, j] if i < N and j < N else exact(one if i == j else 0) for j in range(side)] for i in range(side)]
    )


def _convolved(a: "list[arb_mat]", b: "list[arb_mat]", order: int) -> "list[arb_mat]":
    """Taylor coefficients of a product of matrices."""
    result = []
    for n in range(order):
        total = a[0] * b[n]
        for k in range(1, n + 1):
            total = total + a[k] * b[n - k]
        result.append(total)
    return result


def deviations(tube: Tube, frame: "arb_mat", radii: "Sequence[float | arb]") -> "list[arb]":
    """Balls that hold the six deviations of everything within radii by block, the frame being so."""
    result = []
    for i in range(N):
        reach = exact(0)
        for columns, radius in zip(tube.columns, radii, strict=True):
            reach += root_of_squares(frame[i, j] for j in columns) * radius
        result.append(around_zero(reach))
    return result


def _logarithmic_norm(linear: "list[list[arb]]", columns: range) -> "arb":
    """Greatest eigenvalue of the symmetric part of a diagonal block: an upper bound."""
    i, j = columns[0], columns[-1]
    if i == j:
        return linear[i][i].upper()
    mean, half = (linear[i][i] + linear[j][j]) / 2, (linear[i][i] - linear[j][j]) / 2
    return (mean + root_of_squares([half, (linear[i][j] + linear[j][i]) / 2])).upper()


def _constant(tube: Tube, block: int, row: int, column: int) -> "arb":
    """Entry of the constant block [[a, b], [-b, a]] that a diagonal block is near."""
    if row == column:
        return exact(tube.decay[block])
    return exact(tube.swing[block] if row < column else -tube.swing[block])
