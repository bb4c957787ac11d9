"""Tubes that lean and bend with inputs, of the real equations: derivatives beside what they are by definition.

Floats at changed decimals say what the motion in a tube's coordinates is; enclosures must hold it, and be as thin.
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest

import oracles

flint = pytest.importorskip("flint")

from helimag.proof.balls import arithmetic, exact  # noqa: E402
from helimag.proof.bounds import straights_of  # noqa: E402
from helimag.proof.certificate import dynamics_of  # noqa: E402
from helimag.proof.exact import Inputs  # noqa: E402
from helimag.proof.jets import Jet  # noqa: E402
from helimag.proof.motion import Swimming  # noqa: E402
from helimag.proof.proving import in_floats  # noqa: E402
from helimag.proof.thirds import third_over  # noqa: E402
from helimag.proof.tube import N, Tube, pairs, triples  # noqa: E402
from helimag.proof.waves import Waves  # noqa: E402

SMALL = 1e-4  # of the inputs' widths: what is of second order in them is counted in its square
WIDTHS = {"drive.frequency": "0.00001", "drive.pitch": "0.0001"}
SIDE = N + len(WIDTHS)
COUNT = Swimming.components
STATE = np.array([-0.76, -1.28, -1.19, -0.026, -0.2, -0.491, 0.847])
SPANS, SPAN = 65536, 24576
AT = (SPAN + 0.9) / SPANS
SCENARIO = oracles.scenario_of(oracles.case()).replaced({"drive.frequency": "2.5 Hz", "drive.pitch": "12.7 deg"})


def leaning_tube() -> Tube:
    """Curve, frame, leaning and second-order terms at random; next to no width, and next to no time in a span."""
    rng = np.random.default_rng(1)

    def waves(count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
        cos, sin = size * rng.normal(size=(2, count, 5))
        cos[:, 1::2] = sin[:, 1::2] = 0.0
        return cos, sin

    cos, sin = waves(COUNT + N * N, 0.03)
    cos[:COUNT, 0] += STATE
    for j in range(N):
        cos[COUNT + N * j + j, 0] += 1.0
    bent = waves(N * len(pairs(SIDE)), 0.05)
    scale = np.repeat([SMALL ** sum(a >= N for a in pair) for pair in pairs(SIDE)], N)[:, None]
    radii = (1e-7,) * 4
    return Tube(
        Waves(cos, sin), (0, 2, 3, 4), radii, radii, (-1.0,) * 4, (0.0,) * 4, (False,) * 4, SPANS, 4, 4, 4, 3,
        lean=Waves(*waves(COUNT * len(WIDTHS), 0.02 * SMALL)), bent=Waves(*(each * scale for each in bent)),
    )  # fmt: skip


TUBE = leaning_tube()


@cache
def at_inputs(one: float, two: float) -> Swimming:
    """The equations in floats where the inputs are off by so many widths."""
    changed = {"drive.frequency": f"{2.5 + 1e-5 * one!r} Hz", "drive.pitch": f"{12.7 + 1e-4 * two!r} deg"}
    with arithmetic():
        return Swimming(in_floats(Inputs(SCENARIO.replaced(changed)).constants()))


def placed(x: np.ndarray, s: float) -> np.ndarray:
    """z = Q y + K[X, X] / 2 by its definition."""
    z = TUBE.waves.values(np.array([s]))[COUNT:, 0].reshape(N, N).T @ x[:N]
    for terms, (a, b) in zip(TUBE.bent.values(np.array([s]))[:, 0].reshape(-1, N), pairs(SIDE), strict=True):
        z = z + terms * x[a] * x[b] * (0.5 if a == b else 1.0)
    return z


def moving(x: np.ndarray) -> np.ndarray:
    """F(X): what y' must be for a swimmer beside the leaning curve to move as it does at these inputs."""
    slope = (placed(x, AT + 1e-5) - placed(x, AT - 1e-5)) / 2e-5
    units = 0.5 * np.eye(SIDE)[:N]
    matrix = np.array([placed(x + by, AT) - placed(x - by, AT) for by in units]).T
    curve, rate = (
        of(TUBE.waves)[:COUNT] + x[N:] @ of(TUBE.lean).reshape(len(WIDTHS), COUNT)
        for of in (lambda waves: waves.values(np.array([AT]))[:, 0], lambda waves: waves.slopes(np.array([AT]))[:, 0])
    )
    clock = np.cos(2.0 * np.pi * AT), np.sin(2.0 * np.pi * AT)
    deviation = [Jet(float(z)) for z in placed(x, AT)]
    rates = at_inputs(float(x[N]), float(x[N + 1])).rates(clock, list(curve), list(rate), deviation)
    return np.linalg.solve(matrix, np.array([each.v for each in rates]) - slope)


def differences(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray, axes: Sequence[int], step: float):
    """Mixed derivative along several axes by central differences; inputs' variables counted in what ``SMALL`` is of."""
    if not axes:
        return function(at)
    by = np.zeros(SIDE)
    by[axes[0]] = step / (SMALL if axes[0] >= N else 1.0)
    ahead, behind = (differences(function, at + sign * by, axes[1:], step) for sign in (1, -1))
    return (ahead - behind) / (2.0 * step)


def held(ball, value: float, axes: Sequence[int], slack: float) -> bool:
    """Whether a ball holds what differences give, to their own error, and is thin."""
    unit = SMALL ** sum(a >= N for a in axes)
    middle, radius = float(ball.mid()) / unit, float(ball.rad()) / unit
    return abs(middle - value) <= radius + slack * (1.0 + abs(value)) and radius < 1e-2 * (1.0 + abs(value))


def test_derivatives_of_a_tube_that_leans_and_bends_are_those_of_the_definition() -> None:
    """By coordinates and inputs, of first, second and third order: of curve, frame, terms, and their rates in time."""
    zero = np.zeros(SIDE)
    with arithmetic():
        views = dynamics_of(SCENARIO, WIDTHS)
        straight = straights_of(views, TUBE, [SPAN])[SPAN]
        middle, half = exact(2 * SPAN + 1) / (2 * SPANS), exact(1) / (2 * SPANS)
        wide = flint.arb(middle, half)
        third = third_over(views.over, TUBE, wide, straight.second, TUBE.region)
    found = {(): [row[0] for row in straight.push]}
    found |= {(a,): [row[a] for row in straight.linear] for a in range(N)}
    found |= {(N + j,): [row[1 + j] for row in straight.push] for j in range(len(WIDTHS))}
    found |= {pair: [row[n] for row in straight.second] for n, pair in enumerate(pairs(SIDE))}
    found |= {triple: [row[n] for row in third] for n, triple in enumerate(triples(SIDE))}
    steps = {0: (0.0, 1e-6), 1: (1e-4, 1e-6), 2: (1e-3, 1e-4), 3: (4e-3, 5e-3)}
    for axes, balls in found.items():
        step, slack = steps[len(axes)]
        true = differences(moving, zero, axes, step)
        assert all(held(ball, value, axes, slack) for ball, value in zip(balls, true, strict=True)), axes
