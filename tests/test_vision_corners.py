"""Corners of the board, and what a calibration claims: right to a hundredth of a pixel, as uncertain as said."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("cv2")
pytest.importorskip("av")

import cv2

from helimag.vision import Board, Camera, Rig, Session, paper_rig
from helimag.vision.calibration.corners import refined
from helimag.vision.calibration.joint import BOARDS, INDEX, LENS, SECOND, THICKNESS, WALL_INDEX, WALLS, Fitted, Joint
from helimag.vision.calibration.pictures import Found
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import View
from helimag.vision.calibration.shared_errors import excess, widening
from helimag.vision.calibration.starts import _faces
from helimag.vision.synthetic.photographs import _alone, _in_tank

SIZE, TEXELS, FINE = 640, 120, 4
Floats = np.ndarray


def drawn(square: float, blur: float, tilt: float, noise: float, random: np.random.Generator) -> tuple[Floats, Floats]:
    """A picture of the board and where its corners are (35, 2): a homography drawn on a grid four times as fine, each
    pixel the mean of its share."""
    board = Board()
    sheet = cv2.copyMakeBorder(board.picture(TEXELS), *[TEXELS] * 4, cv2.BORDER_CONSTANT, value=255)
    sheet = cv2.GaussianBlur(sheet, (0, 0), max(0.3, 0.25 * TEXELS / square))
    angle = random.uniform(-0.4, 0.4)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    plane = square * turn @ np.diag([1.0, np.cos(tilt)])
    to_picture = np.eye(3)
    to_picture[:2, :2] = plane
    to_picture[:2, 2] = SIZE / 2.0 - plane @ [4.0, 3.0] + random.uniform(-0.5, 0.5, 2)
    to_picture[2, :2] = 0.01 * np.sin(tilt) * np.array([0.5, 1.0])
    from_texels = np.array([[1.0, 0.0, 0.5 - TEXELS], [0.0, 1.0, 0.5 - TEXELS], [0.0, 0.0, TEXELS]])
    to_fine = np.array([[FINE, 0.0, (FINE - 1) / 2.0], [0.0, FINE, (FINE - 1) / 2.0], [0.0, 0.0, 1.0]])
    fine = cv2.warpPerspective(
        sheet.astype(np.float32), to_fine @ to_picture @ from_texels, (FINE * SIZE, FINE * SIZE), borderValue=90.0
    )
    picture = cv2.GaussianBlur(40.0 + 0.6 * cv2.resize(fine, (SIZE, SIZE), interpolation=cv2.INTER_AREA), (0, 0), blur)
    picture = np.clip(picture + random.normal(0.0, noise, picture.shape) + 0.5, 0, 255).astype(np.uint8)
    return picture, cv2.perspectiveTransform((board.corners[:, :2] / board.square)[None], to_picture)[0]


@pytest.mark.parametrize(
    ("square", "blur", "tilt", "within"), [(45.0, 0.7, 0.0, 0.013), (30.0, 0.7, 0.8, 0.013), (55.0, 1.8, 0.3, 0.03)]
)
def test_corners_are_found_to_a_hundredth_of_a_pixel(square: float, blur: float, tilt: float, within: float) -> None:
    random = np.random.default_rng(2)
    errors, places = [], []
    for _ in range(5):
        picture, corners = drawn(square, blur, tilt, 2.0, random)
        numbers, pixels = Board().find(picture)
        assert numbers.size > 15
        errors.append(pixels - corners[numbers])
        places.append(corners[numbers] % 1.0)
    off, phase = np.concatenate(errors), 2.0 * np.pi * np.concatenate(places)
    assert np.all(off.std(axis=0) < within)
    assert np.abs(off).max() < 5.0 * within
    assert np.abs(off.mean(axis=0)).max() < 4.0 * within / np.sqrt(off.shape[0])
    swing = 2.0 * np.mean(off * np.sin(phase), axis=0)  # with the place on the grid of pixels
    assert np.abs(swing).max() < 4.0 * within * np.sqrt(2.0 / off.shape[0])


def test_what_is_no_corner_is_not_refined() -> None:
    random = np.random.default_rng(3)
    picture, corners = drawn(45.0, 0.7, 0.3, 2.0, random)
    found, known = refined(picture, corners + random.uniform(-1.0, 1.0, corners.shape))
    assert known.all()
    assert np.abs(found - corners).max() < 0.06
    assert not refined(picture, np.array([[3.0, 300.0], [300.0, SIZE - 4.0]]))[1].any()  # too near the edge
    assert not refined(np.full((60, 60), 120, np.uint8), np.array([[30.2, 29.7]]))[1].any()
    away, known = refined(picture, corners + 5.0)
    assert not np.any(known & (np.linalg.norm(away - corners, axis=1) < 2.0))


NOISE = 0.02  # px
OWN, IN_AIR, IN_OIL = 6, 3, 7
NUMBERS = np.arange(0, 35, 2)  # of the corners that are seen


def seen(rig: Rig, board: Board, random: np.random.Generator) -> tuple[Found, dict[str, Pose]]:
    """Where the board's corners are in the pictures of a session, without noise; and the boards' poses in the lab."""
    found: Found = [{"air": {}, "oil": {}} for _ in rig.cameras]
    poses: dict[str, Pose] = {}
    middle = np.array([board.columns, board.rows, 0]) * board.square / 2.0

    def show(view: int, kind: str, name: str, turn: Floats, place: Floats) -> None:
        camera = rig.cameras[view] if kind == "oil" else replace(rig.cameras[view], wall=None)
        poses[name] = Pose(turn, place - turn @ middle)
        found[view][kind][name] = (NUMBERS, camera.project(poses[name].of(board.corners[NUMBERS])))

    for view, camera in enumerate(rig.cameras):
        for number in range(OWN):
            show(view, "air", f"{camera.name}{number}", *_alone(camera, number, random))
    for number in range(IN_AIR + IN_OIL):
        pose = _in_tank(rig, board, middle, number, random)
        for view in (0, 1):
            show(view, "air" if number < IN_AIR else "oil", f"both{number}", *pose)
    return found, poses


def true_values(rig: Rig) -> Floats:
    """What all pictures share, as the joint fit has it, from the rig itself."""
    values = np.zeros(BOARDS)
    poses = [Pose(camera.rotation, camera.translation) for camera in rig.cameras]
    for view, camera in enumerate(rig.cameras):
        assert camera.wall is not None
        lens = [camera.matrix[0, 0], camera.matrix[1, 1], camera.matrix[0, 2], camera.matrix[1, 2]]
        values[LENS * view : LENS * (view + 1)] = [*lens, *camera.distortion[:4]]
        normal = camera.rotation @ camera.wall.normal
        distance = (camera.wall.point - camera.centre) @ camera.wall.normal
        values[WALLS + 3 * view : WALLS + 3 * view + 3] = [*(normal[:2] / normal[2]), distance]
        values[[WALL_INDEX, INDEX]] = camera.wall.indices[1:]
        values[THICKNESS + view] = camera.wall.thickness
    values[SECOND : SECOND + 6] = poses[1].after(poses[0].inverse).six
    return values


def chi_square(fitted: Fitted, truth: Floats) -> float:
    """A value: of all that pictures share, by the covariance that is claimed."""
    off, claimed = fitted.values[:BOARDS] - truth, fitted.covariance[:BOARDS, :BOARDS]
    size = np.sqrt(np.diag(claimed))
    return float((off / size) @ np.linalg.solve(claimed / np.outer(size, size), off / size)) / BOARDS


def noisy(found: Found, random: np.random.Generator) -> Found:
    return [
        {
            kind: {name: (n, at + NOISE * random.standard_normal(at.shape)) for name, (n, at) in pictures.items()}
            for kind, pictures in view.items()
        }
        for view in found
    ]


NAMES = {"air": [f"both{n}" for n in range(IN_AIR)], "oil": [f"both{n}" for n in range(IN_AIR, IN_AIR + IN_OIL)]}


def unplaced(rig: Rig) -> tuple[Camera, Camera]:
    first, second = (replace(camera, rotation=np.eye(3), translation=np.zeros(3)) for camera in rig.cameras)
    return first, second


def set_up(random: np.random.Generator) -> tuple[Rig, Found, Session, Floats]:
    """A rig aslant, where its boards' corners are without noise, its session, and the true values of the joint fit."""
    rig, board = paper_rig(seed=4, angle=np.radians(30.0)), Board()
    exact, poses = seen(rig, board, random)
    wall, datum = rig.cameras[0].wall, poses[f"both{IN_AIR}"]
    assert wall is not None
    one, two = (View(camera.name, Path(), Path(), 0.35) for camera in rig.cameras)
    session = Session(
        *((one, two), board, rig.tank, wall.thickness, wall.indices, False),
        *(f"both{IN_AIR}", datum.rotation, datum.translation, 1e-3),
        thickness_sd=0.5e-3,
        index_sds=(0.005, 0.002),
    )
    stands = [Pose(camera.rotation, camera.translation) for camera in rig.cameras]
    pictures = Joint(session, exact, unplaced(rig), NAMES).pictures
    boards = [stands[views[0]].after(poses[name]).six for _, name, views in pictures]
    return rig, exact, session, np.concatenate([true_values(rig), *boards])


def test_the_covariance_of_a_calibration_is_that_of_its_errors() -> None:
    """Corners with normal noise of a known size, and walls and oil that are not quite what is given: lenses, walls,
    indices, thicknesses and poses miss the truth as much as claimed."""
    random = np.random.default_rng(5)
    rig, exact, session, truth = set_up(random)
    wall, cameras = rig.cameras[0].wall, unplaced(rig)
    assert wall is not None
    assert np.abs(Joint(session, exact, cameras, NAMES).residuals(truth)).max() < 1e-6
    found, widened = [], 0
    for _ in range(5):
        given = replace(
            session,
            thickness=wall.thickness + session.thickness_sd * random.standard_normal(),
            indices=(1.0, *(np.array(wall.indices[1:]) + session.index_sds * random.standard_normal(2))),
        )
        problem = Joint(given, noisy(exact, random), cameras, NAMES)
        fitted = problem.fit(truth, oil_known=True, noise=NOISE)
        found.append(chi_square(fitted, truth[:BOARDS]))
        widened += problem.widened(fitted)[1] > 1.0
    # a mean of 5 x 32 squares is uncertain by 0.13, as both walls are off alike
    assert np.mean(found) == pytest.approx(1.0, abs=0.3)
    assert widened <= 1


def test_a_wall_that_is_not_what_is_given_moves_points_by_less_than_a_micrometre() -> None:
    """A millimetre of thickness, and a hundredth of the index: walls that lie elsewhere look nearly the same."""
    rig, exact, session, truth = set_up(np.random.default_rng(5))
    lab = Pose(session.rotation, session.position)
    axes = (np.linspace(0.02, 0.14, 4), np.linspace(-0.02, 0.02, 3), np.linspace(-0.03, 0.0, 3))
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    air, glass, oil = session.indices
    for change, limit in (
        ({"thickness": session.thickness + 1e-3}, 0.6e-6),
        ({"indices": (air, glass + 0.01, oil)}, 0.4e-6),
    ):
        given = replace(session, thickness_sd=1e-7, index_sds=(1e-6, 0.002), **change)
        problem = Joint(given, exact, unplaced(rig), NAMES)
        found = problem.rig(problem.fit(truth, oil_known=True, noise=NOISE).values, lab)
        off = found.triangulate(*(camera.project(points) for camera in rig.cameras))[0] - points
        size = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
        assert limit / 3.0 < size < limit


def test_chance_widens_nothing() -> None:
    """Independent errors: what they do by chance is within two standard deviations nineteen times of twenty."""
    random = np.random.default_rng(6)
    pictures, rows, shared, own = 30, 24, 6, 3
    jacobian = np.zeros((pictures * rows, shared + own * pictures))
    picture = np.repeat(np.arange(pictures), rows)
    jacobian[:, :shared] = random.standard_normal((pictures * rows, shared))
    for number in range(pictures):
        at = shared + own * number
        jacobian[picture == number, at : at + own] = random.standard_normal((rows, own))
    basis, _ = np.linalg.qr(jacobian)
    factors, more = [], []
    for _ in range(60):
        noise = random.standard_normal(picture.size)
        factors.append(widening(jacobian, noise - basis @ (basis.T @ noise), picture, shared))
        few = random.standard_normal((70, 6))
        alone = random.standard_normal(70)
        more.append(excess(few, alone - few @ np.linalg.lstsq(few, alone, rcond=None)[0], 1.0).any())
    assert np.sum(np.array(factors) > 1.0) <= 7
    assert np.sum(more) <= 7


def test_a_datum_that_seems_to_lean_the_other_way_is_seen_right_by_the_other_camera() -> None:
    """Seen through the wall as if there were none, this board is 33 deg off in the first view."""
    rig, board = paper_rig(seed=90, angle=np.radians(30.0)), Board()
    turn = Rotation.from_rotvec([-0.923, -0.211, -0.261]).as_matrix()
    place = 1e-3 * np.array([13.3, -2.6, -20.9])
    numbers = np.arange(35)
    found: Found = [
        {"air": {}, "oil": {"datum": (numbers, camera.project(Pose(turn, place).of(board.corners)))}}
        for camera in rig.cameras
    ]
    one, two = (View(camera.name, Path(), Path(), 0.35) for camera in rig.cameras)
    session = Session((one, two), board, rig.tank, 5e-3, (1.0, 1.49, 1.40), False, "datum", turn, place, 1e-3)
    first, second = (replace(camera, rotation=np.eye(3), translation=np.zeros(3), wall=None) for camera in rig.cameras)
    poses = [Pose(camera.rotation, camera.translation) for camera in rig.cameras]
    walls = _faces(session, found, (first, second), poses[1].after(poses[0].inverse))
    assert walls is not None
    for camera, (lean_x, lean_y, distance) in zip(rig.cameras, walls, strict=True):
        assert camera.wall is not None
        normal = camera.rotation @ camera.wall.normal
        assert [lean_x, lean_y] == pytest.approx(normal[:2] / normal[2], abs=0.02)
        assert distance == pytest.approx((camera.wall.point - camera.centre) @ camera.wall.normal, abs=2e-3)
