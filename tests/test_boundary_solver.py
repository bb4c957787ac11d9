"""The boundary solver against closed forms: balls, spheroids, cylinders, pairs of balls, walls and free surfaces."""

import numpy as np
import pytest

from helimag.errors import InputError
from helimag.hydrodynamics.boundary import solve
from helimag.hydrodynamics.boundary.kernels import floor_image, stokeslet, surface_image
from helimag.hydrodynamics.boundary.mesh import Mesh, bisected, halved, joined, quartered
from helimag.hydrodynamics.boundary.refine import extrapolated, refined, relative_difference
from helimag.hydrodynamics.boundary.single_layer import galerkin_matrix, image_matrix
from helimag.hydrodynamics.boundary.solve import Plane, surface_resistance
from helimag.hydrodynamics.boundary.surfaces import head_surface, sphere
from helimag.hydrodynamics.boundary.triangles import stokeslet_mean
from helimag.hydrodynamics.heads import ball, spheroid
from helimag.scenario import CylinderHead, SpheroidHead

UP = (0.0, 0.0, 1.0)


def moved(mesh, shift):
    return mesh.moved(np.eye(3), np.array(shift))


def two_resolutions(surface, plane=None):
    """Coarse, fine and extrapolated resistance."""
    coarse, fine = surface(3), surface(5)
    pair = [surface_resistance(mesh, plane) for mesh in (coarse, fine)]
    return (*pair, extrapolated(*pair, (len(fine) / len(coarse)) ** 0.5))


def test_stokeslet_over_a_triangle():
    """Against the same integral by brute force, from points above, beside and far from a skewed triangle."""
    corners = np.array([[0.1, 0.0, 0.2], [1.3, 0.2, -0.1], [0.4, 0.9, 0.5]])
    points = np.array([[0.6, 0.3, 0.9], [2.0, -0.5, 0.1], [-0.3, 0.6, 0.0], [0.6, 0.4, 0.21], [5.0, 3.0, -4.0]])
    n = 400
    i, j = np.divmod(np.arange(n * n), n)
    keep = i + j < n
    low = np.stack([i[keep] + 1 / 3, j[keep] + 1 / 3], axis=1) / n
    high = np.stack([i[i + j < n - 1] + 2 / 3, j[i + j < n - 1] + 2 / 3], axis=1) / n
    u, v = np.concatenate([low, high]).T[:, :, None]
    places = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0])
    for point in points:
        r = places - point
        size = np.linalg.norm(r, axis=1)[:, None, None]
        brute = (np.eye(3) / size + r[:, :, None] * r[:, None, :] / size**3).mean(axis=0)
        np.testing.assert_allclose(stokeslet_mean(point[None], corners[None])[0], brute, atol=2e-3 * brute.max())
    r = points[-1] - corners.mean(axis=0)
    np.testing.assert_allclose(  # and from 7 sizes away much closer to a point's
        stokeslet_mean(points[-1:], corners[None])[0],
        np.eye(3) / np.linalg.norm(r) + np.outer(r, r) / np.linalg.norm(r) ** 3,
        rtol=0.02,
    )


def test_stokeslet_from_a_place_on_an_edge():
    """On an edge, on its line, at a corner: the limit beside it, as where a flat head meets the end of the wire."""
    corners = np.array([[-0.5, -0.3, 0.2], [0.7, -0.3, 0.2], [0.1, 0.9, 0.2]])
    places = np.array([[0.1, -0.3, 0.2], [0.4, -0.3, 0.2], [0.7, -0.3, 0.2], [1.7, -0.3, 0.2], [-2.0, -0.3, 0.2]])
    many = np.repeat(corners[None], len(places), axis=0)
    found = stokeslet_mean(places, many)
    beside = stokeslet_mean(places + np.array([0.0, 1e-7, 1e-7]), many)
    np.testing.assert_allclose(found, beside, atol=1e-5 * np.abs(beside).max())


def test_ease_hardly_changes_the_resistance(monkeypatch):
    with_it = surface_resistance(capsule())
    monkeypatch.setattr(solve, "EASE", 0.0)
    without = surface_resistance(capsule())
    assert 1e-9 < relative_difference(without, with_it) < 2e-4


def test_ball_and_its_order_of_convergence(monkeypatch):
    """0.1 % from 80 triangles on; the error falls with the third power of their size."""
    monkeypatch.setattr(solve, "EASE", 0.0)
    exact = np.diag(ball(1.0, 1.0))
    errors = [np.diag(surface_resistance(sphere(n))) / exact - 1.0 for n in (2, 4, 6)]
    drag = np.array([error[0] for error in errors])
    assert np.abs(errors[1:]).max() < 5e-4
    orders = np.log(drag[:-1] / drag[1:]) / np.log([2.0, 1.5])
    np.testing.assert_allclose(orders, 3.05, atol=0.15)
    np.testing.assert_allclose(np.diag(two_resolutions(sphere)[2]), exact, rtol=1e-3)


@pytest.mark.parametrize("ratio", [0.3, 0.6, 2.0, 5.0])
def test_spheroids(ratio):
    """Within half a percent, extrapolated too; the estimated error covers the true one."""
    head = SpheroidHead(length=2.0 * ratio, diameter=2.0)
    exact = np.diag(spheroid(ratio, 1.0, 1.0))
    solution = refined((head_surface(head, n) for n in (3, 4, 6)), 0.02)
    for matrix in (solution.levels[-1], solution.resistance):
        np.testing.assert_allclose(np.diag(matrix), exact, rtol=5e-3)
    assert np.abs(np.diag(solution.resistance) / exact - 1.0).max() < solution.error_estimate


def stimson_jeffery(gap):
    """Drag of each of two balls of radius 1, ``gap`` between centres, that move together along the line of centres.

    Over 6 pi mu: M. Stimson and G. B. Jeffery, Proc. R. Soc. A 111 (1926) 110.
    """
    a = np.arccosh(gap / 2.0)
    n = np.arange(1, 40)
    two = 2 * n + 1
    term = 4 * np.sinh((n + 0.5) * a) ** 2 - two**2 * np.sinh(a) ** 2
    term /= 2 * np.sinh(two * a) + two * np.sinh(2 * a)
    return 4 / 3 * np.sinh(a) * np.sum(n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (1 - term))


def brenner(height, kind):
    """Drag of a ball of radius 1 that moves straight to a plane at distance ``height``, over 6 pi mu.

    H. Brenner, Chem. Eng. Sci. 16 (1961) 242, eq. 2.19 for a wall and 3.13 for a free surface.
    """
    a = np.arccosh(height)
    n = np.arange(1, 40)
    two = 2 * n + 1
    if kind == "floor":
        top = 2 * np.sinh(two * a) + two * np.sinh(2 * a)
        term = top / (4 * np.sinh((n + 0.5) * a) ** 2 - two**2 * np.sinh(a) ** 2)
    else:
        top = 4 * np.cosh((n + 0.5) * a) ** 2 + two**2 * np.sinh(a) ** 2
        term = top / (2 * np.sinh(two * a) - two * np.sinh(2 * a))
    return 4 / 3 * np.sinh(a) * np.sum(n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (term - 1))


def test_oracles_far_away():
    """First reflections: 1 - 3/2 / gap for a pair, 1 + 9/8 / h for a wall, 1 + 3/4 / h for a free surface."""
    assert abs(stimson_jeffery(100.0) - 1.0 + 1.5e-2) < 3e-4
    assert abs(brenner(100.0, "floor") - 1.0 - 9 / 8e2) < 2e-4
    assert abs(brenner(100.0, "surface") - 1.0 - 3 / 4e2) < 2e-4


@pytest.mark.parametrize("gap", [2.5, 4.0])
def test_two_balls(gap):
    def pair(n):
        return joined([moved(sphere(n), (-gap / 2, 0.0, 0.0)), moved(sphere(n), (gap / 2, 0.0, 0.0))])

    _, fine, best = two_resolutions(pair)
    expected = 2 * 6 * np.pi * stimson_jeffery(gap)
    assert abs(fine[0, 0] / expected - 1.0) < 2e-3
    assert abs(best[0, 0] / expected - 1.0) < 1e-3


@pytest.mark.parametrize("kind", ["floor", "surface"])
@pytest.mark.parametrize("height", [1.5, 3.0])
def test_ball_moving_straight_to_a_plane(kind, height):
    coarse, fine, best = two_resolutions(sphere, Plane(kind, UP, height))
    expected = 6 * np.pi * brenner(height, kind)
    assert abs(fine[2, 2] / expected - 1.0) < 1e-2
    assert abs(best[2, 2] / expected - 1.0) < 5e-3
    assert abs(best[2, 2] / expected - 1.0) < 2.0 * relative_difference(fine, best) + 1e-4
    assert abs(coarse[2, 2] / expected - 1.0) > abs(fine[2, 2] / expected - 1.0)


# A. J. Goldman, R. G. Cox, H. Brenner, Chem. Eng. Sci. 22 (1967) 637: height, drag along the wall, torque of a spin
GOLDMAN = [(3.7622, 1.1738, 1.0059), (2.3524, 1.3079, 1.0250), (1.5431, 1.5675, 1.0998)]


@pytest.mark.parametrize(("height", "drag", "torque"), GOLDMAN)
def test_ball_moving_along_a_wall(height, drag, torque):
    matrix = surface_resistance(sphere(5), Plane("floor", UP, height))
    assert abs(matrix[0, 0] / (6 * np.pi * drag) - 1.0) < 5e-3
    assert abs(matrix[3, 3] / (8 * np.pi * torque) - 1.0) < 5e-3


def test_ball_moving_along_a_free_surface():
    """As one of two balls side by side: D. J. Jeffrey and Y. Onishi, J. Fluid Mech. 139 (1984) 261, eq. 4.11."""
    height = 2.0
    series = [1.0, 3 / 2, 9 / 4, 59 / 8, 465 / 16, 2259 / 32, 14745 / 64]
    expected = sum(f * (-1) ** k / (4.0 * height) ** k for k, f in enumerate(series))
    matrix = surface_resistance(sphere(5), Plane("surface", UP, height))
    assert abs(matrix[0, 0] / (6 * np.pi) / expected - 1.0) < 3e-3


def test_free_surface_is_a_mirror():
    """A body under a surface is half of it and its mirror image in open water, in mirrored motions."""
    body = moved(head_surface(SpheroidHead(length=3.0, diameter=1.0), 2), (0.0, 0.3, -0.2))
    plane = Plane("surface", UP, 1.1)
    flip = np.array([1.0, 1.0, -1.0])
    above = moved(body, (0.0, 0.0, 1.1))
    image = Mesh((above.corners * flip)[:, ::-1], above.part)
    green = galerkin_matrix(joined([above, image])) / (8 * np.pi)
    n = len(body)
    half = green[:, :n, :, :n] + green[:, :n, :, n:] * flip[:, None]
    motion = np.zeros((3, n, 6))
    for k, axis in enumerate(np.eye(3)):
        motion[k, :, k] = 1.0
        motion[:, :, 3 + k] = np.cross(axis, body.centroids).T
    motion = motion.reshape(3 * n, 6)
    expected = motion.T @ np.linalg.lstsq(half.reshape(3 * n, 3 * n), motion, rcond=1e-8)[0]
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((surface_resistance(body, plane) - expected) / size).max() < 1e-3


def test_flow_keeps_what_the_plane_demands():
    """No velocity on the floor; on the surface none through it and no shear."""
    rng = np.random.default_rng(3)
    x, y, depth = rng.normal(size=(3, 20))
    depth = np.abs(depth) + 0.2

    def flow(kernel, z):
        return np.array(stokeslet(x.copy(), y.copy(), z - depth)) + np.array(kernel(x, y, z, depth))

    ground = np.zeros(20)
    assert np.abs(flow(floor_image, ground)).max() < 1e-13
    assert np.abs(flow(surface_image, ground)[2]).max() < 1e-13
    shear = (flow(surface_image, ground + 1e-4) - flow(surface_image, ground - 1e-4))[:2]
    assert np.abs(shear).max() < 1e-10


def test_floor_image_is_a_stokes_flow_with_reciprocity():
    """No divergence, and the flow at x from y is that at y from x transposed."""
    at, source, step = np.array([0.3, -0.4, 0.7]), np.array([-0.2, 0.1, 1.3]), 1e-4

    def image(p, q):
        return np.array(floor_image(*(np.array(v) for v in (p[0] - q[0], p[1] - q[1], p[2], q[2]))))

    np.testing.assert_allclose(image(at, source), image(source, at).T, atol=1e-14)
    steps = step * np.eye(3)
    divergence = sum((image(at + h, source) - image(at - h, source))[k] for k, h in enumerate(steps)) / (2 * step)
    assert np.abs(divergence).max() < 1e-7


def cylinder(length, divisions):
    return head_surface(CylinderHead(length=length, diameter=2.0), divisions)


def test_cylinder_beside_a_wall():
    """A piece of a long one: torque 4 pi / sqrt(1 - 1/h^2), drag 4 pi / arccosh h across, each per length.

    D. J. Jeffrey and Y. Onishi, Q. J. Mech. Appl. Math. 34 (1981) 129. The ends drop out of the difference.
    """
    height = 1.6
    plane = Plane("floor", UP, height)
    short, long = (surface_resistance(cylinder(length, 2), plane) for length in (8.0, 12.0))
    per_length = (long - short) / 4.0
    assert abs(per_length[3, 3] / (4 * np.pi / np.sqrt(1 - height**-2)) - 1.0) < 0.015
    assert abs(per_length[1, 1] / (4 * np.pi / np.arccosh(height)) - 1.0) < 0.015


def test_long_cylinder():
    """J. B. Keller and S. I. Rubinow, J. Fluid Mech. 75 (1976) 705: in powers of e = 1/ln(length/radius) the drag is
    e + 0.80685 e^2 + 0.82854 e^3 along and e - 0.19315 e^2 + 0.21466 e^3 across; here as its reciprocal, for length 60.
    Spin takes 4 pi a^2 per length.
    """
    matrix, longer = (surface_resistance(cylinder(length, 1)) for length in (60.0, 64.0))
    e = 1.0 / np.log(60.0)
    along = 2 * np.pi * 60.0 / (1 / e - 0.80685 - (0.82854 - 0.80685**2) * e)
    across = 4 * np.pi * 60.0 / (1 / e + 0.19315 - (0.21466 - 0.19315**2) * e)
    assert abs(matrix[0, 0] / along - 1.0) < 0.025
    assert abs(matrix[1, 1] / across - 1.0) < 0.025
    assert abs((longer - matrix)[3, 3] / (16 * np.pi) - 1.0) < 0.005


def capsule(n=2):
    return moved(head_surface(SpheroidHead(length=3.0, diameter=1.0), n), (0.4, -0.2, 0.1))


@pytest.mark.parametrize("plane", [None, Plane("floor", (0.6, 0.0, 0.8), 2.0), Plane("surface", (0.6, 0.0, 0.8), 2.0)])
def test_symmetric_positive_definite(plane):
    matrix = surface_resistance(capsule(), plane)
    assert np.array_equal(matrix, matrix.T) or np.abs(matrix - matrix.T).max() < 1e-12 * matrix.max()
    assert np.linalg.eigvalsh(matrix).min() > 0.0
    image = {None: None, "floor": floor_image, "surface": surface_image}[plane and plane.kind]
    lifted = moved(capsule(), (0.0, 0.0, 2.0))
    green = galerkin_matrix(lifted) if image is None else image_matrix(lifted, image)
    green = green.reshape(3 * len(lifted), -1)
    assert np.array_equal(green, green.T)


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1, 0, 0], [0, s, c], [0, -c, s]])


def test_turned_with_its_plane_the_body_feels_the_same():
    body, turn = capsule(), turned(0.7)
    normal = np.array([0.6, 0.0, 0.8])
    both = np.kron(np.eye(2), turn)
    for plane, other in (
        (None, None),
        (Plane("floor", tuple(normal), 1.9), Plane("floor", tuple(turn @ normal), 1.9)),
    ):
        expected = both @ surface_resistance(body, plane) @ both.T
        np.testing.assert_allclose(surface_resistance(body.moved(turn, np.zeros(3)), other), expected, atol=1e-9)


def test_scales_with_size():
    body = capsule()
    small = Mesh(1e-4 * body.corners, body.part)
    scale = np.repeat([1e-2, 1e-6], 3)
    ours, expected = surface_resistance(small) / np.outer(scale, scale), surface_resistance(body)
    np.testing.assert_allclose(ours, expected, atol=1e-10 * expected.max())


def test_halved_triangles_are_the_same_surface():
    body = capsule()
    finest = bisected(body, 0.2)
    assert len(finest) > 3 * len(body)
    assert np.linalg.norm(np.roll(finest.corners, -1, axis=1) - finest.corners, axis=2).max() <= 0.2
    for fine, times in ((finest, None), (halved(body), 2), (quartered(body), 4)):
        assert times is None or len(fine) == times * len(body)
        assert abs(fine.volume - body.volume) < 1e-12
        area = np.linalg.norm(fine.area_vectors, axis=1).sum()
        assert abs(area - np.linalg.norm(body.area_vectors, axis=1).sum()) < 1e-12
        np.testing.assert_allclose(fine.area_vectors.sum(axis=0), 0.0, atol=1e-13)


def test_extrapolation():
    """Exact for errors of order 3/2 in the logarithm; the result stays positive definite whatever the two are."""
    rng = np.random.default_rng(5)
    root = rng.normal(size=(6, 6))
    exact = root @ root.T + np.eye(6)
    np.testing.assert_allclose(extrapolated(1.08 ** (2**1.5) * exact, 1.08 * exact, 2.0), exact, rtol=1e-12)
    wild = extrapolated(exact, 0.2 * exact, 1.3)
    assert np.linalg.eigvalsh(wild).min() > 0.0


def test_tolerance_out_of_reach_is_said():
    with pytest.raises(InputError, match=r"tolerance of 1e-09 is not reached with 4600 .* estimated error is 0\.00"):
        refined((sphere(n) for n in (2, 3, 16)), 1e-9)


def test_body_in_the_wall_is_refused():
    with pytest.raises(InputError, match="through the floor"):
        surface_resistance(sphere(2), Plane("floor", UP, 0.9))
