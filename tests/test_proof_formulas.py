"""The equations of motion of proofs beside the kernels', drag beside the package's, decimals beside floats."""

import math
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
import warp as wp

flint = pytest.importorskip("flint")

import helimag as hm  # noqa: E402
import oracles  # noqa: E402
from helimag.engine import build_rates, pack_bodies, pack_drives, pack_magnets, system_of  # noqa: E402
from helimag.engine.events import pack_bounds  # noqa: E402
from helimag.errors import InputError  # noqa: E402
from helimag.hydrodynamics import net_weight  # noqa: E402
from helimag.orbits.strobe import to_lab  # noqa: E402
from helimag.physics.balance import OpenWater, Swimmer  # noqa: E402
from helimag.physics.kinematics import ArmMotion, State  # noqa: E402
from helimag.physics.magnetics import FieldSource  # noqa: E402
from helimag.proof.balls import arithmetic, exact  # noqa: E402
from helimag.proof.clearance import clearance  # noqa: E402
from helimag.proof.exact import Inputs, parts, require_provable, written  # noqa: E402
from helimag.proof.jets import Jet, variables  # noqa: E402
from helimag.proof.motion import LENGTH, Swimming  # noqa: E402
from helimag.proof.proving import in_floats  # noqa: E402
from helimag.proof.tube import Chart, Tube  # noqa: E402
from helimag.proof.waves import Waves  # noqa: E402
from helimag.scenario import Input, scalar_inputs  # noqa: E402

UNIT = float(LENGTH)
CASES = {
    "circle": {},
    "pitch about the magnet, right-handed, backwards": {
        "about": "magnet", "left": False, "frequency": -2.0, "yaw": -0.02,
    },
    "straight": {"yaw": 0.0, "velocity": (1e-3, -2e-4, 1e-4), "rft": "gray-hancock"},
    "two magnets, densities": {
        "magnets": [((0.01, 0.0, -0.01), 12.0), ((0.0, 0.03, 0.0), -0.0 + 7.0)],
        "densities": (1100.0, 7500.0),
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def kernel():
    """The engine's own right-hand side, over a batch of times and states."""
    rates = build_rates(system_of(oracles.scenario_of(oracles.case())))

    @wp.kernel(enable_backward=False, module="unique")
    def at(
        bodies: wp.array(dtype=Swimmer),
        drives: wp.array(dtype=ArmMotion),
        magnets: wp.array2d(dtype=FieldSource),
        times: wp.array(dtype=wp.float64),
        states: wp.array(dtype=State),
        found: wp.array(dtype=State),
    ):
        i = wp.tid()
        found[i] = rates(bodies[0], OpenWater(), drives[0], magnets[0], times[i], states[i])

    return at


def kernel_rates(kernel, scenario, turns, states):
    """Rates (n, 7) in a turn of states (n, 7) of the moving frame, from the kernel's in the lab frame."""
    drive = scenario.drive
    times = turns / abs(drive.frequency)
    lab = to_lab(scenario, times, states)
    found = wp.zeros(len(turns), dtype=State, device="cpu")
    given = [
        wp.array(pack_bodies([scenario]), dtype=Swimmer, device="cpu"),
        pack_drives([scenario], "cpu"),
        wp.array(pack_magnets([scenario]), dtype=FieldSource, device="cpu"),
        wp.array(times, dtype=wp.float64, device="cpu"),
        wp.array(lab, dtype=State, device="cpu"),
    ]
    wp.launch(kernel, len(turns), inputs=given, outputs=[found], device="cpu")
    rates, result = found.numpy(), np.empty_like(states)
    for i, (time, state) in enumerate(zip(times, states, strict=True)):
        back = np.array([math.cos(drive.yaw_rate * time / 2), 0.0, 0.0, -math.sin(drive.yaw_rate * time / 2)])
        moved = oracles.matrix_of(back) @ (rates[i, :3] - np.array(drive.velocity))
        result[i, :3] = moved - drive.yaw_rate * np.array([-state[1], state[0], 0.0])
        spun = product(back, rates[i, 3:])
        result[i, 3:] = spun - 0.5 * product([0.0, 0.0, 0.0, drive.yaw_rate], state[3:])
    return result / abs(drive.frequency)


def product(a, b):
    """Hamilton's product, from its definition by vectors."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], vector])


def random_states(count, scenario):
    rng = np.random.default_rng(7)
    q = rng.normal(size=(count, 4))
    places = np.array(scenario.drive.start) + rng.uniform(-0.02, 0.02, (count, 3))
    return rng.uniform(0.0, 1.0, count), np.hstack([places, q / np.linalg.norm(q, axis=1, keepdims=True)])


@pytest.mark.parametrize("name", CASES)
def test_rates_match_the_kernels_on_random_states(kernel, name):
    """In floats to rounding; and every ball, of radius nearly zero, is around what the kernel gives to rounding."""
    scenario = oracles.scenario_of(oracles.case(**CASES[name]))
    turns, states = random_states(60, scenario)
    expected = kernel_rates(kernel, scenario, turns, states)
    with arithmetic():
        balls = Swimming(Inputs(scenario).constants())
    floats = Swimming(in_floats(balls.constants))
    scale = np.abs(expected).max(axis=0)
    for s, state, true in zip(turns, states, expected, strict=True):
        ours = np.array(floats.plain_rates(s, [*(state[:3] / UNIT), *state[3:]]))
        ours[:3] *= UNIT
        assert np.all(np.abs(ours - true) < 2e-13 * scale)
        with arithmetic():
            angle = 2 * flint.arb.pi() * exact(float(s))
            curve = [exact(float(x)) / exact(LENGTH) for x in state[:3]] + [exact(float(x)) for x in state[3:]]
            still = balls.rates((angle.cos(), angle.sin()), curve, [exact(0)] * 7, [Jet(exact(0))] * 6)
            moved = [float(r.v) * UNIT for r in still[:3]]
            turned = 0.5 * product(state[3:], [0.0, *(float(r.v) for r in still[3:])])
            assert max(float(r.v.rad()) for r in still) < 1e-15 * max(1.0, *(abs(float(r.v)) for r in still))
        assert np.all(np.abs(np.array([*moved, *turned]) - true) < 2e-13 * scale)


def test_rates_beside_a_moving_curve(kernel):
    """Deviations from a curve that moves and turns, its quaternion of any length: against the chain rule."""
    scenario = oracles.scenario_of(oracles.case())
    with arithmetic():
        floats = Swimming(in_floats(Inputs(scenario).constants()))
    rng = np.random.default_rng(11)
    turns, curves = random_states(40, scenario)
    for s, curve in zip(turns, curves, strict=True):
        sigma, away = rng.uniform(-0.1, 0.1, 3), rng.uniform(-0.3, 0.3, 3)
        slope = rng.normal(size=7)
        length = rng.uniform(0.8, 1.2)
        delta = np.concatenate([[1.0 - sigma @ sigma], 2.0 * sigma]) / (1.0 + sigma @ sigma)
        state = np.concatenate([curve[:3] + UNIT * away, product(curve[3:], delta)])
        (rate,) = kernel_rates(kernel, scenario, np.array([s]), state[None])
        clock = (math.cos(2.0 * math.pi * s), math.sin(2.0 * math.pi * s))
        given = [*(curve[:3] / UNIT), *(length * curve[3:])]
        ours = floats.rates(clock, given, list(slope), [Jet(x) for x in (*away, *(4.0 * sigma))])
        np.testing.assert_allclose([r.v for r in ours[:3]], rate[:3] / UNIT - slope[:3], rtol=1e-11, atol=1e-11)
        # the unit quaternion's own rate: what is along itself is a change of length
        unit_slope = (slope[3:] - curve[3:] * (curve[3:] @ slope[3:])) / length
        inverse, inverse_slope = curve[3:] * [1, -1, -1, -1], unit_slope * [1, -1, -1, -1]
        change = product(inverse_slope, state[3:]) + product(inverse, rate[3:])
        # sigma = vector part over one plus scalar part
        expected = 4.0 * (change[1:] * (1.0 + delta[0]) - delta[1:] * change[0]) / (1.0 + delta[0]) ** 2
        np.testing.assert_allclose([r.v for r in ours[3:]], expected, rtol=1e-10, atol=1e-9)


def test_derivatives_of_the_rates_match_differences():
    scenario = oracles.scenario_of(oracles.case())
    with arithmetic():
        floats = Swimming(in_floats(Inputs(scenario).constants()))
    curve = [*(np.array(scenario.drive.start) / UNIT), 0.6, -0.4, 0.5, 0.48]
    slope, clock, at = [0.1, 0.2, -0.1, 0.3, 0.1, -0.2, 0.4], (0.8, 0.6), np.array([0.1, -0.2, 0.1, 0.05, 0.02, -0.03])

    def rates(z, **kind):
        return floats.rates(clock, curve, slope, variables(list(z), **kind))

    exactly = rates(at, order=2)
    step = 1e-4
    for j in range(6):
        ahead, behind = at.copy(), at.copy()
        ahead[j] += step
        behind[j] -= step
        up, down = rates(ahead), rates(behind)
        for i in range(6):
            first = (up[i].v - down[i].v) / (2 * step)
            assert exactly[i].g.get(j, 0.0) == pytest.approx(first, rel=1e-5, abs=1e-5)
            for k in range(6):
                second = (up[i].g.get(k, 0.0) - down[i].g.get(k, 0.0)) / (2 * step)
                assert exactly[i].h.get((min(j, k), max(j, k)), 0.0) == pytest.approx(second, rel=1e-5, abs=1e-4)


HEADS = {
    "ball": {"shape": "sphere", "radius": "0.4 mm"},
    "long": {"shape": "spheroid", "length": "1.4 mm", "diameter": "0.8 mm"},
    "flat": {"shape": "spheroid", "length": "0.5 mm", "diameter": "0.9 mm"},
    "almost round": {"shape": "spheroid", "length": "0.8 mm", "diameter": "0.8001 mm"},
    "cylinder": {"shape": "cylinder", "length": "1 mm", "diameter": "0.9 mm"},
    "long cylinder": {"shape": "cylinder", "length": "2 mm", "diameter": "0.9 mm"},
}


@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("model", ["lighthill", "gray-hancock"])
def test_resistance_and_weight_match(head, model):
    densities = {"helix_density": "1100 kg/m^3", "head_density": "7500 kg/m^3"}
    scenario = oracles.scenario_of(oracles.case()).replaced(
        {"device.head": HEADS[head], "device.hydrodynamics.model": model, "device.weight": densities}
    )
    expected = hm.resistance(scenario.device, scenario.fluid)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    with arithmetic():
        ours = Inputs(scenario).resistance()
        found = np.array([[float(ours[i, j]) for j in range(6)] for i in range(6)])
        widths = np.array([[float(ours[i, j].rad()) for j in range(6)] for i in range(6)])
        force, moment = Inputs(scenario)._weight()
    assert np.abs((found - expected) / scale).max() < 1e-13
    assert (widths / scale).max() < 1e-18
    np.testing.assert_allclose([float(force), float(moment)], net_weight(scenario.device, scenario.fluid), rtol=1e-13)


def test_a_given_matrix_is_taken_as_it_is():
    matrix = oracles.resistance(oracles.case())
    scenario = oracles.scenario_of(oracles.case(matrix=matrix))
    with arithmetic():
        ours = Inputs(scenario).resistance()
        assert all(ours[i, j] == exact(float(matrix[i, j])) for i in range(6) for j in range(6))


@pytest.mark.parametrize("preset", hm.preset_names())
def test_decimals_are_those_of_the_file(preset):
    """Every input as it is written is within rounding of the float that the engine computes with."""
    scenario = hm.load(preset)
    for given in scalar_inputs(scenario):
        if given.path.startswith(("run.", "workspace.", "drive.speed")):
            continue
        with arithmetic():
            ball = Inputs(scenario).read(given.path)
            assert float(ball) == pytest.approx(given.value(scenario), rel=3e-16, abs=0.0)
            assert float(ball.rad()) <= 2e-23 * abs(float(ball))


def test_decimals_are_not_floats():
    """The pitch is 12.7 / 180 of the number pi, not of a float near it."""
    scenario = oracles.scenario_of(oracles.case()).replaced({"drive.pitch": "12.7 deg", "drive.frequency": "3.3 Hz"})
    assert parts(written(scenario, "drive.pitch")) == (Fraction(127, 10), "deg")
    with arithmetic():
        assert Inputs(scenario).read("drive.frequency").contains(flint.arb(33) / 10)
        assert not Inputs(scenario).read("drive.frequency").contains(exact(3.3)), "3.3 is no binary number"
        pitch = Inputs(scenario).read("drive.pitch")
        with arithmetic(300):
            assert pitch.contains(exact(Fraction(127, 1800)) * flint.arb.pi())
        wide = Inputs(scenario, {"drive.pitch": Fraction(1, 10)}).read("drive.pitch")
        for degrees in ("12.6", "12.65", "12.8"):
            assert wide.contains(exact(Fraction(degrees) / 180) * flint.arb.pi())
        assert not wide.contains(exact(Fraction("12.81") / 180) * flint.arb.pi())


def test_inputs_with_a_tolerance_are_variables():
    """At the middle with slopes, over all values with second derivatives: against constants at the box' corners."""
    scenario = oracles.scenario_of(oracles.case()).replaced({"drive.pitch": "12.7 deg", "drive.frequency": "2.5 Hz"})
    widths = {"drive.frequency": Fraction(1, 100), "drive.pitch": Fraction(1, 10)}
    with arithmetic():
        middle, over, plain = (
            Inputs(scenario, widths, view, 3).constants() for view in ("middle", "over", "balls")
        )  # fmt: skip
        for f, p in ((1, 1), (-1, 1), (1, -1)):
            corner = Inputs(
                scenario.replaced({"drive.frequency": f"{2.5 + 0.01 * f} Hz", "drive.pitch": f"{12.7 + 0.1 * p} deg"})
            ).constants()
            for get in (
                lambda k: k.yaw,
                lambda k: k.sin_pitch,
                lambda k: k.mobility[0][0],
                lambda k: k.sources[0].place[0],
            ):
                true, jet, ball, first = get(corner), get(over), get(plain), get(middle)
                assert jet.v.overlaps(true)
                assert ball.overlaps(true)
                change = f * first.g.get(6, exact(0)) + p * first.g.get(7, exact(0))
                # Taylor: half the second derivatives over the box, times variables of one
                rest = sum((abs(h).abs_upper() for h in jet.h.values()), exact(0))
                assert abs(float(true - first.v - change)) <= float(rest) + 1e-15 * abs(float(true))
                # and with second ones at the middle, a sixth of the third over the box, each triple in all its orders
                bend = (first.h or {}).get
                second = (bend((6, 6), 0) + bend((7, 7), 0) + 2 * f * p * bend((6, 7), 0)) / 2
                rest = sum((abs(t).abs_upper() for t in jet.t.values()), exact(0)) / 2
                assert abs(float(true - first.v - change - second)) <= float(rest) + 1e-15 * abs(float(true))


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"magnet.field": "cylinder"}, "magnet.field"), ({"device.helix.wire_radius": "0.2 mm"}, None)],
)
def test_what_cannot_be_proved_is_refused_by_name(changes, told):
    scenario = oracles.scenario_of(oracles.case()).replaced(changes)
    if told is None:
        require_provable(scenario)
        return
    with pytest.raises(InputError, match=told):
        require_provable(scenario)


def test_kinds_of_inputs_are_all_known():
    """A unit that the exact reader did not know would be taken for SI."""
    from helimag.proof.exact import _ANGLES, _UNITS

    scenario = oracles.scenario_of(oracles.case())
    for given in scalar_inputs(scenario):
        kind = given.kind(scenario)
        unit = parts(written(scenario, given.path))[1]
        assert kind is None or unit in _UNITS or unit in _ANGLES or unit == kind.si
    assert Input("drive.pitch").kind(scenario).shown in _ANGLES


def test_a_magnets_strength_from_its_remanence_is_exact():
    """1.35 T and N45 (1.32 to 1.38 T): remanence times r^2 h / 4 over 1e-7, in whole numbers."""
    for given in ({"remanence": "1.35 T"}, {"grade": "N45"}):
        magnet = {**given, "radius": "17.5 mm", "height": "20 mm"}
        scenario = oracles.scenario_of(oracles.case()).replaced({"magnet": [magnet]})
        expected = Fraction(135, 100) * Fraction(175, 10000) ** 2 * Fraction(2, 100) / 4 * 10**6  # per cubic centimetre
        with arithmetic():
            strength = Inputs(scenario).constants().sources[0].strength
            assert strength.contains(exact(expected))
            assert float(strength.rad()) < 1e-21 * float(strength)
        assert float(strength) == pytest.approx(scenario.magnet[0].dipole_moment * 1e-7 / UNIT**3, rel=1e-15)


NOT_ENCLOSED = {
    "an arm that turns and moves sideways": (
        {"drive.yaw_rate": 0.03, "drive.velocity": (1e-4, 0.0, 0.0)},
        "drive.velocity",
    ),
    "a sampled path": (
        {"drive.yaw_rate": 0.0, "drive.path": {"position": [(0.0, 0.0, 0.15), (0.1, 0.0, 0.15)], "time": [0.0, 1e4]}},
        "drive.path",
    ),
    "a drift into a wall": (
        {"drive.yaw_rate": 0.0, "drive.velocity": (1e-3, 0.0, 0.0), "workspace.walls": {"x": ("-1 m", "1 m")}},
        "drive.velocity",
    ),
    "a drift up to a surface": ({"drive.velocity": (0.0, 0.0, 1e-3), "workspace.surface": 0.05}, "drive.velocity"),
    "a drive that sinks": ({"drive.velocity": (0.0, 0.0, -1e-4)}, "drive.velocity"),
    "walls that hold": ({"workspace.surface": 0.05, "workspace.contact": "hold"}, "workspace.contact"),
}


@pytest.mark.parametrize("name", NOT_ENCLOSED)
def test_a_drive_or_walls_that_the_equations_leave_out_are_refused(name):
    """These equations hold a frame in which the drive repeats, and no forces of walls."""
    changes, told = NOT_ENCLOSED[name]
    with arithmetic(), pytest.raises(InputError, match=told):
        Inputs(oracles.scenario_of(oracles.case()).replaced(changes)).constants()


def clearance_at(scenario, place) -> float:
    """The clearance of a tube of no width around a place where all stands still."""
    state = [*place, 0.5, 0.5, -0.5, 0.5]
    curve = [exact(float(x)) / exact(LENGTH) for x in state[:3]] + [exact(float(x)) for x in state[3:]]
    still = Waves(np.zeros((0, 1)), np.zeros((0, 1)))
    tube = Tube(still, (0,), (1e-9,), (1e-9,), (-1.0,), (0.0,), (False,), 1, 1, 1, 1, 1)
    with arithmetic():
        still_chart = Chart([[exact(0)] * 6 for _ in range(6)], [{}] * 6)
        span = SimpleNamespace(straight=SimpleNamespace(curve=curve, chart=still_chart))
        return clearance(Inputs(scenario), tube, [span])


def test_clearance_is_from_where_a_run_ends():
    """Two magnets of different size: a run ends as near to either as the larger one reaches."""
    scenario = oracles.scenario_of(oracles.case(**CASES["two magnets, densities"]))
    scenario = scenario.replaced({"magnet.0.radius": "2 mm", "magnet.0.height": "2 mm", "magnet.1.radius": "40 mm"})
    start = scenario.drive.start
    with arithmetic():
        sources = Inputs(scenario).constants().sources
        magnets = [[float(x) * UNIT for x in source.place] for source in sources]
    gaps = [math.dist(start, place) - scenario.contact_distance for place in magnets]
    assert clearance_at(scenario, start) == pytest.approx(min(gaps), rel=1e-12)


@pytest.mark.parametrize("about", ["origin", "magnet"])
def test_clearance_counts_where_a_run_ends_as_fallen(about):
    """Beside the height that the engine's kernels are given, from which on a run has fallen: above it and below."""
    scenario = oracles.scenario_of(oracles.case(about=about))
    limit = float(pack_bounds([scenario])["fall"][0])
    x, y, _ = scenario.drive.start
    for above in (0.02, 1e-6, -1e-6, -0.02):
        assert clearance_at(scenario, (x, y, limit + above)) == pytest.approx(above, rel=1e-9)


def test_clearance_counts_walls_that_a_drift_passes_or_leaves_behind():
    """Walls along it stay as near as they are, and a floor that it rises from is nearest as it starts; axis upright."""
    across = oracles.scenario_of(oracles.case(yaw=0.0, velocity=(1e-3, 0.0, 0.0)))
    rising = across.replaced({"drive.velocity": (0.0, 0.0, 1e-3), "workspace.floor": -0.1})
    (x, y, z), device = across.drive.start, across.device
    beside = across.replaced({"workspace.walls": {"y": (y - 0.5, y + 0.04)}})
    assert clearance_at(beside, (x, y, z)) == pytest.approx(0.04 - max(device.head_radius, device.tail_radius))
    assert clearance_at(rising, (x, y, z)) == pytest.approx(z - device.tail_length - device.tail_radius + 0.1)
