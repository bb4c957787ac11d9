"""Bent coordinates of tubes, beside what they are by definition: the motion in them worked out by differences."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import oracles

flint = pytest.importorskip("flint")

from helimag.errors import InputError  # noqa: E402
from helimag.proof import Certificate, check  # noqa: E402
from helimag.proof.balls import arithmetic, exact  # noqa: E402
from helimag.proof.bounds import ON_THE_WAY, Derivatives, _third, spans_of, straights_of  # noqa: E402
from helimag.proof.certificate import _leaning_too  # noqa: E402
from helimag.proof.field import Views, bend_series, lean_series  # noqa: E402
from helimag.proof.jets import Jet, variables  # noqa: E402
from helimag.proof.motion import Swimming  # noqa: E402
from helimag.proof.series import over_span  # noqa: E402
from helimag.proof.thirds import third_over  # noqa: E402
from helimag.proof.tube import NONE, N, Tube, chart_at, pairs, reached, second_order, triples  # noqa: E402
from helimag.proof.waves import Waves  # noqa: E402

BLOCKS, SIDE = (0, 2, 3, 4), N + 1  # and one input
RADII = (0.02, 0.03, 0.01, 0.02)
AT = 0.37  # turns


@dataclass(frozen=True)
class Odd:
    """z' = A z + b z (c . z) + e u z + 0.1 u^2 z z + drive, beside a curve of no meaning; ``u`` is a jet, or a number.

    Nothing of it is zero by chance: every term of the motion in bent coordinates has its part in what is compared.
    """

    u: object = 0.0
    plain: bool = False
    components: int = 1

    def rates(self, clock, curve, slope, deviation):  # noqa: ARG002
        cosine, sine = clock
        number = float if isinstance(deviation[0].v, float) else _ball
        result = []
        for i in range(N):
            along = sum((number(0.1 * (1 + (i + j) % 3)) * deviation[j] for j in range(N)), 0 * deviation[0])
            linear = sum((number(0.3 * np.cos(1.0 + i + 2 * j)) * deviation[j] for j in range(N)), 0 * deviation[0])
            square = deviation[i] * deviation[(i + 1) % N]
            rate = linear + along * deviation[i] * (1 + cosine) + square * deviation[(i + 2) % N] * sine
            result.append(rate + deviation[i] * self.u * (2 + cosine) + self.u * self.u * square + (self.u * sine))
        return result


def _ball(value: float):
    return exact(float(value))


def tube() -> Tube:
    """Curve, frame and second-order terms at random, of functions that repeat after a turn."""
    rng = np.random.default_rng(3)
    cos, sin = 0.05 * rng.normal(size=(1 + N * N, 5)), 0.05 * rng.normal(size=(1 + N * N, 5))
    for j in range(N):
        cos[1 + N * j + j, 0] += 1.0
    bent = 0.01 * rng.normal(size=(2, N * len(pairs(SIDE)), 5))
    for each in (cos, sin, *bent):
        each[:, 1::2] = 0.0
    still = Waves(np.zeros((1, 1)), np.zeros((1, 1)))
    return Tube(
        Waves(cos, sin), BLOCKS, RADII, RADII, (-1.0,) * 4, (0.0,) * 4, (False,) * 4, 100, 6, 8, 6, 3,
        lean=still, bent=Waves(*bent),
    )  # fmt: skip


def views() -> Views:
    one = exact(1)
    jets = [Jet(exact(0), {N: one}, *(({}, {})[:n])) for n in (0, 1)]  # at the middle, with one derivative and with two
    over = Jet(flint.arb(0, 1), {N: one}, {}, {})
    return Views(Odd(exact(0), plain=True), Odd(jets[0]), Odd(jets[1]), Odd(over))


def placed(shape: Tube, x: np.ndarray, s: float) -> np.ndarray:
    """z = Q y + K[X, X] / 2 by its definition."""
    frame = shape.waves.values(np.array([s]))[1:, 0].reshape(N, N).T
    bent = shape.bent.values(np.array([s]))[:, 0].reshape(len(pairs(SIDE)), N)
    z = frame @ x[:N]
    for n, (a, b) in enumerate(pairs(SIDE)):
        z = z + bent[n] * x[a] * x[b] * (0.5 if a == b else 1.0)
    return z


def moving(shape: Tube, x: np.ndarray, s: float, step: float = 1e-6) -> np.ndarray:
    """F(X, s): what y' must be for z to move as the equations say, by central differences of the definition."""
    slope = (placed(shape, x, s + step) - placed(shape, x, s - step)) / (2.0 * step)
    matrix = np.empty((N, N))
    for c in range(N):
        by = np.zeros(SIDE)
        by[c] = 0.5
        matrix[:, c] = placed(shape, x + by, s) - placed(shape, x - by, s)  # exact, as z is of second order
    clock = np.cos(2.0 * np.pi * s), np.sin(2.0 * np.pi * s)
    rates = Odd(float(x[N])).rates(clock, [0.0], [0.0], [Jet(float(z)) for z in placed(shape, x, s)])
    return np.linalg.solve(matrix, np.array([rate.v for rate in rates]) - slope)


def differences(function, at: np.ndarray, axes, step: float) -> np.ndarray:
    """Mixed derivative along several axes, by central differences."""
    if not axes:
        return function(at)
    by = np.zeros(SIDE)
    by[axes[0]] = step
    ahead, behind = (differences(function, at + sign * by, axes[1:], step) for sign in (1, -1))
    return (ahead - behind) / (2.0 * step)


@pytest.fixture(scope="module")
def enclosed():
    """First, second and third derivatives of F over a short span around ``AT``."""
    shape = tube()
    k = int(AT * shape.spans)
    with arithmetic():
        straight = straights_of(views(), shape, [k])[k]
        middle, half = exact(2 * k + 1) / (2 * shape.spans), exact(1) / (2 * shape.spans)
        wide = flint.arb(middle, half)
        thin = bend_series(views().bending, shape, middle, shape.coarse)
        second = over_span(thin, bend_series(views().bending, shape, wide, shape.coarse + 1), half)
        third = _third(views(), shape, k, straight, shape.region, shape.rough)
    return shape, straight, second, third, (k + 0.95) / shape.spans  # far from the middle: all Taylor's terms count


def test_derivatives_on_the_curve_are_those_of_the_definition(enclosed) -> None:
    """Value, first and second derivatives by coordinates and input, against differences; and tight."""
    shape, straight, second, _, s = enclosed

    def function(x):
        return moving(shape, x, s)

    zero = np.zeros(SIDE)
    for i, value in enumerate(function(zero)):
        assert _near(straight.push[i][0], value, 1e-8)
    for a in range(SIDE):
        true = differences(function, zero, (a,), 1e-4)
        found = [row[a] for row in straight.linear] if a < N else [row[1] for row in straight.push]
        for i in range(N):
            assert _near(found[i], true[i], 1e-6), (i, a)
    for n, pair in enumerate(pairs(SIDE)):
        true = differences(function, zero, pair, 1e-3)
        for i in range(N):
            assert _near(second[i][n], true[i], 2e-5), (i, pair)
            assert float(second[i][n].rad()) < 0.2


def test_third_derivatives_hold_those_of_the_definition_everywhere(enclosed) -> None:
    """At a random place of the region and value of the input."""
    shape, _, _, third, s = enclosed
    rng = np.random.default_rng(4)
    for _ in range(1):
        x = np.concatenate([np.repeat(RADII, (2, 1, 1, 2)) * rng.uniform(-0.7, 0.7, N), rng.uniform(-1.0, 1.0, 1)])
        for n, triple in enumerate(triples(SIDE)):
            true = differences(lambda x: moving(shape, x, s), x, triple, 2e-3)
            for i in range(N):
                assert _near(third[i][n], true[i], 3e-3), (i, triple)


def test_third_derivatives_on_the_curve_are_those_of_the_definition() -> None:
    """Without inputs, over no region to speak of: so tight that no term can be left out."""
    whole, k, u = tube(), int(AT * 100), 0.3
    kept = [n for n, (_, b) in enumerate(pairs(SIDE)) if b < N]
    rows = np.ravel([range(N * n, N * n + N) for n in kept])
    bent = Waves(whole.bent.cos[rows], whole.bent.sin[rows])
    thin = replace(whole, radii=(1e-9,) * 4, entry=(1e-9,) * 4, lean=NONE, bent=bent)
    dynamics = Odd(exact(u), plain=True)
    with arithmetic():
        at = exact(100 * k + 95) / 10000
        third = third_over(dynamics, thin, at, _rows(bend_series(dynamics, thin, at, 1)[0]), thin.radii)
    without = replace(whole, bent=_without_inputs(whole.bent))
    zero = np.array([0.0] * N + [u])
    for n, triple in enumerate(triples(N)):
        true = differences(lambda x: moving(without, x, (k + 0.95) / 100), zero, triple, 2e-3)
        for i in range(N):
            assert _near(third[i][n], true[i], 2e-3), (i, triple)
            assert float(third[i][n].rad()) < 1e-5


def _rows(matrix):
    return [[matrix[i, j] for j in range(matrix.ncols())] for i in range(matrix.nrows())]


def _without_inputs(bent: Waves) -> Waves:
    cos, sin = bent.cos.copy(), bent.sin.copy()
    for n, (_, b) in enumerate(pairs(SIDE)):
        if b == N:
            cos[N * n : N * n + N] = sin[N * n : N * n + N] = 0.0
    return Waves(cos, sin)


def _near(ball, value: float, slack: float) -> bool:
    """Whether a ball holds what differences give, to their own error."""
    return abs(float(ball.mid()) - value) <= float(ball.rad()) + slack * (1.0 + abs(value))


def test_bounds_hold_for_the_change_of_the_linearisation(enclosed) -> None:
    """D F at random points of the tube less D F on the curve, and F on the curve at values of the input."""
    shape, straight, second, third, s = enclosed
    rng = np.random.default_rng(5)
    parts = shape.parts(1)
    with arithmetic():
        form = Derivatives(second, third, parts, [*RADII, 1.0])
        bends = np.array([[[float(form.bend(i, j, m)) for m in range(5)] for j in range(4)] for i in range(4)])
        (span,) = spans_of(views(), shape, {int(AT * shape.spans): straight})
        push = [float(bound) for bound in span.near.push]
    zero = np.zeros(SIDE)
    start = np.array([differences(lambda x: moving(shape, x, s), zero, (a,), 1e-4) for a in range(N)]).T
    for _ in range(12):
        y = np.repeat(RADII, (2, 1, 1, 2)) * rng.uniform(-0.7, 0.7, N)
        x = np.concatenate([y, rng.uniform(-1.0, 1.0, 1)])
        here = np.array([differences(lambda x: moving(shape, x, s), x, (a,), 1e-4) for a in range(N)]).T
        lengths = np.array([np.linalg.norm(x[list(part)]) for part in parts])
        for i, rows in enumerate(parts[:4]):
            for j, columns in enumerate(parts[:4]):
                change = np.linalg.norm((here - start)[np.ix_(list(rows), list(columns))], 2)
                assert change <= bends[i, j] @ lengths + 1e-5
            alone = moving(shape, np.concatenate([np.zeros(N), x[N:]]), s)
            assert np.linalg.norm(alone[list(rows)]) <= push[i] + 1e-9


def test_bounds_hold_for_the_mean_of_the_linearisation_on_the_way(enclosed) -> None:
    """F at random points of the tube is F on the curve, D F there times the way, and no more than the bounds add."""
    shape, _, second, third, s = enclosed
    rng = np.random.default_rng(7)
    parts = shape.parts(1)
    with arithmetic():
        form = Derivatives(second, third, parts, [*RADII, 1.0], ON_THE_WAY)
        bends = np.array([[[float(form.bend(i, j, m)) for m in range(4)] for j in range(4)] for i in range(4)])
    zero = np.zeros(SIDE)
    start = np.array([differences(lambda x: moving(shape, x, s), zero, (a,), 1e-4) for a in range(N)]).T
    tightest = np.zeros(4)
    for _ in range(200):
        y = np.repeat(RADII, (2, 1, 1, 2)) * rng.uniform(-0.7, 0.7, N)
        added = moving(shape, np.array([*y, 0.0]), s) - moving(shape, zero, s) - start @ y
        lengths = np.array([np.linalg.norm(y[list(part)]) for part in shape.columns])
        bound = np.einsum("ijm,j,m->i", bends, lengths, lengths)
        length = np.array([np.linalg.norm(added[list(rows)]) for rows in shape.columns])
        assert np.all(length <= bound + 1e-7)
        tightest = np.maximum(tightest, length / bound)
    assert tightest.max() > 0.3, "bounds not far from what is"


def test_bounds_of_known_derivatives_are_exact() -> None:
    """Of y0' = 3 y0 y2 + 4 u^2 + 5 u^3 + 7 y0^2 y2 + 2 y0 u^2, all second and third derivatives written down."""
    seconds, thirds = {(0, 2): 3, (6, 6): 8}, {(6, 6, 6): 30, (0, 0, 2): 14, (0, 6, 6): 4}
    with arithmetic():
        second = [[exact(seconds.get(pair, 0) if i == 0 else 0) for pair in pairs(SIDE)] for i in range(N)]
        third = [[exact(thirds.get(triple, 0) if i == 0 else 0) for triple in triples(SIDE)] for i in range(N)]
        form = Derivatives(second, third, tube().parts(1), [0.5, 0.25, 1.0, 1.0, 1.0])
        mean = Derivatives(second, third, tube().parts(1), [0.5, 0.25, 1.0, 1.0, 1.0], ON_THE_WAY)
        assert float(form.push(0, range(4, 5))) == pytest.approx(4.0 + 5.0)
        # block 0 is y0 and y1, block 1 is y2: d2 F0 / dy0 dy2, and half of what the third ones add within the reach
        assert float(form.bend(0, 0, 1)) == pytest.approx(3.0 + 14.0 * 0.5 / 2.0)
        assert float(form.bend(0, 1, 0)) == pytest.approx(3.0 + 14.0 * 0.5 / 2.0)
        assert float(form.bend(0, 0, 0)) == pytest.approx(14.0 * 0.25 / 2.0)
        assert float(form.bend(0, 0, 4)) == pytest.approx(4.0 * 1.0 / 2.0)
        assert float(form.twist(0, 1)) == pytest.approx(3.0 + 14.0 * 0.5 / 2.0)
        assert float(form.push(1, range(4, 5))) == 0.0
        # t of the one and t^2 / 2 of the other, over the way from 0 to 1
        assert float(mean.bend(0, 0, 1)) == pytest.approx(3.0 / 2.0 + 14.0 * 0.5 / 6.0)
        assert float(mean.bend(0, 0, 0)) == pytest.approx(14.0 * 0.25 / 6.0)
        assert float(mean.twist(0, 1)) == pytest.approx(3.0 / 2.0 + 14.0 * 0.5 / 6.0)


def test_what_is_reached_holds_all_within_the_radii() -> None:
    """Places of random coordinates on the edge, and a quadratic form's bound."""
    shape, rng = tube(), np.random.default_rng(6)
    with arithmetic():
        reach = [float(ball.rad()) for ball in reached(shape, chart_at(shape, 1, 1, exact(AT)), RADII)]
    far = np.zeros(N)
    for _ in range(3000):
        y = rng.normal(size=N)
        for part, radius in zip(shape.columns, RADII, strict=True):
            y[list(part)] *= radius / np.linalg.norm(y[list(part)])
        far = np.maximum(far, np.abs(placed(shape, np.array([*y, rng.choice([-1.0, 1.0])]), AT)))
    assert np.all(far <= reach)
    assert np.all(far > 0.5 * np.array(reach))
    with arithmetic():
        form = {(0, 0): exact(2), (0, 1): exact(1), (1, 1): exact(-2), (0, 2): exact(3)}
        bound = float(second_order(form, [range(2), range(2, 3)], [1.0, 2.0]))
    for angle in np.linspace(0.0, 2.0 * np.pi, 100):
        x, y = np.cos(angle), np.sin(angle)
        assert abs(x * x + x * y - y * y + 3.0 * x * 2.0) <= bound
    assert bound < 8.0
    with arithmetic():
        even = float(second_order({(0, 0): exact(1), (0, 1): exact(1), (1, 1): exact(1)}, [range(2)], [1.0]))
    assert 1.0 <= even <= 1.0 + 1e-12, "half of (x + y)^2, where x^2 + y^2 is one"


def test_second_derivatives_that_were_not_asked_for_are_not_zero() -> None:
    """A jet that was cut short makes no jet that goes further; nor does a series."""
    short, whole = variables([2.0]), variables([3.0], order=3)
    assert (short[0] * whole[0]).h is None
    assert (short[0] + whole[0]).t is None
    assert (whole[0] * Jet(4.0)).t == {}
    from helimag.proof.series import coefficient

    with arithmetic(80, 2):
        series = flint.arb_series([1, 2])
    assert coefficient(series, 1) == 2
    with pytest.raises(TypeError, match="cut"):
        coefficient(series, 2)


def test_third_derivatives_of_products_quotients_and_roots() -> None:
    """Against differences of second ones."""

    def function(a, b):
        return (a * b + 2).inverse() * a - b * b * (a * a + b * b).inverse_root()

    def second(a, b):
        return function(*variables([a, b], order=2)).h

    x, y, step = 1.3, -0.7, 1e-5
    third = function(*variables([x, y], order=3)).t
    ahead, behind = second(x + step, y), second(x - step, y)
    up, down = second(x, y + step), second(x, y - step)
    for pair in ((0, 0), (0, 1), (1, 1)):
        assert third[0, pair[0], pair[1]] == pytest.approx((ahead[pair] - behind[pair]) / (2 * step), rel=1e-6)
    assert third[1, 1, 1] == pytest.approx((up[1, 1] - down[1, 1]) / (2 * step), rel=1e-6)


def test_terms_that_do_not_close_are_refused() -> None:
    """Second-order terms of a column that changes its sign in a turn do so too."""
    from helimag.proof.certificate import tube_closes

    cos = np.zeros((7 + N * N, 2))
    cos[3:7, 0] = 0.5
    for j in range(N):
        cos[7 + N * j + j, int(j == 2)] = 1.0
    bent = np.zeros((N * len(pairs(N)), 2))
    bent[: N * len(pairs(N)) : N, 0] = 1.0
    odd = (False, True, False, False)
    shape = replace(tube(), waves=Waves(cos, 0 * cos), lean=Waves(np.zeros((0, 1)), np.zeros((0, 1))), odd=odd)
    for n, (a, b) in enumerate(pairs(N)):
        if (a == 2) != (b == 2):
            bent[N * n, :] = [0.0, 1.0]
    assert tube_closes(replace(shape, bent=Waves(bent, 0 * bent)))
    wrong = bent.copy()
    wrong[0, 1] = 1e-9
    assert not tube_closes(replace(shape, bent=Waves(wrong, 0 * wrong)))


def at_rest() -> Tube:
    """The shape of a swimmer's tube: a curve that stands still, and the frame of its axes."""
    cos = np.zeros((Swimming.components + N * N, 1))
    cos[3] = 1.0
    for j in range(N):
        cos[Swimming.components + N * j + j] = 1.0
    return replace(tube(), waves=Waves(cos, 0 * cos), lean=NONE, bent=NONE, spans=1, order=1, fine=1, coarse=1, rough=1)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"swing": (0.5, 0.0, 0.0, 2.0)}, "proves nothing"),
        ({"swing": (0.5, 0.0, 0.3, 2.0)}, "not one"),  # its disc would be turned away from its multiplier, and apart
        ({"entry": (1.7e308,) * 4}, "not one"),
    ],
    ids=["whole", "a column by itself that turns", "a region without end"],
)
def test_numbers_that_bounds_do_not_see_are_refused(change, told) -> None:
    """The first is as good as a tube: it is refused for what it does not prove, not for what it is."""
    scenario = oracles.scenario_of(oracles.case())
    with pytest.raises(InputError, match=told):
        check(Certificate(scenario, {}, replace(at_rest(), **change), None))


def test_a_leaning_attitude_turns_by_no_more_than_is_said() -> None:
    """One that leans by its own length may be turned by half a turn."""
    lean = np.zeros((Swimming.components, 1))
    lean[3:5, 0] = [-1.0, 1e-3]
    shape = replace(at_rest(), lean=Waves(lean, 0 * lean))
    with arithmetic():
        box = _leaning_too(shape, lean_series(shape, Swimming, exact(0), 1), [exact(0)] * N)
    assert min(box[3:]) >= np.pi
