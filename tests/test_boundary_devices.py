"""The boundary model in scenarios: headless helices, heads alone, STL bodies, its cache and what it says."""

import struct
import sys
from itertools import islice

import numpy as np
import pytest

import helimag as hm
from helimag.checks import enclosing_body
from helimag.hydrodynamics import boundary, error_estimate, net_weight
from helimag.hydrodynamics.boundary import cache, refine
from helimag.hydrodynamics.boundary.closed import checked
from helimag.hydrodynamics.boundary.device import device_surfaces
from helimag.hydrodynamics.boundary.refine import refined
from helimag.hydrodynamics.boundary.solve import MOST, surface_resistance
from helimag.hydrodynamics.boundary.surfaces import head_surface, rod_surface, sphere
from helimag.hydrodynamics.bounds import drag_ratio, enclosing_resistance, moved, violates
from helimag.hydrodynamics.heads import ball, spheroid
from helimag.hydrodynamics.resistive_force import helix_resistance, lighthill
from helimag.scenario import CylinderHead, SpheroidHead, parse
from helimag.vision.shape import Shape

MU = 0.7


@pytest.fixture(autouse=True)
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "cache")
    monkeypatch.setattr(cache, "_memory", {})
    return tmp_path / "cache"


def scenario_with(**changes):
    changes = {"hydrodynamics": {"model": "boundary", "tolerance": 0.01}} | changes
    changed = {"fluid.viscosity": MU} | {f"device.{key}": value for key, value in changes.items()}
    return hm.load("nose-first/fig3c").replaced(changed)


def short(**changes):
    """A helix of one turn: quick to solve."""
    helix = {"length": "2 mm", "outer_diameter": "0.94 mm", "pitch": "2 mm", "wire_radius": "0.2 mm"}
    if "hydrodynamics" not in changes:
        changes = changes | {"hydrodynamics.tolerance": 0.05}
    return scenario_with(**({"helix": helix} | changes))


def write_binary(path, corners):
    with open(path, "wb") as file:
        file.write(b" " * 80 + struct.pack("<I", len(corners)))
        for triangle in corners:
            file.write(struct.pack("<12fH", 0, 0, 0, *np.asarray(triangle, dtype=float).ravel(), 0))
    return path


def write_text(path, corners):
    lines = ["solid body"]
    for triangle in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {:.9e} {:.9e} {:.9e}".format(*corner) for corner in triangle]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid body", ""]))
    return path


def body_scenario(path, **pose):
    return scenario_with(helix=None, head=None, body={"file": str(path), "unit": "1 mm"} | pose)


# ------------------------------------------------------------------------------------------------------------ devices


def test_head_alone_is_a_ball():
    device = short(helix=None).device
    matrix = hm.resistance(device, short().fluid)
    np.testing.assert_allclose(matrix, ball(device.head.radius, MU), rtol=1e-3, atol=1e-12)
    assert 0.0 < error_estimate(device) < 0.01


def test_headless_helix_begins_at_the_origin():
    """As the helix of a device with a head, but moved forward by the head's reach."""
    device = short(head=None).device
    corners = next(device_surfaces(device)).corners
    wire = device.helix.wire_radius
    assert -device.helix.length - wire < corners[:, :, 0].min() < -device.helix.length
    assert 0.0 < corners[:, :, 0].max() < wire
    assert (device.front, device.tail_length, device.length) == (0.0, device.helix.length, device.helix.length)
    assert device.head_radius == device.tail_radius == device.helix.outer_diameter / 2
    rft = short(head=None, hydrodynamics={"model": "lighthill"})
    with_head = short(hydrodynamics={"model": "lighthill"})
    reach = with_head.device.head.reach
    own = helix_resistance(device.helix, 0.0, *lighthill(device.helix, MU))
    np.testing.assert_allclose(hm.resistance(rft.device, rft.fluid), own, rtol=1e-12)
    shifted = moved(own, np.array([-reach, 0.0, 0.0]))
    both = hm.resistance(with_head.device, with_head.fluid)
    size = np.sqrt(np.outer(np.diag(both), np.diag(both)))
    assert np.abs((both - ball(reach, MU) - shifted) / size).max() < 1e-12


def test_headless_helix_swims_and_is_weighed():
    scenario = short(head=None).replaced({"run.duration": "2 s", "run.interval": "0.1 s"})
    assert np.isfinite(hm.simulate(scenario).final_state).all()
    dense = short(head=None, weight={"helix_density": "2000 kg/m^3"})
    force, moment = net_weight(dense.device, dense.fluid)
    expected = 9.80665 * (2000.0 - 971.0) * dense.device.helix.volume
    np.testing.assert_allclose([force, moment], [expected, -expected * 1e-3], rtol=1e-12)
    assert parse(scenario.to_toml()).hash == scenario.hash


def test_device_is_below_its_enclosing_body_in_every_motion():
    for device in (short().device, short(head=None).device):
        bound = enclosing_resistance(device, short().fluid)
        matrix = hm.resistance(device, short().fluid)
        size = np.sqrt(np.outer(np.diag(bound), np.diag(bound)))
        assert np.linalg.eigvalsh((bound - matrix) / size).min() > 0.0
        assert not violates(matrix, bound)


def test_a_body_that_is_its_own_bound_exceeds_it_by_the_solvers_error_only():
    needle = short(helix=None, head={"shape": "spheroid", "length": "30 mm", "diameter": "1 mm"})
    matrix, bound = hm.resistance(needle.device, needle.fluid), enclosing_resistance(needle.device, needle.fluid)
    error = error_estimate(needle.device)
    assert 1.0 < drag_ratio(matrix, bound) < 1.0 + error  # true drag is 0.9986 of the bound's, for its roundness
    assert not violates(matrix, bound, error)
    assert enclosing_body(needle).holds
    assert violates((1.0 + error) * matrix, bound, error)


def test_a_long_rod_is_solved():
    """J. B. Keller and S. I. Rubinow, as in `test_boundary_solver.test_long_cylinder`: good to 2 % at this length."""
    rod = short(helix=None, head={"shape": "cylinder", "length": "50 mm", "diameter": "1 mm"}).device
    drag = np.diag(boundary.solution(rod).resistance)
    e = 1.0 / np.log(50e-3 / 0.5e-3)
    along = 2 * np.pi * 50e-3 / (1 / e - 0.80685 - (0.82854 - 0.80685**2) * e)
    across = 4 * np.pi * 50e-3 / (1 / e + 0.19315 - (0.21466 - 0.19315**2) * e)
    np.testing.assert_allclose(drag[[0, 1]], [along, across], rtol=0.02)
    assert 1.0 < drag[3] / (4 * np.pi * 0.5e-3**2 * 50e-3) < 1.02  # a turning cylinder of no end, and its ends
    assert error_estimate(rod) < 0.01


def test_a_rods_surface_is_a_cylinders():
    """In facets longer than wide, within what it states, as in facets as long as wide."""
    head = CylinderHead(length=6.0, diameter=1.0)
    rod, finer = refined((rod_surface(head, n) for n in (5, 7)), 0.05), surface_resistance(head_surface(head, 2))
    assert rod_surface(head, 5).volume == pytest.approx(head.volume, rel=1e-12)
    assert checked(rod_surface(head, 5).corners, "rod").volume > 0.0
    assert np.abs(np.diag(rod.resistance) / np.diag(finer) - 1.0).max() < rod.error_estimate < 0.02


def cad_cylinder(sections, length):
    """Facets from end to end of the mantle, and fans on the ends, as CAD programs write a cylinder (4 n, 3, 3)."""
    angle = 2.0 * np.pi * np.arange(sections) / sections
    low = np.stack([np.zeros_like(angle), 0.5 * np.cos(angle), 0.5 * np.sin(angle)], axis=1)
    along = np.array([length, 0.0, 0.0])
    high, after = low + along, np.roll(low, -1, axis=0)
    high_after = np.roll(high, -1, axis=0)
    bottom, top = np.zeros_like(low), np.zeros_like(low) + along
    four = [(low, after, high), (after, high_after, high), (bottom, after, low), (top, high, high_after)]
    return np.concatenate([np.stack(corners, axis=1) for corners in four])


@pytest.mark.parametrize(("sections", "length"), [(24, 10.0), (60, 40.0)])
def test_long_thin_facets_leave_room_for_a_finer_surface(tmp_path, sections, length):
    scenario = body_scenario(write_binary(tmp_path / "rod.stl", cad_cylinder(sections, length)))
    first, second = islice(device_surfaces(scenario.device), 2)
    assert 4 * sections <= len(first) <= MOST // 4
    assert len(second) == 4 * len(first)
    assert first.volume == pytest.approx(second.volume, rel=1e-9)


def test_a_cylinder_of_long_thin_facets_is_a_rod(tmp_path):
    pose = {"origin": ["3 mm", "0 mm", "0 mm"]}
    body = body_scenario(write_binary(tmp_path / "rod.stl", cad_cylinder(8, 6.0)), **pose).device
    found = surface_resistance(next(device_surfaces(body)))
    across = 1e-3 * np.sqrt(np.sin(np.pi / 4) / (np.pi / 4))  # of the round rod of the same volume
    rod = surface_resistance(rod_surface(CylinderHead(length=6e-3, diameter=across), 10))
    np.testing.assert_allclose(np.diag(found), np.diag(rod), rtol=0.02)


def test_what_does_not_fit_is_refused_before_it_is_solved(monkeypatch):
    monkeypatch.setattr(refine, "surface_resistance", None)  # anyone who calls it fails
    with pytest.raises(hm.InputError, match="for resolution 2 of at least 2"):
        refined(iter([sphere(12), sphere(16)]), 0.01)


def test_a_wire_that_is_too_long_is_refused():
    wire = {"length": "200 mm", "outer_diameter": "2 mm", "pitch": "1 mm", "wire_radius": "0.1 mm"}
    with pytest.raises(hm.InputError, match=r"surface triangles.* a shorter wire or a thicker one"):
        boundary.solution(short(head=None, helix=wire).device)


def test_helix_and_head_feel_each_other():
    """Together less than the sum of the two, more than each."""
    whole, helix, head = (
        hm.resistance(d, short().fluid)[0, 0]
        for d in (short().device, short(head=None).device, short(helix=None).device)
    )
    assert max(helix, head) < whole < 0.9 * (helix + head)


def test_handedness_is_a_mirror():
    """The mirror image of a device has the mirrored resistance."""
    left = short(head=None)
    right = short(head=None).replaced({"device.helix.handedness": "right"})
    a, b = (hm.resistance(s.device, s.fluid) for s in (left, right))
    polar, axial = np.diag([1.0, 1.0, -1.0]), np.diag([-1.0, -1.0, 1.0])
    mirror = np.block([[polar, np.zeros((3, 3))], [np.zeros((3, 3)), axial]])
    size = np.sqrt(np.outer(np.diag(a), np.diag(a)))
    assert np.abs((mirror @ a @ mirror - b) / size).max() < 2e-3  # the triangles themselves are not mirrored
    assert a[0, 3] > 0.0 > b[0, 3]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"helix": None, "head": None}, ["device needs either a body, or a helix"]),
        ({"helix": None, "hydrodynamics": {"model": "lighthill"}}, ["device.hydrodynamics.model", "needs a helix"]),
        ({"hydrodynamics": {"model": "lighthill", "tolerance": 0.1}}, ["device.hydrodynamics.tolerance", "boundary"]),
        ({"hydrodynamics": {"model": "boundary", "tolerance": 1.5}}, ["tolerance", "between 0 and 1", "1.5"]),
        ({"head": None, "weight": {"head_density": "2 g/cm^3"}}, ["device.weight", "helix_density; got head_density"]),
        ({"weight": {"helix_density": "2 g/cm^3"}}, ["device.weight", "helix_density and head_density; got helix"]),
    ],
)
def test_what_does_not_go_together_is_said(changes, words):
    with pytest.raises(hm.InputError) as error:
        short(**changes)
    for word in words:
        assert word in str(error.value)


def test_tracking_needs_helix_and_head():
    with pytest.raises(hm.InputError, match="a helix and a head"):
        Shape.of(short(head=None).device)


# --------------------------------------------------------------------------------------------------------------- STL


@pytest.mark.parametrize("write", [write_binary, write_text])
def test_stl_body_with_its_pose(tmp_path, write):
    """A spheroid along the file's z, its centre away from the file's origin, comes out as the closed form."""
    mesh = head_surface(SpheroidHead(length=3.0, diameter=1.0), 3)
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # x to z, z to y
    path = write(tmp_path / "egg.stl", mesh.moved(turn, np.array([5.0, -2.0, 1.0])).corners)
    pose = {"origin": ["5 mm", "-2 mm", "1 mm"], "long_axis": [0, 0, 2], "moment_axis": [1, 0, 0]}
    scenario = body_scenario(path, **pose).replaced({"device.hydrodynamics.tolerance": 0.05})
    matrix = hm.resistance(scenario.device, scenario.fluid)
    exact = spheroid(1.5e-3, 0.5e-3, MU)
    assert np.abs(matrix - exact).max() / exact.max() < 5e-3
    np.testing.assert_allclose(np.diag(matrix), np.diag(exact), rtol=5e-3)
    assert abs(scenario.device.front - 1.5e-3) < 5e-5
    assert abs(scenario.device.tail_length - 1.5e-3) < 5e-5
    assert abs(scenario.device.head_radius - 0.5e-3) < 2e-5
    assert not violates(matrix, enclosing_resistance(scenario.device, scenario.fluid))
    nose_forward = body_scenario(path, **(pose | {"origin": ["5 mm", "-2 mm", "2 mm"]})).device
    assert abs(nose_forward.front - 0.5e-3) < 5e-5


def test_scenario_file_beside_its_mesh(tmp_path, monkeypatch):
    (tmp_path / "set").mkdir()
    write_binary(tmp_path / "set" / "ball.stl", sphere(2).corners)
    scenario = body_scenario(tmp_path / "set" / "ball.stl")
    text = scenario.to_toml().replace(str(tmp_path / "set" / "ball.stl"), "ball.stl")
    (tmp_path / "set" / "run.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    read = hm.load("set/run.toml").device.body
    assert read.sha256 == scenario.device.body.sha256
    assert read.corners.shape == (80, 3, 3)
    write_binary(tmp_path / "set" / "ball.stl", 2.0 * sphere(2).corners)
    with pytest.raises(hm.FileError, match="has changed"):
        _ = hm.load("set/run.toml").device.body.corners


def test_unreadable_stl_is_refused(tmp_path):
    with pytest.raises(hm.FileError, match=r"device\.body\.file: there is no file '.*nowhere\.stl'"):
        body_scenario(tmp_path / "nowhere.stl")
    for content in (b"", b"solid but not\n", b"\x00" * 200, b"\xff" * 3000):
        (tmp_path / "no.stl").write_bytes(content)
        with pytest.raises(hm.InputError, match=r"device\.body\.file .*no\.stl"):
            _ = body_scenario(tmp_path / "no.stl").device.body.corners
    path = write_binary(tmp_path / "ball.stl", sphere(2).corners)
    (tmp_path / "half.stl").write_bytes(path.read_bytes()[:2000])
    with pytest.raises(hm.InputError, match=r"half\.stl holds no .* STL of 80 triangles it needs 4084 bytes, not 2000"):
        _ = body_scenario(tmp_path / "half.stl").device.body.corners
    with pytest.raises(hm.InputError, match="right angles"):
        body_scenario(path, long_axis=[1, 1, 0])


def two_balls(gap):
    return np.concatenate([sphere(2).corners, sphere(2).corners + np.array([gap, 0.0, 0.0])])


def test_wire_begins_behind_the_head():
    device = short().device
    mesh = next(device_surfaces(device))
    wire, head = (mesh.corners[mesh.part == k] for k in (0, 1))
    reach = device.head.reach
    assert -reach < wire[:, :, 0].max() < -reach + device.helix.wire_radius
    assert abs(head[:, :, 0].max() - reach) < 0.1 * reach


def test_surfaces_of_devices_are_closed():
    wire = next(device_surfaces(short(head=None).device))
    assert checked(wire.corners, "wire").part.max() == 0
    cylinder = {"shape": "cylinder", "length": "1 mm", "diameter": "2 mm"}
    assert len(checked(next(device_surfaces(short(helix=None, head=cylinder).device)).corners, "head")) > 100


def inside_out_beside():
    """A ball, and a smaller one beside it that faces inwards."""
    ball = sphere(2).corners
    return np.concatenate([ball, 0.5 * ball[:, ::-1] + np.array([3.0, 0.0, 0.0])])


def test_closed_surfaces_pass():
    assert checked(sphere(2).corners, "ball").part.max() == 0
    assert checked(two_balls(2.5), "pair").part.max() == 1
    speck = 5e-4 * sphere(2).corners + np.array([3.0, 0.0, 0.0])
    assert checked(np.concatenate([sphere(2).corners, speck]), "a ball and a speck").part.max() == 1


@pytest.mark.parametrize("off", [0.0, 1e-9])
def test_slivers_between_triangles_are_left_out(off):
    """As CAD programs write a corner on a neighbour's edge: a triangle whose corners lie on a line closes the gap."""
    ball = sphere(2).corners
    a, b, c = ball[0]
    middle = (a + b) / 2.0 + off * c
    split = np.array([[a, middle, c], [middle, b, c], [a, b, middle]])
    mesh = checked(np.concatenate([ball[1:], split]), "ball.stl")
    assert len(mesh) == len(ball) + 1
    expected = surface_resistance(checked(np.concatenate([ball[1:], ball[:1]]), "ball.stl"))
    np.testing.assert_allclose(np.diag(surface_resistance(mesh)), np.diag(expected), rtol=2e-3)


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        (sphere(2).corners[1:], ["is open", "3 edges"]),
        (sphere(1).corners[:1, [[0, 1, 2], [0, 2, 1]]][0], ["encloses nothing"]),
        (sphere(1).corners[:2, [0, 0, 0]], ["encloses nothing"]),
        (np.ones((4, 3, 3)), ["encloses nothing", "at one place"]),
        (sphere(2).corners[:, ::-1], ["is inside out", "-4.19 m^3"]),
        (np.concatenate([sphere(2).corners[1:], sphere(2).corners[:1, ::-1]]), ["partly inside out", "3 edges"]),
        (inside_out_beside(), ["2 pieces", "inside out", "cavity"]),
        (two_balls(1.5), ["crosses itself", "pairs of triangles"]),
        (np.concatenate([sphere(2).corners, sphere(2).corners[:1]]), ["three or more", "3 edges"]),
    ],
    ids=["open", "flat", "points", "one point", "inside out", "one face turned", "one piece", "crossing", "face twice"],
)
def test_bad_surfaces_are_refused_with_what_is_wrong(corners, words):
    with pytest.raises(hm.InputError) as error:
        checked(corners, "body.stl")
    for word in ("body.stl", *words):
        assert word in str(error.value)


def test_mesh_too_fine_for_the_solver_is_refused(tmp_path):
    path = write_binary(tmp_path / "fine.stl", sphere(16).corners)
    with pytest.raises(hm.InputError, match="fewer triangles"):
        hm.resistance(body_scenario(path).device, short().fluid)


# -------------------------------------------------------------------------------------------------------------- cache


def counted(monkeypatch):
    calls = []
    solve = cache.refined

    def counting(*arguments):
        calls.append(1)
        return solve(*arguments)

    monkeypatch.setattr(cache, "refined", counting)
    return calls


def test_solved_once_for_every_viscosity(monkeypatch, empty_cache):
    calls = counted(monkeypatch)
    scenario = short(helix=None)
    first = hm.resistance(scenario.device, scenario.fluid)
    cache._memory.clear()
    again = hm.resistance(scenario.device, scenario.fluid)
    assert np.array_equal(first, again)
    thicker = scenario.replaced({"fluid.viscosity": 2 * MU, "device.weight.net_weight": "1 uN"})
    np.testing.assert_allclose(hm.resistance(thicker.device, thicker.fluid), 2 * first, rtol=1e-15)
    assert len(calls) == len(list(empty_cache.iterdir())) == 1
    assert [p.suffix for p in empty_cache.iterdir()] == [".json"]


def test_folder_is_the_users(monkeypatch, tmp_path):
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    if sys.platform == "linux":
        assert cache.folder() == tmp_path / "helimag" / "resistance"
    assert cache.folder().name == "resistance"


def test_other_shape_tolerance_or_plane_is_another_solution(monkeypatch):
    calls = counted(monkeypatch)
    device = short(helix=None).device
    boundary.solution(device)
    boundary.solution(device, boundary.Plane("floor", (0.0, 0.0, 1.0), 1e-3))
    boundary.solution(device, boundary.Plane("floor", (0.0, 0.0, 1.0), 2e-3))
    boundary.solution(device, boundary.Plane("surface", (0.0, 0.0, 1.0), 1e-3))
    boundary.solution(short(helix=None, hydrodynamics={"model": "boundary", "tolerance": 0.04}).device)
    boundary.solution(short(helix=None, head={"shape": "sphere", "radius": "0.4 mm"}).device)
    assert len(calls) == 6
    boundary.solution(device)
    assert len(calls) == 6


@pytest.mark.parametrize("content", ["", "{}", "not json", '{"resistance": [[1]]}', "[" * 100_000, "half", "a digit"])
def test_broken_cache_file_is_solved_again(monkeypatch, empty_cache, content):
    calls = counted(monkeypatch)
    device = short(helix=None).device
    found = boundary.solution(device)
    (path,) = empty_cache.iterdir()
    whole = path.read_text()
    changed = {"half": whole[: len(whole) // 2], "a digit": whole.replace("1", "2", 1)}
    path.write_text(changed.get(content, content))
    cache._memory.clear()
    assert np.array_equal(boundary.solution(device).resistance, found.resistance)
    assert len(calls) == 2
    assert path.read_text() == whole


def test_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "file" / "resistance")
    assert boundary.solution(short(helix=None).device).error_estimate < 0.05
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_estimate_covers_the_true_error():
    for head, exact in (
        ({"shape": "sphere", "radius": "1 mm"}, ball(1e-3, 1.0)),
        ({"shape": "spheroid", "length": "4 mm", "diameter": "1 mm"}, spheroid(2e-3, 0.5e-3, 1.0)),
        ({"shape": "spheroid", "length": "1 mm", "diameter": "3 mm"}, spheroid(0.5e-3, 1.5e-3, 1.0)),
    ):
        solution = boundary.solution(short(helix=None, head=head).device)
        error = np.abs(np.diag(solution.resistance) / np.diag(exact) - 1.0).max()
        assert error < solution.error_estimate < 0.05


def test_levels_are_the_surfaces_own_resistance():
    device = short(helix=None).device
    solution = boundary.solution(device)
    for level, mesh in zip(solution.levels, device_surfaces(device), strict=False):
        np.testing.assert_allclose(level, surface_resistance(mesh), rtol=1e-9, atol=1e-16)
    assert solution.triangles == (180, 320)
