"""Runs in the lanes of vector registers: bit for bit what each is alone, and what cannot be said in lanes."""

import math
from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from helimag.engine import DOP853, MULTIREVOLUTION, advance, system_of
from helimag.engine import running as running_module
from helimag.engine.batch import Stepping, fits_lanes, goes_abreast
from helimag.engine.lanes import LANES, Translation
from helimag.engine.system import System
from helimag.outcomes import End
from helimag.physics import magnetics
from helimag.scenario import load

STEADY = load("nose-first/fig3c").replaced({"run.duration": 60.0})
SLIPPING = load("paper/fig3b")  # and falling
STEPPED = [
    SLIPPING,
    *(SLIPPING.replaced({"run.duration": 20.0, "drive.frequency": 1.0 + 1.4 * i}) for i in range(6)),
    *(SLIPPING.replaced({"run.duration": 40.0, "drive.distance": 0.06 + 0.01 * i}) for i in range(3)),  # pulled in
    *(load("nose-first/fig3b").replaced({"run.duration": 30.0, "drive.distance": 0.2 + 0.05 * i}) for i in range(3)),
]
NUMBERS = (0, 1, 2, 3, 5, 12, 17, 19, 21, 27, 98)  # of benchmarks/random_runs.py: circles, straight, two magnets


def assert_alike(one, other):
    assert one.status is other.status
    assert one.records.tobytes() == other.records.tobytes()
    np.testing.assert_equal(one.progress.tolist(), other.progress.tolist())


def test_runs_in_a_batch_have_the_bits_that_each_has_alone(random_runs):
    """Of all kinds and lengths, so that lanes are full, half full and empty, and turns are followed in other steps."""
    runs = [random_runs.random_run(n)[1].replaced({"run.duration": 20.0 + 7.0 * i}) for i, n in enumerate(NUMBERS)]
    runs += [STEADY.replaced({"drive.distance": 0.13 + 0.004 * i, "run.interval": 0.3 + 0.2 * i}) for i in range(5)]
    together = advance(runs, threads=1)
    assert np.mean([history.leapt for history in together]) > 0.4
    for run, history in zip(runs, together, strict=True):
        assert_alike(advance([run])[0], history)


@pytest.mark.nightly
def test_cylinders_in_lanes_have_the_bits_that_each_has_alone():
    runs = [STEADY.replaced({"magnet.field": "cylinder", "drive.pitch": 0.2 + 0.005 * i}) for i in range(10)]
    for run, history in zip(runs, advance(runs, threads=1), strict=True):
        assert history.leapt > 0.3
        assert_alike(advance([run])[0], history)


@pytest.mark.parametrize("method", [DOP853, MULTIREVOLUTION], ids=["direct", "leaps"])
def test_runs_that_are_stepped_have_the_bits_that_each_has_alone(method):
    """Thirteen, of other frequencies and magnets, that slip, fall and touch: each for as long as it takes."""
    together = advance(STEPPED, method=method, threads=1)
    assert {history.status for history in together} == {End.HORIZON, End.CONTACT, End.FALL}
    assert sum(history.rejected for history in together) > 100
    assert sum(history.progress["synchrony"]["slips"] > 50 for history in together) > 5
    for run, history in zip(STEPPED, together, strict=True):
        assert_alike(advance([run], method=method)[0], history)


@pytest.mark.parametrize("interval", [0.5, 0.02, 0.003])
def test_steps_abreast_are_the_same_wherever_launches_end_and_samples_lie(monkeypatch, interval):
    """With samples many steps apart, about as far as steps are, and several within each."""
    runs = [run.replaced({"run.duration": 1.5, "run.interval": interval}) for run in STEPPED]
    alone = [advance([run], method=DOP853)[0] for run in runs]
    monkeypatch.setattr(running_module, "MOST_FIRST_STEPS", 7)
    monkeypatch.setattr(running_module, "next_budget", lambda *_: 7)
    for one, other in zip(alone, advance(runs, method=DOP853, threads=1), strict=True):
        assert one.time.size == math.ceil(1.5 / interval) + 1
        assert_alike(one, other)


def test_leaps_abreast_are_the_same_wherever_launches_end(monkeypatch):
    """Also where a run asks for a turn in vain, as each does near its end, with hardly a step left in the launch."""
    runs = [
        STEADY.replaced({"run.duration": 20.0, "drive.frequency": 3.0 + 0.13 * i, "drive.distance": 0.15 + 0.004 * i})
        for i in range(9)
    ]
    alone = [advance([run])[0] for run in runs]
    assert all(history.leapt > 0.7 for history in alone)
    monkeypatch.setattr(running_module, "MOST_FIRST_STEPS", 7)
    monkeypatch.setattr(running_module, "next_budget", lambda *_: 7)
    for one, other in zip(alone, advance(runs, threads=1), strict=True):
        assert_alike(one, other)


Numbers = wp.types.vector(length=LANES, dtype=wp.float64)


@wp.struct
class Pair:
    one: wp.float64
    both: wp.vec2d


@wp.func
def summed(pair: Pair, twice: bool) -> wp.float64:
    total = pair.one + pair.both[1]
    if twice:
        total += total
    return total


@wp.func
def much(x: wp.float64, y: wp.float64) -> wp.float64:
    """All that can be said over lanes, in one."""
    total = summed(Pair(x, wp.vec2d(x, y)), True) - summed(Pair(y, wp.vec2d(y, x)), False)
    for i in range(3):
        total += wp.float64(i) * x
        if i == 1:
            total -= wp.where(x < y, wp.abs(x), -y)
    a = wp.vec3d(x * y, y, total / y)
    turn = wp.mat33d(x, y, x, y, x, y, x, x, y)
    return (
        wp.dot(wp.transpose(turn) * a, wp.float64(2.0) * a)
        + wp.length(a) * wp.sign(x)
        - wp.min(x, y)
        + wp.max(total, wp.sqrt(y))
    )


def test_what_is_said_over_lanes_has_the_bits_of_what_was_said():
    said = Translation()
    name = said.function(much)
    loaded = "Lanes x, y; for (int l = 0; l < 8; ++l) { x[l] = xs.c[l]; y[l] = ys.c[l]; }"
    stored = "for (int l = 0; l < 8; ++l) xs.c[l] = found[l];"

    @wp.func_native(f"{said.text}\n{loaded}\nconst Lanes found = {name}(x, y);\n{stored} return xs;")
    def much_in_lanes(xs: Numbers, ys: Numbers) -> Numbers: ...

    @wp.kernel(enable_backward=False, module="unique")
    def compare(xs: Numbers, ys: Numbers, alone: wp.array(dtype=Numbers), lanes: wp.array(dtype=Numbers)):
        one = Numbers()
        for i in range(LANES):
            one[i] = much(xs[i], ys[i])
        alone[0] = one
        lanes[0] = much_in_lanes(xs, ys)

    rng = np.random.default_rng(5)
    xs, ys = Numbers(*rng.uniform(-2.0, 2.0, LANES)), Numbers(*rng.uniform(0.1, 2.0, LANES))
    alone, lanes = (wp.zeros(1, dtype=Numbers, device="cpu") for _ in range(2))
    wp.launch(compare, dim=1, inputs=[xs, ys, alone, lanes], device="cpu")
    assert np.unique(alone.numpy()).size == LANES
    np.testing.assert_array_equal(alone.numpy(), lanes.numpy())


@wp.func
def waits(x: wp.float64) -> wp.float64:
    y = x
    while y < wp.float64(1.0):
        y += x
    return y


@wp.func
def draws(x: wp.float64) -> wp.float64:
    return wp.tan(x)


@pytest.mark.parametrize(("function", "words"), [(waits, "while y < wp.float64"), (draws, "tan")])
def test_what_cannot_be_said_over_lanes_is_refused(function, words):
    with pytest.raises(TypeError, match=words):
        Translation().function(function)


@wp.func
def double(magnet: magnetics.FieldSource, r: wp.vec3d, axis: wp.vec3d, m: wp.vec3d):
    field, force = magnetics.point_dipole(magnet, r, axis, m)
    return field + field, force + force


FIVE_MAGNETS = STEADY.replaced({"magnet": [STEADY.magnet[0]] * 5})
LONG_MAGNET = STEADY.replaced({"magnet.height": 0.1})


@pytest.mark.parametrize(
    ("runs", "system", "fit"),
    [
        ([STEADY] * 3, system_of(STEADY), True),
        ([FIVE_MAGNETS], system_of(FIVE_MAGNETS), False),
        ([STEADY, LONG_MAGNET], system_of(STEADY), False),
        ([STEADY], System(double), False),
    ],
    ids=["alike", "five magnets", "cut otherwise", "a magnet of its own"],
)
def test_runs_that_do_not_fit_lanes_take_their_way_without(runs, system, fit):
    assert fits_lanes(system, runs, Stepping(MULTIREVOLUTION)) is fit


WALLED = STEADY.replaced({"workspace.floor": -1.0, "workspace.contact": "hold"})
OTHER_METHOD = replace(DOP853, lanes=False)


@pytest.mark.parametrize(
    ("runs", "method", "abreast"),
    [
        ([STEADY] * 2, DOP853, True),
        ([STEADY] * 2, OTHER_METHOD, False),
        ([STEADY] * 2, replace(OTHER_METHOD, leaps=True), True),
        ([STEADY], DOP853, False),
        ([WALLED] * 2, DOP853, False),
        ([WALLED] * 2, MULTIREVOLUTION, True),
    ],
    ids=["direct", "not known in lanes", "its turns are", "one run", "walls that hold", "turns clear of them"],
)
def test_runs_that_step_or_turn_abreast(runs, method, abreast):
    assert goes_abreast(system_of(runs[0]), runs, Stepping(method)) is abreast
