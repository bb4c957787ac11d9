"""A tube around a closed curve that is shown, by enclosures, to draw in all that moves in it: the heart of a proof.

Around a curve c(s), s in turns, the deviations z of six coordinates obey z' = f(z, s). A frame Q(s) of six columns
gives coordinates y with z = Q y, in which y' = F(y, s) = W (f(Q y, s) - Q' y), W the inverse of Q. The columns form
blocks of one or two, and the tube is where the length of each block's part of y is at most its radius. For every span
of time the enclosures give, with g = F(0, s), G = D F(0, s) and the second derivatives of F over the whole tube,

- ``push``: how long g's part of each block may be,
- ``rate``: an upper bound of how fast the greatest share of a radius grows, over all linearisations in the tube: the
  logarithmic norm in the norm max |y_I| / radius_I, by blocks: that of the diagonal block plus the norms of the others.

What follows from these numbers is said in :mod:`helimag.proof.theorem`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

from helimag.proof.balls import arithmetic, around_zero, exact, flint, largest, root_of_squares, size
from helimag.proof.jets import Jet, Value, variables
from helimag.proof.waves import Waves, basis

if TYPE_CHECKING:
    from flint import arb, arb_mat

N = 6


class Dynamics(Protocol):
    """Rates of six deviations from a curve: see :class:`helimag.proof.motion.Swimming`."""

    @property
    def components(self) -> int:
        """How many numbers make up a point of the curve."""

    def rates(
        self, clock: tuple[Value, Value], curve: Sequence[Value], slope: Sequence[Value], deviation: Sequence[Jet]
    ) -> list[Jet]:
        """The rates, in a turn."""


@dataclass(frozen=True)
class Tube:
    """What is checked: curve and frame, blocks of the frame's columns and their radii, and how time is cut.

    Attributes
    ----------
    waves
        The curve's components, then the frame's columns one after another.
    blocks
        First column of each block, and the number of columns.
    radii
        Of the tube, by block, in the frame's coordinates.
    decay, swing
        By block: the linearised motion is near ``decay + i swing`` in a turn (only used to enclose multipliers).
    odd
        By block: whether its columns come back with the other sign after a turn.
    spans, order, fine, cuts
        Spans of equal time in a turn, coefficients of the series in each for G and for g, and its parts for second
        derivatives.
    """

    waves: Waves
    blocks: tuple[int, ...]
    radii: tuple[float, ...]
    decay: tuple[float, ...]
    swing: tuple[float, ...]
    odd: tuple[bool, ...]
    spans: int
    order: int
    fine: int
    cuts: int

    @property
    def slices(self) -> list[slice]:
        """The columns of each block."""
        return [slice(a, b) for a, b in pairwise((*self.blocks, N))]


@dataclass(frozen=True)
class Span:
    """What holds over a span of time, all as upper bounds by block.

    Attributes
    ----------
    push
        Length of g.
    rate, change
        Over the tube: logarithmic norm, and the norm of what the linearisation differs from the constant one.
    still_rate, still_change
        The same on the curve itself.
    curve, frame
        Enclosures of the curve's components, and of the frame (6, 6).
    """

    push: "list[arb]"
    rate: "list[arb]"
    change: "list[arb]"
    still_rate: "list[arb]"
    still_change: "list[arb]"
    curve: "list[arb]"
    frame: Any


def spans_of(motion: Dynamics, tube: Tube) -> Iterator[Span]:
    """The bounds of every span of a turn, in order; within :func:`helimag.proof.balls.arithmetic`."""
    matrix = tube.waves.matrix()
    for k in range(tube.spans):
        yield _span(motion, tube, matrix, k)


def _span(motion: Dynamics, tube: Tube, matrix: "arb_mat", k: int) -> Span:
    middle, half = exact(2 * k + 1) / (2 * tube.spans), exact(1) / (2 * tube.spans)
    library = flint()
    wide = library.arb(middle, half)
    linear, off = (
        _over_span(
            _series(motion, tube, matrix, middle, order, columns),
            _series(motion, tube, matrix, wide, order + 1, columns),
            half,
        )
        for order, columns in ((tube.order, N), (tube.fine, 0))
    )
    bends = [
        _bends(motion, tube, matrix, library.arb(middle + half * (2 * c + 1 - tube.cuts) / tube.cuts, half / tube.cuts))
        for c in range(tube.cuts)
    ]
    bend = [
        [[largest(each[i][j][b] for each in bends) for b in range(len(tube.radii))] for j in range(N)] for i in range(N)
    ]
    curve, frame = _curve_and_frame(motion.components, matrix * basis(tube.waves.cos.shape[1], wide, 1))
    still = _row_bounds(tube, linear, [[library.arb(0)] * N] * N)
    moved = _row_bounds(tube, linear, [[size(sum(bend[i][j], library.arb(0))) for j in range(N)] for i in range(N)])
    push = [root_of_squares(off[i][0] for i in range(*rows.indices(N))) for rows in tube.slices]
    return Span(push, *moved, *still, [part[0] for part in curve], frame[0])


def frame_at(motion: Dynamics, tube: Tube, at: "arb") -> "arb_mat":
    """The frame's columns at a time."""
    _, frame = _curve_and_frame(motion.components, tube.waves.matrix() * basis(tube.waves.cos.shape[1], at, 1))
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


def _series(motion: Dynamics, tube: Tube, matrix: "arb_mat", at: "arb", order: int, columns: int) -> "list[arb_mat]":
    """Taylor coefficients in time, around every time of a ball: of G (6, 6), or of g (6, 1) for no ``columns``."""
    library = flint()
    # one coefficient more, for the slopes
    curve, frame = _curve_and_frame(motion.components, matrix * basis(tube.waves.cos.shape[1], at, order + 1))
    turns = basis(3, at, order)
    with arithmetic(library.ctx.prec, order):
        series = library.arb_series
        point = [series(part[:order]) for part in curve]
        slope = [series([n * part[n] for n in range(1, order + 1)]) for part in curve]
        clock = tuple(series([turns[row, n] for n in range(order)]) for row in (2, 5))
        still = variables([series([0])] * N, one=series([1])) if columns else [Jet(series([0]))] * N
        rates = motion.rates((clock[0], clock[1]), point, slope, still)
    if not columns:
        field = [library.arb_mat([[rate.v[n]] for rate in rates]) for n in range(order)]
        return _unturned(frame, field, order)
    field = [
        library.arb_mat([[_coefficient(rate.g.get(j), n) for j in range(N)] for rate in rates]) for n in range(order)
    ]
    turned = []
    for n in range(order):
        total = -((n + 1) * frame[n + 1])
        for k in range(n + 1):
            total = total + field[k] * frame[n - k]
        turned.append(total)
    return _unturned(frame, turned, order)


def _coefficient(series: Any, n: int) -> "arb":
    return flint().arb(0) if series is None else series[n]


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


def _bends(motion: Dynamics, tube: Tube, matrix: "arb_mat", at: "arb") -> "list[list[list[arb]]]":
    """Bounds (6, 6, blocks) of what second derivatives of F, times the tube's radii, add to D F anywhere in the tube.

    Entry [i][j] is summed with its mirror image within a block, where only the symmetric part counts for the rate.
    """
    library = flint()
    curve, frames = _curve_and_frame(motion.components, matrix * basis(tube.waves.cos.shape[1], at, 2))
    frame, turns = frames[0], basis(3, at, 1)
    radii = [exact(radius) for radius in tube.radii]
    reach = deviations(tube, frame)
    deviation = variables(reach, second=True, one=exact(1))
    point, slope = [part[0] for part in curve], [part[1] for part in curve]
    rates = motion.rates((turns[2, 0], turns[5, 0]), point, slope, deviation)
    across = frame.transpose()
    rows = []
    for rate in rates:
        second = rate.h or {}
        matrix_of = library.arb_mat(
            [[second.get((min(j, k), max(j, k)), exact(0)) for k in range(N)] for j in range(N)]
        )
        bent = across * matrix_of * frame
        rows.append([bent[j, k] for j in range(N) for k in range(N)])
    return _by_block(tube, frame.inv() * library.arb_mat(rows), radii)


def deviations(tube: Tube, frame: "arb_mat", share: float = 1.0) -> "list[arb]":
    """Balls that hold the six deviations of everything within a share of the tube, the frame being so."""
    result = []
    for i in range(N):
        reach = exact(0)
        for columns, radius in zip(tube.slices, tube.radii, strict=True):
            reach += root_of_squares(frame[i, j] for j in range(*columns.indices(N))) * exact(radius)
        result.append(around_zero(reach * exact(share)))
    return result


def _by_block(tube: Tube, second: "arb_mat", radii: "list[arb]") -> "list[list[list[arb]]]":
    """Bounds [i][j][block] of second derivatives (6, 36) in the directions of a block, times its radius."""
    return [
        [
            [
                size(root_of_squares(second[i, N * j + k] for k in range(*s.indices(N))) * r)
                for s, r in zip(tube.slices, radii, strict=True)
            ]
            for j in range(N)
        ]
        for i in range(N)
    ]


def _row_bounds(tube: Tube, linear: "list[list[arb]]", extra: "list[list[arb]]") -> "tuple[list[arb], list[arb]]":
    """Bounds ``rate`` and ``change`` by block, from enclosures of G and bounds of what is added to its entries."""
    radii = [exact(radius) for radius in tube.radii]
    rate, change = [], []
    for b, rows in enumerate(tube.slices):
        columns = range(*rows.indices(N))
        others = exact(0)
        for c, s in enumerate(tube.slices):
            if c != b:
                norm = root_of_squares(size(linear[i][j]) + extra[i][j] for i in columns for j in range(*s.indices(N)))
                others += norm * radii[c] / radii[b]
        rate.append((_logarithmic_norm(linear, extra, list(columns)) + others).upper())
        own = root_of_squares(
            size(linear[i][j] - _constant(tube, b, i - rows.start, j - rows.start)) + extra[i][j]
            for i in columns
            for j in columns
        )
        change.append(size(own + others))
    return rate, change


def _logarithmic_norm(linear: "list[list[arb]]", extra: "list[list[arb]]", columns: list[int]) -> "arb":
    """Greatest eigenvalue of the symmetric part of a diagonal block: an upper bound."""
    if len(columns) == 1:
        (i,) = columns
        return linear[i][i] + extra[i][i]
    i, j = columns
    mean, half = (linear[i][i] + linear[j][j]) / 2, (linear[i][i] - linear[j][j]) / 2
    shear = (linear[i][j] + linear[j][i]) / 2
    skew = (extra[i][j] + extra[j][i]) / 2
    added = root_of_squares([extra[i][i], extra[j][j], skew, skew])
    return mean + root_of_squares([half, shear]) + added


def _constant(tube: Tube, block: int, row: int, column: int) -> "arb":
    """Entry of the constant block [[a, b], [-b, a]] that a diagonal block is near."""
    if row == column:
        return exact(tube.decay[block])
    return exact(tube.swing[block] if row < column else -tube.swing[block])
