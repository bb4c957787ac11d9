"""The motion in a tube's coordinates, enclosed: on the curve as series in time, and with three derivatives around it.

In coordinates y with z = Q y + K[X, X] / 2, X = (y, u), the motion y' = F(X, s) is where M F = R, with M = dz/dy and
R = f(z, s) - dz/ds at fixed X. The derivatives of R come by the rules of calculus; those of F follow one order after
another, as K is constant in X:

    M F_a = R_a - K_a F,   M F_ab = R_ab - K_a F_b - K_b F_a,   M F_abc = R_abc - K_a F_bc - K_b F_ac - K_c F_ab.

The interval matrix M of a whole region has an inverse only if no matrix in it is singular; then z is one to one in y.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from helimag.proof.balls import arithmetic, exact, flint
from helimag.proof.jets import Jet, Value, known, variables
from helimag.proof.series import coefficient, convolved, divided
from helimag.proof.tube import Chart, N, Tube, charts_at, pairs
from helimag.proof.waves import basis

Balls = Any  # a number, list or matrix of balls, or of series of them


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


@dataclass(frozen=True)
class Views:
    """The same equations: at the inputs' middle, there with one or more derivatives by them, over all their values."""

    middle: Dynamics
    leaning: Dynamics
    bending: Dynamics
    over: Dynamics


def views_of(dynamics: Dynamics) -> Views:
    """Of equations whose inputs have no tolerance."""
    return Views(dynamics, dynamics, dynamics, dynamics)


def inputs_of(tube: Tube, dynamics: Dynamics) -> int:
    """How many inputs have a tolerance."""
    return tube.lean.count // dynamics.components


def linear_series(dynamics: Dynamics, tube: Tube, at: Balls, order: int) -> Balls:
    """Taylor coefficients in time of M^-1 R_a (6, 6) on the curve, a over the coordinates."""
    library = flint()
    frame = _frame_series(dynamics, tube, at, order + 1)
    with arithmetic(library.ctx.prec, order):
        deviation = variables([library.arb_series([0])] * N, one=library.arb_series([1]))
    field = _matrices([rate.g for rate in _rates(dynamics, tube, at, order, deviation)], range(N), order)
    moved = convolved(field, frame, order)
    return divided(frame, [moved[n] - (n + 1) * frame[n + 1] for n in range(order)], order)


def push_series(dynamics: Dynamics, tube: Tube, at: Balls, order: int) -> Balls:
    """The same of F and of M^-1 R_a, a over the inputs (6, 1 + inputs)."""
    inputs = range(N, N + inputs_of(tube, dynamics))
    with arithmetic(flint().ctx.prec, order):
        still = [Jet(flint().arb_series([0]))] * N
    rates = _rates(dynamics, tube, at, order, still)
    field = _matrices([{None: rate.v} | rate.g for rate in rates], [None, *inputs], order)
    return divided(_frame_series(dynamics, tube, at, order), field, order)


def bend_series(dynamics: Dynamics, tube: Tube, at: Balls, order: int) -> Balls:
    """The same of F_ab (6, pairs) on the curve, each deviation one variable in f: see :mod:`helimag.proof.thirds`."""
    side = N + inputs_of(tube, dynamics)
    charts = charts_at(tube, dynamics.components, side - N, at, order + 1)
    with arithmetic(flint().ctx.prec, order):
        deviation = variables([flint().arb_series([0])] * N, order=2, one=flint().arb_series([1]))
    rates = _rates(dynamics, tube, at, order, deviation)
    slopes = [_slopes_of(chart, n, side) for n, chart in enumerate(charts)]
    bends = [chart.terms(side) for chart in charts]
    first = _matrices([rate.g for rate in rates], range(side), order)
    moved = [flint().arb_mat([[each[i, a] for a in range(N)] for i in range(N)]) for each in first]
    frame = [flint().arb_mat(chart.frame) for chart in charts]
    right = [added - (n + 1) * bends[n + 1] for n, added in enumerate(convolved(moved, bends, order))]
    right = [a + b for a, b in zip(right, _doubly([known(rate.h) for rate in rates], slopes, order), strict=True)]
    turned = convolved(first, slopes, order)
    for n, each in enumerate(turned):
        for i in range(N):
            for a in range(N):
                each[i, a] = each[i, a] - (n + 1) * frame[n + 1][i, a]
    value = divided(frame, _matrices([{None: rate.v} for rate in rates], [None], order), order)
    return _solved(charts, frame, value, turned, right, order)


def _slopes_of(chart: Chart, n: int, side: int) -> Balls:
    """Taylor coefficient of derivatives (side, side) of deviations and inputs by coordinates and inputs, at y = 0."""
    inputs = [[exact(int(a == b and n == 0)) for b in range(side)] for a in range(N, side)]
    return flint().arb_mat([row + [exact(0)] * (side - N) for row in chart.frame] + inputs)


def _doubly(second: "Sequence[Mapping[Any, Value]]", slopes: "list[Balls]", order: int) -> "list[Balls]":
    """Taylor coefficients of f_AB Z_Aa Z_Bb (6, pairs)."""
    library, alone = flint(), range(slopes[0].nrows())
    side = len(alone)
    rows = [{b: each.get(_pair(a, b)) for b in alone} for each in second for a in alone]
    one = convolved(_matrices(rows, alone, order), slopes, order)
    swapped = [
        library.arb_mat([[each[i * side + a, b] for a in alone] for i in range(N) for b in alone]) for each in one
    ]
    two = convolved(swapped, slopes, order)
    return [library.arb_mat([[each[i * side + b, a] for a, b in pairs(side)] for i in range(N)]) for each in two]


def _solved(
    charts: "list[Chart]", frame: "list[Balls]", value: "list[Balls]", first: "list[Balls]", second: "list[Balls]",
    order: int,
) -> "list[Balls]":  # fmt: skip
    """F_ab from F and the derivatives R_a and R_ab, as Taylor coefficients."""
    library, alone = flint(), range(first[0].ncols())
    column = {pair: n for n, pair in enumerate(pairs(len(alone)))}
    # K_a by variable, one below the other
    turning = [
        library.arb_mat([[chart.bend(i, a, c) for c in range(N)] for a in alone for i in range(N)]) for chart in charts
    ]
    pushed = convolved(turning, value, order)
    less = [library.arb_mat([[each[N * a + i, 0] for a in alone] for i in range(N)]) for each in pushed]
    moving = divided(frame, [a - b for a, b in zip(first, less, strict=True)], order)
    stirred = convolved(turning, moving, order)
    less = [
        library.arb_mat([[each[N * a + i, b] + each[N * b + i, a] for a, b in column] for i in range(N)])
        for each in stirred
    ]
    return divided(frame, [a - b for a, b in zip(second, less, strict=True)], order)


def _matrices(rows: "Sequence[Mapping[Any, Value]]", keys: Sequence[Any], order: int) -> "list[Balls]":
    """Taylor coefficients, as matrices, of what stands under these keys for each of six components."""
    return [flint().arb_mat([[coefficient(row.get(key), n) for key in keys] for row in rows]) for n in range(order)]


def _pair(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a <= b else (b, a)


def _frame_series(dynamics: Dynamics, tube: Tube, at: Balls, order: int) -> "list[Balls]":
    """Taylor coefficients of the frame (6, 6)."""
    begin = dynamics.components
    waves = tube.waves.series(at, order)
    return [flint().arb_mat([[waves[begin + N * j + i, n] for j in range(N)] for i in range(N)]) for n in range(order)]


def _rates(
    dynamics: Dynamics, tube: Tube, at: Balls, order: int, deviation: Sequence[Jet], *, over: bool = False
) -> list[Jet]:
    """Series of the rates around every time of a ball; with ``over`` where the inputs have any of their values."""
    library = flint()
    turns = basis(3, at, order)
    curve = curve_series(tube, dynamics, at, order + 1)
    lean = [] if dynamics.plain else lean_series(tube, dynamics, at, order + 1)
    with arithmetic(library.ctx.prec, order):
        series = library.arb_series
        clock = series([turns[2, n] for n in range(order)]), series([turns[5, n] for n in range(order)])
        over_all = series([library.arb(0, 1)]) if over else None
        point = leaning(
            [series(part[:order]) for part in curve], [[series(p[:order]) for p in e] for e in lean], over_all
        )
        slope = leaning([series(_slopes(p)) for p in curve], [[series(_slopes(p)) for p in e] for e in lean], over_all)
        return dynamics.rates(clock, point, slope, deviation)


def _slopes(part: "list[Balls]") -> "list[Balls]":
    return [n * part[n] for n in range(1, len(part))]


def leaning(values: "list[Balls]", lean: "list[list[Balls]]", any_value: Balls | None) -> list[Value]:
    """Components of a curve as functions of the inputs, with which they lean to first order; or over any value."""
    if not lean:
        return values
    result = []
    for i, value in enumerate(values):
        whole = value if any_value is None else sum((each[i] * any_value for each in lean), value)
        result.append(Jet(whole, {N + j: each[i] for j, each in enumerate(lean)}, {}, {}))
    return result


def curve_series(tube: Tube, dynamics: Dynamics, at: Balls, order: int) -> "list[list[Balls]]":
    """Taylor coefficients of the curve's components."""
    waves = tube.waves.series(at, order)
    return [[waves[i, n] for n in range(order)] for i in range(dynamics.components)]


def lean_series(tube: Tube, dynamics: Dynamics, at: Balls, order: int) -> "list[list[list[Balls]]]":
    """Taylor coefficients of their derivatives by each input."""
    count = dynamics.components
    if not tube.lean.count:
        return []
    series = tube.lean.series(at, order)
    rows = [[series[i, n] for n in range(order)] for i in range(tube.lean.count)]
    return [rows[i : i + count] for i in range(0, len(rows), count)]
