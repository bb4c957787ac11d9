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
from helimag.proof.tube import Chart, N, Tube, charts_at, deviation_jets, pairs, triples
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
    """The same of F_ab (6, pairs) on the curve."""
    return _derivatives(dynamics, tube, at, order, None)


def jerk_series(dynamics: Dynamics, tube: Tube, at: Balls, order: int) -> Balls:
    """The same of F_abc (6, triples) over the whole region and all values of the inputs.

    The coordinates are held while time is expanded.
    """
    reach = [*(exact(r) for r in tube.region), *[exact(1)] * inputs_of(tube, dynamics)]
    return _derivatives(dynamics, tube, at, order, reach)


def _derivatives(dynamics: Dynamics, tube: Tube, at: Balls, order: int, reach: "list[Balls] | None") -> Balls:
    """Taylor coefficients of F_ab on the curve, or of F_abc within a reach by part."""
    inputs = inputs_of(tube, dynamics)
    charts = charts_at(tube, dynamics.components, inputs, at, order + 1)
    with arithmetic(flint().ctx.prec, order):
        deviation = _series_of(charts[:order], tube.parts(inputs), reach)
        way = _series_of([chart.times(n + 1) for n, chart in enumerate(charts[1:])], tube.parts(inputs), reach)
    rates = _rates(dynamics, tube, at, order, deviation, over=reach is not None)
    with arithmetic(flint().ctx.prec, order):
        right = [rate - slope for rate, slope in zip(rates, way, strict=True)]
    frame = _matrices([jet.g for jet in deviation], range(N), order)
    turning = [
        _matrices([{c: known(jet.h).get(_pair(a, c)) for c in range(N)} for jet in deviation], range(N), order)
        for a in range(N + inputs)
    ]
    return _solved(frame, turning, right, order, third=reach is not None)


def _series_of(charts: "Sequence[Chart]", parts: Sequence[range], reach: "list[Balls] | None") -> list[Jet]:
    """Deviations as series in time, from the coordinates' Taylor coefficients, on the curve or in reach of it."""
    series = flint().arb_series
    jets = [deviation_jets(chart, parts, reach) for chart in charts]
    result = []
    for each in zip(*jets, strict=True):
        first = {a: series([jet.g[a] for jet in each]) for a in each[0].g}
        second = {pair: series([known(jet.h)[pair] for jet in each]) for pair in known(each[0].h)}
        result.append(Jet(series([jet.v for jet in each]), first, second, None if reach is None else {}))
    return result


def _solved(frame: "list[Balls]", turning: "list[list[Balls]]", right: list[Jet], order: int, *, third: bool) -> Balls:
    """F_ab or F_abc from the derivatives of R, order by order: M, and K_a by variable, as Taylor coefficients."""
    side = len(turning)
    by_pair, by_triple = pairs(side), triples(side)
    at = {pair: n for n, pair in enumerate(by_pair)}
    value = divided(frame, _matrices([{None: jet.v} for jet in right], [None], order), order)
    pushed = [convolved(each, value, order) for each in turning]
    first = _matrices([jet.g for jet in right], range(side), order)
    less = [[[pushed[a][n][i, 0] for a in range(side)] for i in range(N)] for n in range(order)]
    first = divided(frame, _less(first, less), order)
    stirred = [convolved(each, first, order) for each in turning]
    second = _matrices([known(jet.h) for jet in right], by_pair, order)
    less = [[[stirred[a][n][i, b] + stirred[b][n][i, a] for a, b in by_pair] for i in range(N)] for n in range(order)]
    second = divided(frame, _less(second, less), order)
    if not third:
        return second
    bent = [convolved(each, second, order) for each in turning]
    less = [
        [
            [bent[a][n][i, at[b, c]] + bent[b][n][i, at[a, c]] + bent[c][n][i, at[a, b]] for a, b, c in by_triple]
            for i in range(N)
        ]
        for n in range(order)
    ]
    return divided(frame, _less(_matrices([known(jet.t) for jet in right], by_triple, order), less), order)


def _less(from_these: "list[Balls]", less: "list[list[list[Balls]]]") -> "list[Balls]":
    return [each - flint().arb_mat(these) for each, these in zip(from_these, less, strict=True)]


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
        point = _leaning([series(part[:order]) for part in curve], [[series(p[:order]) for p in e] for e in lean], over)
        slope = _leaning([series(_slopes(p)) for p in curve], [[series(_slopes(p)) for p in e] for e in lean], over)
        return dynamics.rates(clock, point, slope, deviation)


def _slopes(part: "list[Balls]") -> "list[Balls]":
    return [n * part[n] for n in range(1, len(part))]


def _leaning(values: "list[Balls]", lean: "list[list[Balls]]", over: bool) -> list[Value]:
    """Components of a curve as functions of the inputs, with which they lean to first order; over all their values."""
    if not lean:
        return values
    any_value = flint().arb_series([flint().arb(0, 1)])
    result = []
    for i, value in enumerate(values):
        whole = sum((each[i] * any_value for each in lean), value) if over else value
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
