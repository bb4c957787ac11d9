"""Runs near floor and surface: the kernel's table against the solver's, and a ball that sinks or floats up to one."""

import math
from functools import cache

import numpy as np
import pytest
import warp as wp
from scipy.integrate import quad

import helimag as hm
from helimag.engine import advance, system_of, walls
from helimag.engine.packing import pack_bodies
from helimag.geometry import body_rotations
from helimag.hydrodynamics.boundary import Plane
from helimag.hydrodynamics.boundary.surfaces import head_surface
from helimag.hydrodynamics.boundary.tables import make_table
from helimag.outcomes import End
from helimag.physics.balance import SHEETS, Sheet, Swimmer
from helimag.physics.kinematics import State, head_position, rotation_matrix
from helimag.physics.walls import FloorAndSurface, near_walls, seen_walls

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
    states: wp.array(dtype=State),
    loads: wp.array(dtype=wp.spatial_vectord),
    motions: wp.array(dtype=wp.spatial_vectord),
):
    i = wp.tid()
    rotation = rotation_matrix(states[i])
    sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
    here = seen_walls(around[0], head_position(states[i]), rotation, sheets)
    motions[i] = near_walls(body[0], here, head_position(states[i]), rotation, loads[i])


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
    system = system_of(run)
    given = [
        wp.array(pack_bodies([run]), dtype=Swimmer, device="cpu"),
        system.medium.pack([run], "cpu"),
        wp.array(states, dtype=State, device="cpu"),
        wp.array(loads, dtype=wp.spatial_vectord, device="cpu"),
    ]
    motions = wp.zeros(60, dtype=wp.spatial_vectord, device="cpu")
    wp.launch(respond, dim=60, inputs=[*given, motions], device="cpu")
    size = np.sqrt(np.diag(np.linalg.inv(free)))
    off = []
    for normal, distance, load, motion in zip(up, apart, loads, motions.numpy(), strict=True):
        matrix = free + viscosity * table.added(Plane(kind, tuple(normal), float(distance)))
        expected = np.linalg.solve(matrix, load)
        off.append(np.linalg.norm((motion - expected) / size) / np.linalg.norm(expected / size))
    assert np.median(off) < 5e-3
    assert max(off) < 6e-2
    # and the wall is felt at all
    alone = loads @ np.linalg.inv(free)
    nearest = int(np.argmin(gaps))
    assert np.linalg.norm((motions.numpy()[nearest] - alone[nearest]) / size) > 0.1 * np.linalg.norm(
        alone[nearest] / size
    )


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
