"""Arithmetic that encloses: real balls of Arb, through python-flint.

A ball is a midpoint and a radius; every operation gives a ball that holds the true result, whatever the points of the
balls that went in. Series are polynomials of balls in time, cut at an order. Nothing here rounds by itself.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from helimag.errors import MissingExtra

if TYPE_CHECKING:
    from flint import arb

PRECISION = 80  # bits of a midpoint; doubles have 53


def flint() -> Any:
    """The library of balls.

    Raises
    ------
    MissingExtra
        Where it is not installed.
    """
    try:
        import flint as library
    except ImportError:
        raise MissingExtra.of("a proof", "python-flint", "proof") from None
    return library


@contextmanager
def arithmetic(precision: int = PRECISION, order: int = 1) -> Iterator[None]:
    """Let midpoints have so many bits, and series so many coefficients; what held before holds again afterwards."""
    context = flint().ctx
    before = context.prec, context.cap
    context.prec, context.cap = precision, order
    try:
        yield
    finally:
        context.prec, context.cap = before


def exact(value: Fraction | float) -> "arb":
    """The ball around a rational number, as thin as the precision allows; around a float or an integer, of radius 0."""
    library = flint()
    if not isinstance(value, Fraction):
        return library.arb(value)
    ratio = value
    return library.arb(library.fmpq(ratio.numerator, ratio.denominator))


def upper(ball: "arb") -> float:
    """A float that no point of the ball exceeds; infinite where there is none, and where the ball knows nothing."""
    import math

    if not ball.is_finite():
        return math.inf
    value = float(ball.upper())
    return value if flint().arb(value) >= ball.upper() else math.nextafter(value, math.inf)


def lower(ball: "arb") -> float:
    """A float that no point of the ball is below; minus infinity where the ball knows nothing."""
    return -upper(-ball)


def size(ball: "arb") -> "arb":
    """An upper bound of the absolute values of the ball's points, as a ball of radius 0; infinite where unknown."""
    return ball.abs_upper() if ball.is_finite() else flint().arb("inf")


def around_zero(radius: "arb") -> "arb":
    """All numbers whose absolute value is at most an upper bound of ``radius``."""
    return flint().arb(0, size(radius))


def root_of_squares(values: Iterable["arb"]) -> "arb":
    """An upper bound of the length of a vector whose components are no larger than these."""
    total = flint().arb(0)
    for value in values:
        bound = size(value)
        total += bound * bound
    return size(size(total).sqrt())


def largest(values: Iterable["arb"]) -> "arb":
    """The greatest upper bound of several balls; infinite where one of them knows nothing."""
    best = flint().arb("-inf")
    for value in values:
        bound = value.upper() if value.is_finite() else flint().arb("inf")
        if bound > best:
            best = bound
    return best
