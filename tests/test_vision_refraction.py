"""Light through walls: Snell's law against Fermat's principle and closed forms, forwards and backwards."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from helimag.errors import InputError
from helimag.vision import Rig, paper_rig
from helimag.vision.refraction import Wall, bend, nearest, sight, through

ORIGIN = np.zeros(3)


def wall(normal: tuple[float, float, float] = (0.0, 0.0, 1.0), distance: float = 0.3, thickness: float = 0.005) -> Wall:
    unit = np.array(normal) / np.linalg.norm(normal)
    return Wall(distance * unit, unit, thickness)


def fermat(point: np.ndarray, at: Wall) -> np.ndarray:
    """Direction in air of the path of least optical length: an oracle that knows nothing of sines."""
    one = np.cross(at.normal, [0.3, 0.5, 0.8])
    one /= np.linalg.norm(one)
    two = np.cross(at.normal, one)
    distance = float(at.point @ at.normal)

    def crossings(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first = distance * at.normal + q[0] * one + q[1] * two
        return first, (distance + at.thickness) * at.normal + q[2] * one + q[3] * two

    def length(q: np.ndarray) -> float:
        first, second = crossings(q)
        parts = (first, second - first, point - second)
        return 1e3 * sum(n * float(np.linalg.norm(part)) for n, part in zip(at.indices, parts, strict=True))

    start = [point @ one * 0.8, point @ two * 0.8, point @ one * 0.8, point @ two * 0.8]
    found = minimize(length, start, method="Powell", options={"xtol": 1e-12, "ftol": 1e-16, "maxiter": 20000})
    first, _ = crossings(found.x)
    return first / np.linalg.norm(first)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(x=st.floats(-0.1, 0.1), y=st.floats(-0.1, 0.1), depth=st.floats(0.001, 0.1), tilt=st.floats(-0.2, 0.2))
def test_sight_takes_the_path_of_least_optical_length(x: float, y: float, depth: float, tilt: float) -> None:
    leaning = wall((tilt, 0.3 * tilt, 1.0))
    point = np.array([x, y, 0.0])
    point = point - (point @ leaning.normal) * leaning.normal + (0.305 + depth) * leaning.normal
    # the optical length is flat at its least: its place is known to about 1e-7 rad
    assert np.abs(sight(ORIGIN, point, leaning) - fermat(point, leaning)).max() < 3e-6


@settings(max_examples=50, deadline=None, derandomize=True)
@given(x=st.floats(-0.2, 0.2), y=st.floats(-0.2, 0.2), depth=st.floats(0.0, 0.2))
def test_a_ray_sent_out_in_the_direction_of_sight_meets_the_point(x: float, y: float, depth: float) -> None:
    leaning = wall((0.1, -0.05, 1.0))
    point = np.array([x, y, 0.36 + depth])
    leaving, direction = through(ORIGIN, sight(ORIGIN, point, leaning), leaning)
    assert np.linalg.norm(np.cross(point - leaving, direction)) < 1e-12


def test_apparent_depth_is_depth_over_index() -> None:
    point = np.array([1e-6, 0.0, 0.345])  # 40 mm behind the wall, next to the normal
    direction = sight(ORIGIN, point, wall())
    assert direction[0] / direction[2] == pytest.approx(1e-6 / (0.3 + 0.005 / 1.49 + 0.04 / 1.40), rel=1e-9)


def test_equal_indices_do_not_bend() -> None:
    clear = Wall(np.array([0.0, 0.0, 0.3]), np.array([0.0, 0.0, 1.0]), 0.005, (1.0, 1.0, 1.0))
    point = np.array([0.05, -0.02, 0.4])
    assert np.allclose(sight(ORIGIN, point, clear), point / np.linalg.norm(point), atol=1e-14)


def test_sines_are_in_the_ratio_of_the_indices() -> None:
    incoming = np.array([np.sin(0.7), 0.0, np.cos(0.7)])
    bent = bend(incoming, np.array([0.0, 0.0, 1.0]), 1.0, 1.40)
    assert bent[0] == pytest.approx(np.sin(0.7) / 1.40, rel=1e-14)
    assert np.linalg.norm(bent) == pytest.approx(1.0, rel=1e-14)


def test_total_reflection_is_not_a_number() -> None:
    assert np.isnan(bend(np.array([np.sin(1.0), 0.0, np.cos(1.0)]), np.array([0.0, 0.0, 1.0]), 1.40, 1.0)).all()


def test_points_before_the_wall_are_not_seen() -> None:
    assert np.isnan(sight(ORIGIN, np.array([0.0, 0.01, 0.29]), wall())).all()


def test_nearest_point_of_two_rays() -> None:
    point, miss = nearest(
        (np.array([0.0, 0.0, 0.0]), np.array([0.0, 1.0, 2.0])), (np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    )
    assert np.allclose(point, [0.0, 0.0, 1.0])
    assert miss == pytest.approx(2.0)


def test_what_a_rig_sees_is_found_again() -> None:
    rig = paper_rig(seed=4)
    points = np.random.default_rng(0).uniform(rig.tank[0] + 0.01, rig.tank[1] - 0.003, (200, 3))
    found, miss = rig.triangulate(*(camera.project(points) for camera in rig.cameras))
    assert np.abs(found - points).max() < 1e-8
    assert miss.max() < 1e-8
    straight, _ = rig.without_refraction().triangulate(*(camera.project(points) for camera in rig.cameras))
    assert np.linalg.norm(straight - points, axis=1).max() > 2e-3


def test_rig_goes_through_its_file_unchanged(tmp_path) -> None:  # type: ignore[no-untyped-def]
    rig = paper_rig(seed=2)
    rig.save(tmp_path / "rig.json")
    again = Rig.load(tmp_path / "rig.json")
    point = np.array([[0.03, 0.01, -0.02]])
    for one, two in zip(rig.cameras, again.cameras, strict=True):
        assert np.array_equal(one.project(point), two.project(point))
    (tmp_path / "bad.json").write_text('{"cameras": []}')
    with pytest.raises(InputError, match="not a calibrated pair of cameras"):
        Rig.load(tmp_path / "bad.json")


@pytest.mark.parametrize(
    ("normal", "thickness", "indices"),
    [
        ([0.0, 0.0, 2.0], 0.005, (1.0, 1.49, 1.4)),
        ([0, 0, 1.0], -1.0, (1.0, 1.49, 1.4)),
        ([0, 0, 1.0], 0.005, (1.0, 0.9, 1.4)),
    ],
)
def test_impossible_walls_are_refused(
    normal: list[float], thickness: float, indices: tuple[float, float, float]
) -> None:
    with pytest.raises(InputError, match="wall"):
        Wall(np.zeros(3), np.array(normal), thickness, indices)
