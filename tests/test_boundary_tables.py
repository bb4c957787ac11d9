"""The table of a device's resistance near a plane against solutions at places between its nodes."""

import math

import numpy as np
import pytest

import helimag as hm
from helimag.hydrodynamics.boundary import Plane, cache, tables, wall_table
from helimag.hydrodynamics.boundary.solve import surface_resistance
from helimag.hydrodynamics.boundary.surfaces import head_surface, sphere
from helimag.hydrodynamics.boundary.tables import level_rotation, make_table
from helimag.scenario import SpheroidHead


def rod():
    mesh = head_surface(SpheroidHead(length=6.0, diameter=1.0), 2)
    return mesh.moved(np.eye(3), np.array([-1.5, 0.0, 0.0]))


def normal(tilt, roll):
    return math.sin(tilt), math.cos(tilt) * math.sin(roll), math.cos(tilt) * math.cos(roll)


@pytest.fixture(scope="module", params=["floor", "surface"])
def table(request):
    return make_table(rod(), request.param, gaps=13, tilts=7, rolls=1)


def difference(table, plane):
    """Largest error of an entry, over the geometric mean of its diagonal entries, of the whole resistance."""
    expected = surface_resistance(rod(), plane)
    size = np.sqrt(np.diag(expected))
    ours = surface_resistance(rod()) + table.added(plane)
    return np.abs((ours - expected) / np.outer(size, size)).max()


def test_between_the_nodes(table):
    """Half of random places within 0.2 %, all with a gap of a radius and more within 1 %, nearer ones within 8 %."""
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(24):
        direction = normal(rng.uniform(-1.5, 1.5), rng.uniform(0.0, 2.0 * np.pi))
        gap = math.exp(rng.uniform(math.log(0.1), math.log(20.0)))
        distance = gap - table.gap(Plane(table.kind, direction, 0.0))
        plane = Plane(table.kind, direction, distance)
        assert abs(table.gap(plane) - gap) < 1e-12
        errors.append((gap, difference(table, plane)))
    gaps, off = np.array(errors).T
    assert np.median(off) < 2e-3
    assert off[gaps > 0.5].max() < 1e-2
    assert off.max() < 8e-2


def test_far_away_the_addition_falls_with_the_distance(table):
    near, far = (table.added(Plane(table.kind, normal(0.3, 1.0), d)) for d in (200.0, 400.0))
    middle = -1.5 * math.sin(0.3)
    np.testing.assert_allclose(far * (400.0 + middle), near * (200.0 + middle), rtol=1e-9, atol=1e-12)
    drag = surface_resistance(rod())[2, 2] / (6.0 * np.pi)  # of a ball: 9/8 or 3/4 times its radius over the distance
    share = {"floor": 9 / 8, "surface": 3 / 4}[table.kind]
    upright = table.added(Plane(table.kind, normal(0.0, 0.0), 400.0))[2, 2]
    assert abs(upright / (6 * np.pi * drag**2 * share / 400.0) - 1.0) < 0.05


def test_below_the_least_gap_it_stays(table):
    plane = Plane(table.kind, normal(0.2, 0.5), 0.0)
    at_least, deeper = (table.gaps[0] * share - table.gap(plane) for share in (1.0, 0.5))
    kept, same = (table.added(Plane(table.kind, plane.normal, distance)) for distance in (at_least, deeper))
    np.testing.assert_allclose(same, kept, rtol=1e-12)


def test_level_frame_has_the_normal_in_its_plane():
    tilt, roll = 0.4, 2.2
    level = level_rotation(Plane("floor", normal(tilt, roll), 1.0)) @ np.array(normal(tilt, roll))
    np.testing.assert_allclose(level, [math.sin(tilt), 0.0, math.cos(tilt)], atol=1e-15)


def test_made_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "folder", lambda: tmp_path / "cache")
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "cache")
    monkeypatch.setattr(tables, "device_surfaces", lambda _: iter([sphere(1)]))
    made = []

    def small(mesh, kind, *, rolls):
        made.append(rolls)
        return make_table(mesh, kind, gaps=4, tilts=3, rolls=rolls)

    monkeypatch.setattr(tables, "make_table", small)
    device = hm.load("nose-first/fig3c").device
    first, again = wall_table(device, "floor"), wall_table(device, "floor")
    assert made == [3]
    for name in ("gaps", "tilts", "reach", "values", "middle"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    (path,) = (tmp_path / "cache").iterdir()
    whole = path.read_bytes()
    directory = whole.index(b"PK\x01\x02")  # of the first sheet: then versions (4 bytes), flags (2), compression (2)
    for place, value in ((0, 0), (directory + 6, 255), (directory + 8, 1), (directory + 10, 99), (len(whole) // 2, 0)):
        changed = bytearray(whole)
        changed[place] = value if changed[place] != value else value + 1
        path.write_bytes(changed)
        made.clear()
        assert np.array_equal(wall_table(device, "floor").values, first.values)
        assert made == [3]
    path.write_bytes(whole[:200])
    wall_table(device, "floor")
    wall_table(device, "surface")
    assert made == [3, 3, 3]
