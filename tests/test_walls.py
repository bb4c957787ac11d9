"""Runs near floor and surface: the kernel's table against the solver's, and a ball that sinks or floats up to one."""

import math
from functools import cache

import numpy as np
import pytest
import warp as wp
from scipy.integrate import quad
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import brentq

import helimag as hm
from helimag.engine import DOP853, MULTIREVOLUTION, advance, running, system_of, walls
from helimag.engine.batch import Batch, Stepping, fits_lanes, goes_abreast, started
from helimag.engine.leaps import CORRECTING
from helimag.engine.packing import pack_bodies
from helimag.engine.start import start_state
from helimag.engine.system import frame_moves
from helimag.geometry import body_rotations
from helimag.hydrodynamics.boundary import Plane, look_up
from helimag.hydrodynamics.boundary.splines import resampled, spline_coefficients, spline_cubics
from helimag.hydrodynamics.boundary.surfaces import head_surface
from helimag.hydrodynamics.boundary.tables import make_table
from helimag.outcomes import End
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import State, head_position, rotation_matrix
from helimag.physics.walls import FloorAndSurface, cubic_slopes, cubic_weights, near_walls, seen_walls

BALL = {"shape": "sphere", "radius": 0.001}
ROD = {"shape": "spheroid", "length": 0.006, "diameter": 0.001}
WEIGHT = 3e-5


@cache
def coarse_table(device, kind):
    ball = device.head.shape == "sphere"
    mesh = head_surface(device.head, 4 if ball else 2)
    return make_table(mesh, kind, gaps=13 if ball else 9, tilts=4 if ball else 5, rolls=1)


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """Tables of coarse surfaces, in seconds instead of minutes."""

    monkeypatch.setattr(walls, "wall_table", coarse_table)
    walls._table.cache_clear()
    yield
    walls._table.cache_clear()


def scenario(head, *, weight=WEIGHT, near=True, **workspace):
    device = {
        "magnetic_moment": 1e-30,
        "head": head,
        "weight": {"net_weight": weight, "gravity_center": 0.0},
        "hydrodynamics": {"model": "boundary", "near_walls": near, "tolerance": 0.05},
    }
    return hm.load("nose-first/fig3c").replaced(
        {
            "device": device,
            "workspace": workspace,
            "drive.start": (0.0, 0.0, 0.0),
            "run.duration": 300.0,
            "run.interval": 0.5,
            "provenance": {},
        }
    )


@wp.kernel(enable_backward=False)
def respond(
    body: wp.array(dtype=Swimmer),
    around: wp.array(dtype=FloorAndSurface),
    seen: wp.array(dtype=State),
    states: wp.array(dtype=State),
    loads: wp.array(dtype=wp.spatial_vectord),
    motions: wp.array(dtype=wp.spatial_vectord),
):
    i = wp.tid()
    sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
    here = seen_walls(around[0], head_position(seen[i]), rotation_matrix(seen[i]), sheets)
    motions[i] = near_walls(body[0], here, head_position(states[i]), rotation_matrix(states[i]), loads[i])


def motions_of(run, states, loads, seen=None):
    """How the kernel has the device move, with walls looked at from ``states`` or from other ones."""
    given = [
        wp.array(pack_bodies([run]), dtype=Swimmer, device="cpu"),
        system_of(run).medium.pack([run], "cpu"),
        wp.array(states if seen is None else seen, dtype=State, device="cpu"),
        wp.array(states, dtype=State, device="cpu"),
        wp.array(loads, dtype=wp.spatial_vectord, device="cpu"),
    ]
    motions = wp.zeros(len(states), dtype=wp.spatial_vectord, device="cpu")
    wp.launch(respond, dim=len(states), inputs=[*given, motions], device="cpu")
    return motions.numpy()


@pytest.mark.parametrize("kind", ["floor", "surface"])
def test_the_kernel_answers_as_the_table_does(kind):
    """Random places and attitudes, some upright or nearly: motion, against the inverse of resistance plus addition."""
    run = scenario(ROD, **{kind: -0.02 if kind == "floor" else 0.02})
    table = walls.wall_table(run.device, kind)
    free, viscosity = hm.resistance(run.device, run.fluid), run.fluid.viscosity
    rng = np.random.default_rng(3)
    quaternions = rng.normal(size=(60, 4))
    quaternions[:4] = [[1.0, 0.0, -1.0, 0.0], [1.0, 1e-5, 1.0, 0.0], [1.0, 0.0, -1.01, 0.03], [0.5, 0.5, 0.49, -0.5]]
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    up = body_rotations(quaternions)[:, 2, :] * (1.0 if kind == "floor" else -1.0)
    gaps = np.exp(rng.uniform(np.log(3e-4), np.log(0.03), 60))
    apart = np.array([g - table.gap(Plane(kind, tuple(n), 0.0)) for g, n in zip(gaps, up, strict=True)])
    height = -0.02 + apart if kind == "floor" else 0.02 - apart
    states = np.column_stack([np.zeros(60), np.zeros(60), height, quaternions])
    loads = rng.normal(size=(60, 6)) * np.array([1e-4] * 3 + [1e-7] * 3)
    motions = motions_of(run, states, loads)
    size = np.sqrt(np.diag(np.linalg.inv(free)))
    off = []
    for normal, distance, load, motion in zip(up, apart, loads, motions, strict=True):
        matrix = free + viscosity * table.added(Plane(kind, tuple(normal), float(distance)))
        expected = np.linalg.solve(matrix, load)
        off.append(np.linalg.norm((motion - expected) / size) / np.linalg.norm(expected / size))
    assert np.median(off) < 5e-3
    assert max(off) < 6e-2
    # and the wall is felt at all
    alone = loads @ np.linalg.inv(free)
    nearest = int(np.argmin(gaps))
    assert np.linalg.norm((motions[nearest] - alone[nearest]) / size) > 0.1 * np.linalg.norm(alone[nearest] / size)


def test_what_walls_add_is_followed_to_first_order():
    """Looked at from a place half as far away, the motion is off by a quarter."""
    run = scenario(ROD, floor=-0.006, surface=0.009)
    rng = np.random.default_rng(8)
    quaternions = np.array([1.0, 0.0, 0.0, 0.0]) + 0.2 * rng.normal(size=(40, 4))
    states = np.column_stack([np.zeros((40, 2)), rng.uniform(-2e-3, 2e-3, 40), quaternions])
    away = np.column_stack([np.zeros((40, 2)), rng.uniform(-4e-4, 4e-4, 40), 0.05 * rng.normal(size=(40, 4))])
    loads = rng.normal(size=(40, 6)) * np.array([1e-4] * 3 + [1e-7] * 3)

    def unit(states):
        return np.column_stack([states[:, :3], states[:, 3:] / np.linalg.norm(states[:, 3:], axis=1, keepdims=True)])

    exact = motions_of(run, unit(states), loads)
    size = np.sqrt(np.diag(np.linalg.inv(hm.resistance(run.device, run.fluid))))
    far, half = (
        np.linalg.norm((motions_of(run, unit(states), loads, unit(states + share * away)) - exact) / size, axis=1)
        for share in (1.0, 0.5)
    )
    assert np.median(far) > 1e-8 * np.median(np.linalg.norm(exact / size, axis=1))
    assert np.median(far / half) == pytest.approx(4.0, rel=0.15)


def swimming(**changes):
    """A rod that rolls with a magnet above it, between floor and surface."""
    run = scenario(ROD, weight=1e-5, floor=-0.02, surface=0.02)
    turned = {"device.magnetic_moment": 6e-4, "drive.distance": 0.17, "run.duration": 40.0, "run.interval": 0.25}
    return run.replaced(turned | changes)


def test_runs_near_walls_leap_as_exactly_as_they_step():
    """To 2 nm: with what walls add taken as constant over a step, places are off by 13 and 14 nm, extremes by 5."""
    run = swimming()
    (leaping,) = advance([run])
    exact, direct = advance([run], method=DOP853, tolerance=1e-11)[0], advance([run], method=DOP853)[0]
    assert leaping.leapt > 0.8
    assert exact.leapt == direct.leapt == 0.0
    assert leaping.status is exact.status
    for history in (leaping, direct):
        assert np.linalg.norm(history.states[:, :3] - exact.states[:, :3], axis=1).max() < 2e-9
    for name in ("low", "high"):
        np.testing.assert_allclose(leaping.records[name], exact.records[name], rtol=0.0, atol=2e-9)


def test_samples_within_steps_near_walls_are_exact():
    """Beside a run that ends a step at each: what is around the device is that of the step, looked up again."""
    climbing = swimming(**{"drive.velocity": (0.0, 0.0, 1e-4), "run.duration": 10.0, "run.interval": 0.05})
    (fine,) = advance([climbing.replaced({"run.interval": 0.001})], method=DOP853)
    (exact,) = advance([climbing], method=DOP853, tolerance=1e-11)
    assert fine.steps < 0.2 * fine.time.size
    away = np.abs(fine.states[::50] - exact.states)
    assert away[:, :3].max() < 2e-9
    assert away[:, 3:].max() < 1e-5


@pytest.mark.parametrize("other", [{"drive.distance": 0.175}, {"magnet.height": 0.1}], ids=["lanes", "no lanes"])
def test_runs_near_walls_have_the_bits_that_each_has_alone(other):
    """Samples of leaps are worked out in lanes, but for a batch whose magnets are cut otherwise."""
    runs = [swimming(), swimming(**other)]
    settings = Stepping(MULTIREVOLUTION)
    assert fits_lanes(system_of(runs[0]), runs[:1], settings)
    assert fits_lanes(system_of(runs[0]), runs, settings) is ("drive.distance" in other)
    assert not goes_abreast(system_of(runs[0]), runs, settings)
    together = advance(runs, threads=1)
    for run, history in zip(runs, together, strict=True):
        (alone,) = advance([run])
        assert alone.leapt > 0.5
        assert alone.records.tobytes() == history.records.tobytes()


def test_no_leaps_where_the_drive_leaves_the_walls_behind():
    """In the frame of a drive that climbs, floor and surface sink."""
    climbing = swimming(**{"drive.velocity": (0.0, 0.0, 1e-4), "run.duration": 10.0})
    (history,) = advance([climbing])
    assert history.leapt == 0.0
    assert frame_moves(system_of(climbing), swimming().drive)
    free = climbing.replaced({"device.hydrodynamics.near_walls": False})
    assert frame_moves(system_of(free), free.drive)


def test_runs_near_walls_do_not_depend_on_where_launches_end(monkeypatch):
    """Going on looks at walls from where they were looked at before, which is no place of the run."""
    climbing = swimming(**{"drive.velocity": (0.0, 0.0, 1e-4), "run.duration": 10.0})
    runs = [climbing, climbing.replaced({"run.interval": 0.005})]  # of the other one, samples lie within steps
    wholes = advance(runs)
    monkeypatch.setattr(running, "FIRST_BUDGET", 7)
    monkeypatch.setattr(running, "LAUNCH_SECONDS", 1e-5)
    for cut, whole in zip(advance(runs), wholes, strict=True):
        np.testing.assert_array_equal(cut.records, whole.records)


def test_runs_near_walls_go_on_between_two_turns_of_a_leap():
    """What was around the device in the turn that a leap was guessed by is used again in the one that corrects it."""
    run, settings = swimming(), Stepping(MULTIREVOLUTION)
    system = system_of(run)
    first = Batch(system, [run], started(system, [run], start_state(run)[None]), settings)
    while int(first.histories()[0].progress["leap"]["stage"]) != int(CORRECTING):
        first.launch(1)
    (stopped,) = first.histories()
    assert stopped.status is End.RUNNING
    assert np.any(stopped.memory["looks"])
    second = Batch(system, [run], np.array([stopped.progress]), settings, [stopped.records], [stopped.memory])
    while second.running:
        second.launch(1000)
    assert second.histories()[0].records.tobytes() == advance([run])[0].records.tobytes()


def brenner(distance, radius, terms=60):
    """Drag on a ball that moves towards a plane that does not let the fluid slip, over Stokes' (Brenner 1961)."""
    alpha = math.acosh(distance / radius)
    total = 0.0
    for n in range(1, terms):
        above = 2.0 * math.sinh((2 * n + 1) * alpha) + (2 * n + 1) * math.sinh(2.0 * alpha)
        below = 4.0 * math.sinh((n + 0.5) * alpha) ** 2 - (2 * n + 1) ** 2 * math.sinh(alpha) ** 2
        total += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1.0)
    return 4.0 / 3.0 * math.sinh(alpha) * total


def free_surface(distance, radius, terms=60):
    """The same towards a flat surface free of stress: two balls that approach each other (Brenner 1961, eq. 3.5)."""
    alpha = math.acosh(distance / radius)
    total = 0.0
    for n in range(1, terms):
        above = 4.0 * math.cosh((n + 0.5) * alpha) ** 2 + (2 * n + 1) ** 2 * math.sinh(alpha) ** 2
        below = 2.0 * math.sinh((2 * n + 1) * alpha) - (2 * n + 1) * math.sinh(2.0 * alpha)
        total += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1.0)
    return 4.0 / 3.0 * math.sinh(alpha) * total


@pytest.mark.parametrize(("kind", "drag"), [("floor", brenner), ("surface", free_surface)])
def test_a_ball_comes_to_a_wall_as_brenner_says(kind, drag):
    """Down to a gap of half a radius, within 2 % of the time with coarse tables; without walls far too early."""
    wall = 0.011
    sense = -1.0 if kind == "floor" else 1.0
    near = scenario(BALL, weight=-sense * WEIGHT, **{kind: sense * wall})
    far = scenario(BALL, weight=-sense * WEIGHT, near=False, **{kind: sense * wall})
    (run,), (open_water,) = advance([near]), advance([far])
    speed = WEIGHT / hm.resistance(near.device, near.fluid)[0, 0]

    expected = quad(lambda way: drag(wall - way, 0.001) / speed, 0.0, wall - 0.0015, epsrel=1e-9)[0]
    way = sense * run.states[:, 2]
    found = float(np.interp(wall - 0.0015, way, run.time))
    assert found == pytest.approx(expected, rel=2e-2)
    early = float(np.interp(wall - 0.0015, sense * open_water.states[:, 2], open_water.time))
    assert early < 0.9 * expected
    assert open_water.status is (End.FLOOR if kind == "floor" else End.SURFACE)


def test_walls_and_open_water_mix_in_a_batch():
    runs = [scenario(BALL, floor=-0.011), scenario(BALL, near=False, floor=-0.011)]
    together = advance(runs)
    for run, history in zip(runs, together, strict=True):
        (alone,) = advance([run])
        assert np.array_equal(alone.records, history.records)


def test_near_walls_go_with_the_boundary_model():
    with pytest.raises(hm.InputError, match=r"near_walls goes with model"):
        hm.load("nose-first/fig3c").replaced({"device.hydrodynamics": {"model": "lighthill", "near_walls": True}})


def test_a_ball_that_sinks_near_a_floor_that_holds_comes_to_rest_on_it():
    """Drag near the floor and contact with it: the way down as where it stops, then no further."""
    stops = scenario(BALL, floor=-0.004).replaced({"run.duration": 60.0, "run.interval": 0.1})
    (stopped,), (rests,) = advance([stops]), advance([stops.replaced({"workspace.contact": "hold"})])
    assert stopped.status is End.FLOOR
    assert rests.status is End.HORIZON
    way = stopped.states[:-1, 2] > -0.00297
    assert np.abs(rests.states[: way.sum(), 2] - stopped.states[:-1, 2][way]).max() < 1e-9
    assert rests.states[-1, 2] == pytest.approx(-0.003, abs=1e-10)
    assert rests.heights.low.min() > -0.003 - 1e-10
    assert rests.touches[0].count == 1


def test_coefficients_are_those_of_a_spline_through_the_values():
    """As SciPy has B-splines: through the values, with no third derivative at the ends; along either axis."""
    values = np.random.default_rng(2).normal(size=(3, 7))
    found = spline_coefficients(values, 1)
    np.testing.assert_allclose(spline_coefficients(values.T, 0), found.T, rtol=0.0, atol=1e-14)
    spline = BSpline(np.arange(-3.0, 10.0), found.T, 3)
    np.testing.assert_allclose(spline(np.arange(7.0)).T, values, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(spline(np.array([0.5, 5.5]), nu=3), 0.0, atol=1e-12)


def test_cubics_and_values_elsewhere_are_of_the_same_spline():
    values = np.random.default_rng(4).normal(size=(7, 3))
    spline = BSpline(np.arange(-3.0, 10.0), spline_coefficients(values, 0), 3)
    places = np.array([0.0, 0.3, 2.0, 5.7, 6.0])
    np.testing.assert_allclose(resampled(values, 0, places), spline(places), rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(resampled(values.T, 1, places), spline(places).T, rtol=0.0, atol=1e-13)
    cubics = spline_cubics(values, 0)
    assert cubics.shape == (6, 3, 4)
    np.testing.assert_allclose(cubics[4] @ 0.6 ** np.arange(4), spline(4.6), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("side", [0, 1])
def test_where_a_table_is_looked_up_it_is_itself(side):
    """Rows and columns lie elsewhere than a table's nodes: on them as SciPy's spline has it, between them nearly."""
    table = coarse_table(scenario(ROD, floor=-0.02).device, "floor")
    values = table.values[:, 1:-1, 1:-1, 0, 0]
    where = look_up(table)
    ends = [(3, np.zeros(values.shape[2]))] * 2
    over_gaps = make_interp_spline(np.log(table.gaps), values[side], bc_type=([ends[0]], [ends[1]]))

    def known(stretched, half):
        near, far = where.near, where.far
        gap = brentq(lambda g: g / (g + near) + g / (g + far) - stretched, 0.5 * table.gaps[0], 2.0 * table.gaps[-1])
        at_tilts = over_gaps(math.log(gap))
        return make_interp_spline(table.tilts[side], at_tilts, bc_type=([(3, 0.0)], [(3, 0.0)]))(2.0 * math.atan(half))

    found = where.surface(values)[side]
    weights = np.array([1.0, 4.0, 1.0]) / 6.0
    scale = np.ptp(values[side])
    for row, column in ((0, 0), (5, 3), (20, 11), (12, 7)):
        edges, cubics = where.halves[side, column : column + 2], weights @ found[column, row : row + 3]
        assert abs(cubics[0] - known(where.rows[row], edges[0])) < 1e-9 * scale
        assert abs(cubics @ 0.5 ** np.arange(4) - known(where.rows[row], edges.mean())) < 2e-3 * scale


@pytest.mark.parametrize("t", [0.0, 0.3, 0.9])
def test_weights_are_b_splines(t):
    pieces = [BSpline(np.arange(-3.0, 5.0), np.eye(4)[i], 3) for i in range(4)]
    np.testing.assert_allclose(
        np.array(cubic_weights(wp.float64(t))), [piece(t) for piece in pieces], rtol=0.0, atol=1e-15
    )
    slopes = [piece(t, nu=1) for piece in pieces]
    np.testing.assert_allclose(np.array(cubic_slopes(wp.float64(t))), slopes, rtol=0.0, atol=1e-15)
