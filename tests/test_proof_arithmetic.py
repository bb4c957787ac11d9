"""The arithmetic of proofs: enclosures hold what they enclose, rounding is outward, derivatives are derivatives."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest

flint = pytest.importorskip("flint")

from helimag.proof import balls  # noqa: E402
from helimag.proof.balls import arithmetic, around_zero, exact, largest, lower, root_of_squares, size, upper  # noqa: E402
from helimag.proof.jets import Jet, variables  # noqa: E402
from helimag.proof.series import over_span  # noqa: E402
from helimag.proof.waves import Waves, basis  # noqa: E402

# exp(-1/3) by its own series, the rest of which is below 1e-60
SERIES = sum(Fraction((-1) ** n, 3**n * math.factorial(n)) for n in range(40))
# to 40 digits: DLMF, and the sine of 10^22 from K. C. Ng, Argument reduction for huge arguments, SunPro 1992
KNOWN = {
    "exp(1)": (lambda: exact(1).exp(), "2.718281828459045235360287471352662497757"),
    "exp(-1/3)": (lambda: exact(Fraction(-1, 3)).exp(), SERIES),
    "sin(10^22)": (lambda: exact(Fraction(10**22)).sin(), "-0.8522008497671888017727058937530293682618"),
    "sin(3)": (lambda: exact(3).sin(), "0.1411200080598672221007448028081102798469"),
    "pi": (flint.arb.pi, "3.141592653589793238462643383279502884197"),
    "sqrt(2)": (lambda: exact(2).sqrt(), "1.414213562373095048801688724209698078570"),
}


def holds(ball, value: Fraction, slack=Fraction(0)) -> bool:
    """Whether a ball holds a rational number, up to a slack: decided by rational arithmetic alone."""
    middle, radius = (Fraction(*(int(part) for part in _ratio(each))) for each in (ball.mid(), ball.rad()))
    return abs(middle - value) <= radius + slack


def _ratio(thin):
    mantissa, exponent = thin.man_exp()
    return (mantissa * 2**exponent, 1) if exponent >= 0 else (mantissa, 2 ** (-exponent))


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("precision", [53, 80, 120])
def test_known_values_are_enclosed(name: str, precision: int) -> None:
    function, digits = KNOWN[name]
    with arithmetic(precision):
        ball = function()
        assert holds(ball, Fraction(digits), slack=Fraction(1, 10**39))
        assert float(ball.rad()) <= 8.0 * abs(float(digits)) * 2.0**-precision  # and tightly


def test_precision_and_order_hold_inside_only() -> None:
    before = flint.ctx.prec, flint.ctx.cap
    with arithmetic(99, 7):
        assert (flint.ctx.prec, flint.ctx.cap) == (99, 7)
    assert (flint.ctx.prec, flint.ctx.cap) == before


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction(-1, 10), Fraction(2, 7) * 10**300, Fraction(1, 10**300)])
def test_bounds_are_rounded_outward(value: Fraction) -> None:
    """A float on the wrong side of a third is a proof that is none."""
    with arithmetic():
        ball = exact(value)
        assert Fraction(lower(ball)) <= value <= Fraction(upper(ball))
        assert math.nextafter(upper(ball), -math.inf) <= float(value) <= math.nextafter(lower(ball), math.inf)


def test_what_knows_nothing_bounds_nothing() -> None:
    with arithmetic():
        nothing = exact(1) / flint.arb(0, 1)
        assert upper(nothing) == math.inf
        assert lower(nothing) == -math.inf
        assert upper(size(nothing)) == upper(largest([exact(1), nothing])) == math.inf
        assert upper(root_of_squares([exact(1), nothing])) == math.inf
        assert not around_zero(nothing).is_finite()
        assert not nothing < exact(1e300)


def test_random_expressions_hold_the_true_value() -> None:
    """Ten thousand of them, by rational arithmetic: sums, products, quotients and their second derivatives."""
    random.seed(20261125)
    with arithmetic(53):
        for _ in range(10_000):
            centres = [Fraction(random.randint(-999, 999), random.randint(1, 999)) for _ in range(3)]
            widths = [Fraction(random.randint(0, 99), 10 ** random.randint(3, 9)) for _ in range(3)]
            inside = [c + w * Fraction(random.randint(-100, 100), 100) for c, w in zip(centres, widths, strict=True)]
            given = [exact(c) + flint.arb(0, exact(w).abs_upper()) for c, w in zip(centres, widths, strict=True)]
            x, y, z = variables(given, order=2, one=exact(1))
            a, b, c = inside
            ball = (x * y - z) * (x * x + 3) - 2 * z
            assert holds(ball.v, (a * b - c) * (a * a + 3) - 2 * c)
            assert holds(ball.g[0], b * (a * a + 3) + (a * b - c) * 2 * a)
            assert holds(ball.h[0, 1], 3 * a * a + 3)
            part = (x * x + y * y + 1).inverse()
            true = 1 / (a * a + b * b + 1)
            assert holds(part.v, true)
            assert holds(part.g[1], -2 * b * true**2)
            assert holds(part.h[1, 1], -2 * true**2 + 8 * b * b * true**3)


def test_random_roots_hold_the_true_value() -> None:
    random.seed(3)
    for _ in range(2000):
        square = Fraction(random.randint(1, 10**6), random.randint(1, 10**3))
        with arithmetic(53):
            (x, *_) = variables([exact(square)] * 6, order=2, one=exact(1))
            root = x.inverse_root()
        with arithmetic(400):
            true = exact(square).rsqrt()
            assert root.v.contains(true)
            assert root.g[0].contains(-true / exact(square) / 2)
            assert root.h[0, 0].contains(3 * true / exact(square) ** 2 / 4)


def test_derivatives_in_floats_match_differences() -> None:
    def function(a, b):
        return (a * b + 1).inverse() * a - b * (a * a + b * b).inverse_root()

    def plain(a, b):
        return function(Jet(a), Jet(b)).v

    x, y, step = 1.3, -0.7, 1e-4
    jet = function(*variables([x, y], order=2))
    assert jet.v == pytest.approx(plain(x, y), rel=1e-15)
    assert jet.g[0] == pytest.approx((plain(x + step, y) - plain(x - step, y)) / (2 * step), rel=1e-6)
    mixed = (
        plain(x + step, y + step) - plain(x + step, y - step) - plain(x - step, y + step) + plain(x - step, y - step)
    )
    assert jet.h[0, 1] == pytest.approx(mixed / (4 * step**2), rel=1e-5)
    bend = (plain(x, y + step) - 2 * plain(x, y) + plain(x, y - step)) / step**2
    assert jet.h[1, 1] == pytest.approx(bend, rel=1e-5)
    arrays = function(*variables([np.array([x, 2.0]), np.array([y, 0.5])]))
    assert arrays.v[0] == pytest.approx(jet.v, rel=1e-15)


@pytest.mark.parametrize(("spans", "order"), [(2, 1), (3, 2), (5, 4), (8, 9)])
def test_series_enclose_a_wave_over_every_span(spans: int, order: int) -> None:
    """Taylor's remainder: with one or two coefficients it is most of the enclosure, and without it this fails."""
    rng = np.random.default_rng(spans)
    waves = Waves(rng.normal(size=(2, 6)), rng.normal(size=(2, 6)))
    with arithmetic():
        matrix = waves.matrix
        for k in range(spans):
            middle, half = exact(Fraction(2 * k + 1, 2 * spans)), exact(Fraction(1, 2 * spans))

            def coefficients(at, many, matrix=matrix):
                series = matrix * basis(6, at, many)
                return [flint.arb_mat([[series[i % 2, n] * (1 + i // 2)] for i in range(6)]) for n in range(many)]

            found = over_span(coefficients(middle, order), coefficients(flint.arb(middle, half), order + 1), half)
            times = np.linspace(k / spans, (k + 1) / spans, 41)
            for i in range(6):
                values = (1 + i // 2) * waves.values(times)[i % 2]
                assert float(found[i][0].lower()) <= values.min() + 1e-13
                assert float(found[i][0].upper()) >= values.max() - 1e-13


def test_slopes_of_waves() -> None:
    rng = np.random.default_rng(1)
    waves = Waves(rng.normal(size=(3, 5)), rng.normal(size=(3, 5)))
    times = np.array([0.1, 0.83])
    differences = (waves.values(times + 1e-6) - waves.values(times - 1e-6)) / 2e-6
    np.testing.assert_allclose(waves.slopes(times), differences, rtol=1e-7, atol=1e-7)
    with arithmetic():
        series = waves.matrix * basis(5, exact(0.1), 2)
        for i in range(3):
            assert float(series[i, 0]) == pytest.approx(waves.values(times)[i, 0], rel=1e-13)
            assert float(series[i, 1]) == pytest.approx(waves.slopes(times)[i, 0], rel=1e-13)


def test_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    from helimag.errors import MissingExtra

    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(MissingExtra, match=r'pip install "\.\[proof\]"'):
        balls.flint()
