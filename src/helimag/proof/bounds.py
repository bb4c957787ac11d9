"""Upper bounds over every span of a turn, by block, of the motion in a tube: from these all conclusions are drawn.

F is known on the curve with two derivatives, by series in time, and its third ones over a box: so is all between, by
Taylor's theorem with the integral's remainder. What follows is said in :mod:`helimag.proof.theorem`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from helimag.proof.balls import around_zero, exact, flint, root_of_squares, size
from helimag.proof.field import (
    Dynamics,
    Views,
    bend_series,
    curve_series,
    inputs_of,
    lean_series,
    linear_series,
    push_series,
)
from helimag.proof.series import over_span
from helimag.proof.thirds import third_over
from helimag.proof.tube import Chart, N, Tube, chart_at, pairs, triples

if TYPE_CHECKING:
    from flint import arb

# D F at X less D F on the curve is F_ab X_b and a mean of F_abc X_b X_c, over these; and so is its mean on the straight
# way from the curve to X, by which F changes there
AT_THE_END, ON_THE_WAY = (1, 2), (2, 6)
CRUDE = 3  # parts of a span for the tube and its outer box to one for the region, where less is asked

Report = Callable[[float], None]  # told which part of the work is done, from 0 to 1; what it raises stops the work


def silent(_: float) -> None:
    """Where nobody asks how far the work has come."""


@dataclass(frozen=True)
class Straight:
    """What holds on the curve over a span, whatever the radii.

    ``push`` encloses F there and its derivatives by the inputs (6, 1 + inputs), ``linear`` those by the coordinates
    (6, 6), ``second`` F_ab (6, pairs). ``curve`` encloses the curve's components, how far it leans included.
    """

    push: "list[list[arb]]"
    linear: "list[list[arb]]"
    second: "list[list[arb]]"
    curve: "list[arb]"
    chart: Chart


@dataclass(frozen=True)
class SpanBounds:
    """Upper bounds that hold over a span of time and for all values of the inputs, by block.

    Attributes
    ----------
    push
        Length of F on the curve.
    rate
        Greatest eigenvalue of the symmetric part of D F's diagonal block there.
    change
        Norm of what that block differs from the constant one.
    mixed
        Norms of D F's blocks off the diagonal there, zero on it.
    bend
        [I][J][K]: norm of the change of block I, J of D F along block K from the curve to anywhere in the tube, or of
        its mean on the way there, over its length.
    twist
        [I][K]: the same of the symmetric part of the diagonal block I.
    """

    push: "list[arb]"
    rate: "list[arb]"
    change: "list[arb]"
    mixed: "list[list[arb]]"
    bend: "list[list[list[arb]]]"
    twist: "list[list[arb]]"


@dataclass(frozen=True)
class Inward:
    """What leads motion into the tube: D F's mean on the way from the curve, in the outer box and the whole region."""

    outer: SpanBounds
    far: SpanBounds


@dataclass(frozen=True)
class Span:
    """What holds over a span: on the curve, in the tube, and beyond it where the tube reaches out."""

    straight: Straight
    near: SpanBounds
    inward: Inward | None


def straights_of(
    views: Views, tube: Tube, numbers: "Sequence[int] | None" = None, progress: Report = silent
) -> "dict[int, Straight]":
    """What holds on the curve, for all spans of a turn or some; within :func:`helimag.proof.balls.arithmetic`."""
    straights = {}
    wanted = range(tube.spans) if numbers is None else numbers
    for n, k in enumerate(wanted):
        progress(n / len(wanted))
        straights[k] = _straight(views, tube, k)
    return straights


def spans_of(views: Views, tube: Tube, straights: "Mapping[int, Straight]", progress: Report = silent) -> list[Span]:
    """The bounds of spans in order, all of a turn or some; within :func:`helimag.proof.balls.arithmetic`."""
    spans = []
    for n, (k, straight) in enumerate(straights.items()):
        progress(n / len(straights))
        spans.append(_span(views, tube, k, straight))
    return spans


def _time(tube: Tube, k: int) -> "tuple[arb, arb]":
    """Middle of a span, and all of it."""
    middle = exact(2 * k + 1) / (2 * tube.spans)
    return middle, flint().arb(middle, exact(1) / (2 * tube.spans))


def _straight(views: Views, tube: Tube, k: int) -> Straight:
    _, wide = _time(tube, k)
    inputs = inputs_of(tube, views.middle)
    chart = chart_at(tube, views.middle.components, inputs, wide)
    push = _enclosed(push_series, views.leaning, tube, k, tube.fine)
    linear = _enclosed(linear_series, views.middle, tube, k, tube.order)
    turned = _turned(chart, [row[0] for row in push], inputs)
    curve = [part[0] for part in curve_series(tube, views.middle, wide, 1)]
    for lean in lean_series(tube, views.middle, wide, 1):
        curve = [value + around_zero(part[0]) for value, part in zip(curve, lean, strict=True)]
    return Straight(
        push=[[row[0], *(v - turned[i][N + j] for j, v in enumerate(row[1:]))] for i, row in enumerate(push)],
        linear=[[value - turned[i][j] for j, value in enumerate(row)] for i, row in enumerate(linear)],
        second=_enclosed(bend_series, views.bending, tube, k, tube.coarse),
        curve=curve,
        chart=chart,
    )


def _enclosed(series: Any, dynamics: Dynamics, tube: Tube, k: int, order: int) -> "list[list[arb]]":
    """What a function gives Taylor coefficients of, over a span."""
    middle, wide = _time(tube, k)
    thin = series(dynamics, tube, middle, order)
    return over_span(thin, series(dynamics, tube, wide, order + 1), exact(1) / (2 * tube.spans))


def _turned(chart: Chart, push: "list[arb]", inputs: int) -> "list[list[arb]]":
    """M^-1 K_a F (6, 6 + inputs): by how much second-order terms change the first derivatives of what moves."""
    library, alone = flint(), range(N + inputs)
    right = library.arb_mat(
        [[sum((chart.bend(i, a, c) * push[c] for c in range(N)), exact(0)) for a in alone] for i in range(N)]
    )
    moved = library.arb_mat(chart.frame).inv() * right
    return [[moved[i, a] for a in alone] for i in range(N)]


def _span(views: Views, tube: Tube, k: int, straight: Straight) -> Span:
    inputs = inputs_of(tube, views.middle)
    parts, free = tube.parts(inputs), [1.0] * inputs
    third = _third(views, tube, k, straight, tube.outer, tube.rough)
    near = _bounds(tube, straight, Derivatives(straight.second, third, parts, [*tube.radii, *free]))
    if not tube.reaches_out:
        return Span(straight, near, None)
    crude = _third(views, tube, k, straight, tube.region, -(-tube.rough // CRUDE))
    outer, far = (
        _bounds(tube, straight, Derivatives(straight.second, each, parts, [*radii, *free], ON_THE_WAY))
        for each, radii in ((third, tube.outer), (crude, tube.region))
    )
    return Span(straight, near, Inward(outer, far))


def _third(
    views: Views, tube: Tube, k: int, straight: Straight, radii: Sequence[float], parts: int
) -> "list[list[arb]]":
    """F_abc over a span, from enclosures over parts of it: each is the tighter the shorter it is."""
    length = exact(1) / (tube.spans * parts)
    found: list[list[arb]] = []
    for part in range(parts):
        middle = exact(2 * (k * parts + part) + 1) * length / 2
        each = third_over(views.over, tube, flint().arb(middle, length / 2), straight.second, radii)
        found = (
            each
            if not found
            else [[a.union(b) for a, b in zip(*rows, strict=True)] for rows in zip(found, each, strict=True)]
        )
    return found


def _bounds(tube: Tube, straight: Straight, form: "Derivatives") -> SpanBounds:
    """The bounds within the radii that the derivatives are used for."""
    blocks, linear, count = tube.columns, straight.linear, len(tube.blocks)
    along = range(len(form.parts))
    bend = [[[form.bend(i, j, m) for m in along] for j in range(count)] for i in range(count)]
    twist = [[form.twist(i, m) for m in along] for i in range(count)]
    leaning = along[count:]  # of the inputs' variables, none of which is above one
    own = [
        root_of_squares(linear[i][j] - _constant(tube, b, i - rows[0], j - rows[0]) for i in rows for j in rows)
        for b, rows in enumerate(blocks)
    ]
    return SpanBounds(
        push=[
            size(
                sum((root_of_squares(straight.push[i][j] for i in rows) for j in range(1 + len(leaning))), exact(0))
                + form.push(b, leaning)
            )
            for b, rows in enumerate(blocks)
        ],
        rate=[
            (_logarithmic_norm(linear, rows) + _total(twist[b][m] for m in leaning)).upper()
            for b, rows in enumerate(blocks)
        ],
        change=[own[b] + _total(bend[b][b][m] for m in leaning) for b in range(count)],
        mixed=[
            [
                exact(0)
                if rows is columns
                else root_of_squares(linear[i][j] for i in rows for j in columns)
                + _total(bend[b][c][m] for m in leaning)
                for c, columns in enumerate(blocks)
            ]
            for b, rows in enumerate(blocks)
        ],
        bend=[[each[:count] for each in row] for row in bend],
        twist=[row[:count] for row in twist],
    )


def _total(values: "Iterable[arb]") -> "arb":
    return sum(values, exact(0))


class Derivatives:
    """Second derivatives of F on the curve (6, pairs) and third ones (6, triples) over a box, within a reach.

    D F at X less D F on the curve is F_ab X_b + F_abc X_b X_c, with F_abc a mean over the way there, weighted by what
    is left of it: half of one in all. Its mean on the way is half of the first and, all in all, a sixth of the second
    (the integral of t, and of t^2 / 2, from 0 to 1); of coordinates alone, as inputs are what they are all the way.
    """

    def __init__(
        self,
        second: "list[list[arb]]",
        third: "list[list[arb]]",
        parts: "list[range]",
        reach: "list[float]",
        over: tuple[int, int] = AT_THE_END,
    ) -> None:
        side = parts[-1].stop
        self._second, self._third, self.parts, self._reach, self._over = second, third, parts, reach, over
        self._pairs = {pair: n for n, pair in enumerate(pairs(side))}
        self._triples = {triple: n for n, triple in enumerate(triples(side))}

    def second(self, i: int, a: int, b: int) -> "arb":
        """Enclosure of F_ab of a component."""
        return self._second[i][self._pairs[(a, b) if a <= b else (b, a)]]

    def third(self, i: int, a: int, b: int, c: int) -> "arb":
        """Enclosure of F_abc of a component."""
        one, two, three = sorted((a, b, c))
        return self._third[i][self._triples[one, two, three]]

    def bend(self, i: int, j: int, m: int) -> "arb":
        """Bound of the norm of the change of block i, j of D F along part m, over its length."""
        rows, columns, along = self.parts[i], self.parts[j], self.parts[m]
        total = root_of_squares(self.second(r, a, b) for r in rows for a in columns for b in along) / self._over[0]
        for part, length in zip(self.parts, self._reach, strict=True):
            norm = root_of_squares(self.third(r, a, b, c) for r in rows for a in columns for b in along for c in part)
            total += norm * length / self._over[1]
        return size(total)

    def twist(self, i: int, m: int) -> "arb":
        """The same of the symmetric part of diagonal block i."""
        rows, along = self.parts[i], self.parts[m]
        total = root_of_squares(
            (self.second(r, a, b) + self.second(a, r, b)) / 2 for r in rows for a in rows for b in along
        )
        total = total / self._over[0]
        for part, length in zip(self.parts, self._reach, strict=True):
            norm = root_of_squares(
                (self.third(r, a, b, c) + self.third(a, r, b, c)) / 2
                for r in rows for a in rows for b in along for c in part
            )  # fmt: skip
            total += norm * length / self._over[1]
        return size(total)

    def push(self, i: int, leaning: range) -> "arb":
        """Bound of what the inputs add to F on the curve in second and third order, each variable at most one."""
        rows, total = self.parts[i], exact(0)
        for m in leaning:
            for n in leaning:
                one, two = self.parts[m][0], self.parts[n][0]
                total += root_of_squares(self.second(r, one, two) for r in rows) / 2
                for o in leaning:
                    total += root_of_squares(self.third(r, one, two, self.parts[o][0]) for r in rows) / 6
        return total


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
