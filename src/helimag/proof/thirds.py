"""Third derivatives of the motion in a tube's coordinates, enclosed over a box around the curve and a span of time.

With Z = (z, u), deviations and inputs, as functions of X = (y, u), the chain rule gives those of R from those of f:

    R_abc = f_ABC Z_Aa Z_Bb Z_Cc + f_AB (Z_Aab Z_Bc + Z_Aac Z_Bb + Z_Abc Z_Ba),

as z is of second order in X, and so is z' at fixed X. Each deviation is one variable in f, and most of what f consists
of depends on few of them. From R_abc come those of F by

    M F_abc = R_abc - K_a F_bc - K_b F_ac - K_c F_ab,    F_ab(X) = F_ab(0) + a mean of F_abc X_c.

Let U be bounds by component. If what the right-hand side gives for all |F_abc| <= U is smaller than U, then U bounds
them: they have some bound, and the least multiple of U that is one would not be the least if it were above U.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from helimag.proof.balls import around_zero, exact, flint, size
from helimag.proof.field import Dynamics, curve_series, inputs_of, lean_series, leaning
from helimag.proof.jets import Jet, known
from helimag.proof.tube import Chart, N, Tube, chart_at, deviation_jets, pairs, triples
from helimag.proof.waves import basis

if TYPE_CHECKING:
    from flint import arb, arb_mat

Rows = "list[list[arb]]"
TRIES = 40
WIDER, NOTHING = 1.1, 1e-60  # of a bound that is tried: times what it must hold, and beside it


def third_over(
    dynamics: Dynamics, tube: Tube, at: "arb", second: "list[list[arb]]", radii: Sequence[float]
) -> "list[list[arb]]":
    """Enclosures of F_abc (6, triples) within radii by block, over every time of a ball and all values of the inputs.

    Parameters
    ----------
    dynamics
        Over all values of the inputs, with three derivatives by them.
    second
        F_ab (6, pairs) on the curve over these times, at the inputs' middle.

    Raises
    ------
    ZeroDivisionError
        Where no bound is found.
    """
    inputs = inputs_of(tube, dynamics)
    chart, parts = chart_at(tube, dynamics.components, inputs, at), tube.parts(inputs)
    reach = [*(exact(r) for r in radii), *[exact(1)] * inputs]
    moved = deviation_jets(chart, parts, reach)
    right = _chained(_rates_beside(dynamics, tube, at, moved), moved, N + inputs)
    lengths = [reach[p] for p, part in enumerate(parts) for _ in part]
    return _held(chart, moved, second, right, lengths)


def _rates_beside(dynamics: Dynamics, tube: Tube, at: "arb", moved: Sequence[Jet]) -> list[Jet]:
    """The rates as functions of the deviations and inputs, over all that these reach."""
    turns = basis(3, at, 1)
    curve, lean = curve_series(tube, dynamics, at, 2), lean_series(tube, dynamics, at, 2)
    point, slope = (
        leaning([part[n] for part in curve], [[part[n] for part in each] for each in lean], flint().arb(0, 1))
        for n in (0, 1)
    )
    deviation = [Jet(jet.v, {i: exact(1)}, {}, {}) for i, jet in enumerate(moved)]
    return dynamics.rates((turns[2, 0], turns[5, 0]), point, slope, deviation)


def _chained(rates: Sequence[Jet], moved: Sequence[Jet], side: int) -> "list[list[arb]]":
    """R_abc (6, triples) from rates by deviations and inputs, and these as functions of the coordinates and inputs."""
    library, zero = flint(), exact(0)
    alone, by_pair, components = range(side), pairs(side), range(N)
    slopes = library.arb_mat(
        [[jet.g.get(a, zero) for a in alone] for jet in moved]
        + [[exact(int(a == b)) for b in alone] for a in range(N, side)]
    )
    bends = library.arb_mat([[known(jet.h).get(pair, zero) for pair in by_pair] for jet in moved])

    def contracted(entries: "list[list[arb]]") -> "arb_mat":
        return library.arb_mat(entries) * slopes

    # by a triple of deviations and inputs, then by one of them and two coordinates, ...
    third = [known(rate.t) for rate in rates]
    one = contracted([[third[i].get(_in_order(*p, c), zero) for c in alone] for i in components for p in by_pair])
    row = {pair: n for n, pair in enumerate(by_pair)}
    many = len(by_pair)
    two = contracted(
        [[one[i * many + row[_in_order(a, b)], c] for b in alone] for i in components for c in alone for a in alone]
    )
    three = contracted([[two[(i * side + c) * side + a, b] for a in alone] for i in components for b, c in by_pair])
    second = [known(rate.h) for rate in rates]
    mixed = contracted([[second[i].get(_in_order(a, b), zero) for b in alone] for i in components for a in range(N)])
    mixed = library.arb_mat([[mixed[i * N + a, c] for a in range(N)] for i in components for c in alone]) * bends
    return [
        [
            three[i * many + row[b, c], a]
            + mixed[i * side + c, row[a, b]]
            + mixed[i * side + b, row[a, c]]
            + mixed[i * side + a, row[b, c]]
            for a, b, c in triples(side)
        ]
        for i in components
    ]


def _in_order(*keys: int) -> Any:
    return tuple(sorted(keys))


def _held(
    chart: Chart, moved: Sequence[Jet], second: "list[list[arb]]", right: "list[list[arb]]", reach: "list[arb]"
) -> "list[list[arb]]":
    """F_abc from R_abc, and F_ab on the curve, by bounds that hold themselves."""
    library, side = flint(), len(reach)
    inverse = library.arb_mat([[jet.g[a] for a in range(N)] for jet in moved]).inv()
    turning = [
        inverse * library.arb_mat([[chart.bend(i, a, c) for c in range(N)] for i in range(N)]) for a in range(side)
    ]
    moving = inverse * library.arb_mat(right)
    by_triple = triples(side)
    row = {triple: n for n, triple in enumerate(by_triple)}
    column = {pair: n for n, pair in enumerate(pairs(side))}
    bounds = [[exact(0)] * len(by_triple) for _ in range(N)]
    for _ in range(TRIES):
        near = library.arb_mat(
            [
                [
                    value + around_zero(sum((bound[row[_in_order(a, b, c)]] * reach[c] for c in range(side)), exact(0)))
                    for value, (a, b) in zip(values, column, strict=True)
                ]
                for values, bound in zip(second, bounds, strict=True)
            ]
        )
        less = [each * near for each in turning]
        found = [
            [
                moving[i, n] - less[a][i, column[b, c]] - less[b][i, column[a, c]] - less[c][i, column[a, b]]
                for n, (a, b, c) in enumerate(by_triple)
            ]
            for i in range(N)
        ]
        if all(
            size(f) < b
            for found_row, bound in zip(found, bounds, strict=True)
            for f, b in zip(found_row, bound, strict=True)
        ):
            return found
        bounds = [[size(size(f) * exact(WIDER) + exact(NOTHING)) for f in each] for each in found]
    raise ZeroDivisionError("no bound of third derivatives is found: the region is too wide")
