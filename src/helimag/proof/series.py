"""Taylor series in time of matrices of balls, and their enclosures over a span."""

from typing import TYPE_CHECKING, Any

from helimag.proof.balls import around_zero, flint

if TYPE_CHECKING:
    from flint import arb, arb_mat


def coefficient(series: Any, n: int) -> "arb":
    """The n-th of a series; of a number that does not depend on time, and of nothing, too."""
    if series is None:
        return flint().arb(0)
    if isinstance(series, flint().arb):
        return series if n == 0 else flint().arb(0)
    if n >= series.prec:  # beyond where it was cut it has coefficients that are not known, and the library gives zero
        raise TypeError(f"coefficient {n} was asked of a series that was cut at {series.prec}")
    return series[n]


def convolved(a: "list[arb_mat]", b: "list[arb_mat]", order: int) -> "list[arb_mat]":
    """Taylor coefficients of a product of matrices."""
    result = []
    for n in range(order):
        total = a[0] * b[n]
        for k in range(1, n + 1):
            total = total + a[k] * b[n - k]
        result.append(total)
    return result


def divided(frame: "list[arb_mat]", turned: "list[arb_mat]", order: int) -> "list[arb_mat]":
    """The frame's inverse times what is given, as Taylor coefficients: Q X = Y solved order by order."""
    inverse = frame[0].inv()
    result: list[Any] = []
    for n in range(order):
        rest = turned[n]
        for k in range(1, n + 1):
            rest = rest - frame[k] * result[n - k]
        result.append(inverse * rest)
    return result


def over_span(thin: "list[arb_mat]", wide: "list[arb_mat]", half: "arb") -> "list[list[arb]]":
    """Enclosures (rows, columns) over a span by Taylor's theorem: coefficients at its middle, the last over all."""
    order = len(thin)
    result = []
    for i in range(thin[0].nrows()):
        row = []
        for j in range(thin[0].ncols()):
            value, power = thin[0][i, j], half
            for n in range(1, order):
                value = value + around_zero(thin[n][i, j] * power)
                power = power * half
            row.append(value + around_zero(wide[order][i, j] * power))
        result.append(row)
    return result
