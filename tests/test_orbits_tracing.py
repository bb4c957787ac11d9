"""Tracing curves of marginal stability: maps whose curves have a closed form."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from helimag.orbits import Change
from helimag.orbits.curves import tracing
from helimag.orbits.curves.boundary import others_from
from helimag.orbits.curves.crossings import Crossing, OneReal, Pair
from helimag.orbits.curves.tracing import CLOSED, EDGE, Place, Trace, advanced, on_curve, trace

EPSILON = 0.3
LIMIT = 1e-6  # differences over 2e-4 leave some 1e-8, magnified by how slowly the test function changes


@dataclass(frozen=True)
class Plain:
    """A map of n coordinates over two inputs, each from -1 to 1."""

    map: Callable[[np.ndarray, np.ndarray, np.ndarray], list[np.ndarray]]

    def moved(self, place: Place, by: np.ndarray) -> Place:
        return Place(place.state + by[:-2], place.shares + by[-2:])

    def offset(self, place: Place, to: Place) -> np.ndarray:
        return np.append(to.state - place.state, to.shares - place.shares)

    def images(self, place: Place, offsets: np.ndarray) -> np.ndarray:
        inputs = 2.0 * (place.shares + offsets[:, -2:]) - 1.0
        states = place.state + offsets[:, :-2]
        return np.stack(self.map(states.T, inputs[:, 0], inputs[:, 1]), axis=1) - place.state

    def refused(self, _place: Place) -> str | None:
        return None


def place(state: list[float], a: float, b: float) -> Place:
    return Place(np.array(state, float), (np.array([a, b]) + 1.0) / 2.0)


def jacobian(family: Plain, at: Place) -> np.ndarray:
    n = at.state.size
    along = 1e-5 * np.eye(n, n + 2)
    return (family.images(at, along) - family.images(at, -along)).T / 2e-5


def traced(family: Plain, at: Place, crossing: Crossing | None = None) -> Trace:
    first = on_curve(family, crossing or OneReal.near(jacobian(family, at), 1.0), at)
    assert first is not None
    assert first.loss < 0.0
    return trace(family, first)


def inputs_of(curve: Trace) -> tuple[np.ndarray, np.ndarray]:
    a, b = np.array([2.0 * node.place.shares - 1.0 for node in curve.nodes]).T
    return a, b


def spiral(x: np.ndarray, growth: np.ndarray, angle: float) -> list[np.ndarray]:
    cos, sin = math.cos(angle), math.sin(angle)
    return [growth * (cos * x[0] - sin * x[1]), growth * (sin * x[0] + cos * x[1])]


def test_folds_pass_through_a_cusp() -> None:
    """Fixed points are the roots of a + b x - x^3, which fold where 27 a^2 = 4 b^3."""
    family = Plain(lambda x, a, b: [x[0] + EPSILON * (a + b * x[0] - x[0] ** 3), 0.5 * x[1] + 0.1 * x[0] ** 2])
    root = math.sqrt(0.5 / 3.0)  # of b = 0.5, where a = -2 root^3
    curve = traced(family, place([root + 0.02, 0.03], -2.0 * root**3 + 0.01, 0.51))
    a, b = inputs_of(curve)
    assert curve.ends == (EDGE, EDGE)
    assert np.abs(27.0 * a**2 - 4.0 * b**3).max() < LIMIT
    assert sorted([a[0], a[-1]]) == pytest.approx([-math.sqrt(4.0 / 27.0), math.sqrt(4.0 / 27.0)], abs=LIMIT)
    assert b.min() < 0.01
    assert np.hypot(np.diff(a), np.diff(b)).max() < 2.0 * 1.2 * tracing.SPACING + 1e-9


def test_swings_close_a_circle() -> None:
    """A multiplier of size 1 + (a^2 + b^2 - r^2) / 5, at a fixed point that moves with the inputs."""
    radius, angle = 0.6, 0.7

    def circle(x: np.ndarray, a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
        y = np.stack([x[0] - 0.3 * a, x[1] + 0.2 * a * b, x[2]])
        u, v = spiral(y, 1.0 + 0.2 * (a**2 + b**2 - radius**2), angle)
        return [0.3 * a + u + 0.1 * y[0] ** 2, -0.2 * a * b + v + 0.3 * y[0] * y[2], 0.4 * x[2] + 0.2 * y[0] * y[1]]

    curve = traced(Plain(circle), place([0.18, 0.0, 0.0], 0.6, 0.01), Pair(angle))
    a, b = inputs_of(curve)
    assert curve.ends == (CLOSED, CLOSED)
    assert np.abs(np.hypot(a, b) - radius).max() < LIMIT
    turns = np.unwrap(np.arctan2(b, a))
    assert abs(turns[-1] - turns[0]) == pytest.approx(2.0 * math.pi, abs=1e-6)
    assert np.all(np.diff(turns) * np.sign(turns[-1] - turns[0]) > 0.0)
    assert all(node.crossing.angle == pytest.approx(angle, abs=LIMIT) for node in curve.nodes)


def test_flips_follow_a_parabola() -> None:
    family = Plain(lambda x, a, b: [-(1.0 + 0.5 * (a + b**2 - 0.2)) * x[0] + x[0] ** 3, 0.3 * x[1] + x[0] ** 2])
    at = place([0.0, 0.0], 0.19, 0.05)
    curve = traced(family, at, OneReal.near(jacobian(family, at), -1.0))
    a, b = inputs_of(curve)
    assert curve.ends == (EDGE, EDGE)
    assert {node.crossing.kind for node in curve.nodes} == {Change.PERIOD_DOUBLING}
    assert np.abs(a + b**2 - 0.2).max() < LIMIT


def test_a_curve_that_bends_over_the_edge_ends_on_it() -> None:
    """Flips on a = 2 b^2 - 1/2: a step along the tangent that stays just within comes out beyond a = 1."""
    family = Plain(lambda x, a, b: [-(1.0 + 0.5 * (a + 0.5 - 2.0 * b**2)) * x[0] + x[0] ** 3, 0.3 * x[1]])
    at = place([0.0, 0.0], 0.9, math.sqrt(0.7))
    node = on_curve(family, OneReal.near(jacobian(family, at), -1.0), at)
    assert node is not None
    node = replace(node, tangent=node.tangent * np.sign(node.tangent[2]))
    step = (1.0 - node.place.shares[0]) / node.tangent[2] * (1.0 - 1e-6)
    beyond = advanced(family, node, step)
    assert beyond is not None
    assert beyond.place.shares[0] > 1.0 + 1e-5
    taken = tracing._taken(family, node, step)
    assert taken is not None
    end, landed, _ = taken
    assert landed
    assert end is not None
    assert end.place.shares[0] == pytest.approx(1.0, abs=1e-12)
    assert 2.0 * end.place.shares[1] - 1.0 == pytest.approx(math.sqrt(0.75), abs=LIMIT)


def bogdanov_takens(x: np.ndarray, a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    """Steps of the normal form: folds on 4 a = b^2, swings where x = -epsilon b / (1 + 2 epsilon) is fixed."""
    return [x[0] + EPSILON * x[1], x[1] + EPSILON * (a + b * x[0] + x[0] ** 2 - x[0] * x[1])]


def fold_and_swing(x: np.ndarray, a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    """Folds of x2 on a = 0; a pair of size 1 + epsilon (b + x2), which is one on a = -b^2."""
    u, v = spiral(x, 1.0 + EPSILON * (b + x[2]), 0.5)
    return [u, v, x[2] + EPSILON * (a + x[2] ** 2 + x[0] ** 2 + x[1] ** 2)]


def test_folds_end_at_a_double_one_where_swings_begin() -> None:
    family = Plain(bogdanov_takens)
    folds = traced(family, place([0.25, 0.0], 0.06, -0.5))
    a, b = inputs_of(folds)
    assert np.abs(4.0 * a - b**2).max() < LIMIT
    assert sorted(folds.ends) == ["Bogdanov-Takens", EDGE]
    end = folds.ends.index("Bogdanov-Takens") * -1
    assert np.abs([a[end], b[end]]).max() < 1e-5
    (start,) = others_from(family, folds.nodes[end], "Bogdanov-Takens")
    swings = trace(family, start)
    a, b = inputs_of(swings)
    x = -EPSILON * b / (1.0 + 2.0 * EPSILON)
    assert np.abs(a + b * x + x**2).max() < LIMIT
    assert sorted(swings.ends) == ["Bogdanov-Takens", EDGE]
    end = swings.ends.index("Bogdanov-Takens") * -1
    assert np.abs([a[end], b[end]]).max() < 1e-5


def test_folds_and_swings_end_where_they_meet() -> None:
    family = Plain(fold_and_swing)
    folds = traced(family, place([0.0, 0.0, 0.01], 0.0, -0.5))
    a, b = inputs_of(folds)
    assert np.abs(a).max() < LIMIT
    assert sorted(folds.ends) == [EDGE, "fold-Neimark-Sacker"]
    end = folds.ends.index("fold-Neimark-Sacker") * -1
    assert abs(b[end]) < 1e-5
    (start,) = others_from(family, folds.nodes[end], "fold-Neimark-Sacker")
    swings = trace(family, start)
    a, b = inputs_of(swings)
    assert np.abs(a + b**2).max() < LIMIT
    assert b.min() > -1e-5
    assert sorted(swings.ends) == [EDGE, "fold-Neimark-Sacker"]
    # and the other way round
    end = swings.ends.index("fold-Neimark-Sacker") * -1
    (start,) = others_from(family, swings.nodes[end], "fold-Neimark-Sacker")
    assert start.crossing.kind is Change.FOLD
    assert 2.0 * start.place.shares[1] - 1.0 < 0.0


def test_gradients_are_those_of_the_test_function() -> None:
    """How the test function changes, from products with two vectors each, beside whole Jacobians far apart."""
    family = Plain(fold_and_swing)
    at = place([0.02, -0.03, 0.1], 0.2, 0.1)
    for crossing in (Pair(0.5), OneReal.near(jacobian(family, place([0.0, 0.0, 0.01], 0.0, 0.0)), 1.0)):
        _, matrix, _ = tracing._equations(family, crossing, at)
        for k, row in enumerate(1e-4 * np.eye(5)):
            ahead, behind = (tracing._equations(family, crossing, family.moved(at, by))[0][-1] for by in (row, -row))
            assert matrix[-1, k] == pytest.approx((ahead - behind) / 2e-4, abs=2e-5)


def test_a_curve_that_cannot_be_evaluated_says_so() -> None:
    family = Plain(lambda x, a, b: [x[0] + EPSILON * (a - x[0] ** 2), np.where(b > 0.5, np.nan, 0.1 * x[1])])
    curve = traced(family, place([0.0, 0.0], 0.01, 0.0))
    assert sorted(curve.ends) == [EDGE, tracing.FAILED]
    a, b = inputs_of(curve)
    assert np.abs(a).max() < LIMIT
    assert b.max() == pytest.approx(0.5, abs=1e-3)
    assert advanced(family, curve.nodes[int(np.argmax(b))], 0.1) is None
