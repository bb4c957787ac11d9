"""Where the joint fit starts: lenses and extrinsics from air, walls from the tank's faces or the optical axes."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from helimag.errors import InputError
from helimag.vision.calibration.in_air import board_pose
from helimag.vision.calibration.joint import BOARDS, INDEX, LENS, SECOND, THICKNESS, WALL_INDEX, WALLS, Joint
from helimag.vision.calibration.pictures import Corners, Found
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
from helimag.vision.cameras import Camera
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]

GRAZING = 0.3  # cosine between optical axis and wall's normal below which a wall is not what a camera looks through
CLOSE = 5.0  # px of a start that is good enough
TRIES = 40  # evaluations of a single pose


def starting_values(problem: Joint, session: Session, found: Found, second: Pose) -> Floats:
    """Values near which the joint fit can be linearised, for cameras that look straight or aslant.

    Refraction at a slant turns lines of sight by ten degrees, so the boards' poses are fitted through the walls. The
    walls are the faces of the tank between it and the cameras, seen from the datum; or, should that fit worse, they
    stand across the optical axes at the distances given.
    """
    cameras = problem.cameras
    tried: list[tuple[float, Floats]] = []
    for walls in (_faces(session, found, cameras, second), _across(session)):
        if walls is not None and not (tried and tried[0][0] < CLOSE):
            values = _with_walls(problem, found, second, walls)
            tried.append((float(np.median(np.abs(problem.residuals(values)[problem.in_oil]))), values))
    return min(tried, key=lambda pair: pair[0])[1]


def _across(session: Session) -> list[Floats]:
    return [np.array([0.0, 0.0, view.distance]) for view in session.views]


def _faces(session: Session, found: Found, cameras: tuple[Camera, Camera], second: Pose) -> list[Floats] | None:
    """Walls that coincide with faces of the tank, with the pair of cameras posed by the datum seen through them.

    A flat board that one camera sees aslant looks much like one that leans the other way; then the other camera's view
    of it tells.
    """
    tried = []
    for view, to_first in ((0, Pose(np.eye(3), np.zeros(3))), (1, second.inverse)):
        seen = board_pose(session, cameras[view], found[view]["oil"][session.datum])
        lab = Pose(session.rotation, session.position)
        tried.append(_faces_from(session, found, cameras, second, to_first.after(seen).after(lab.inverse)))
        if tried[-1][0] < CLOSE:
            break
    return min(tried, key=lambda pair: pair[0])[1]


def _faces_from(
    session: Session, found: Found, cameras: tuple[Camera, Camera], second: Pose, first: Pose
) -> tuple[float, list[Floats] | None]:
    """The walls from a first guess of where the first camera stands, and by how much the datum fits (px, median)."""
    lab = Pose(session.rotation, session.position)
    corners = [found[view]["oil"][session.datum] for view in (0, 1)]
    walls = [_face_towards(session, pose.inverse.translation) for pose in (first, second.after(first))]

    def poses(values: Floats) -> tuple[Pose, Pose]:
        moved = Pose.from_six(values)
        return moved, second.after(moved)

    def misfits(values: Floats) -> Floats:
        return _seen_beside(session, cameras, corners, poses(values), walls, lab)

    result = least_squares(misfits, first.six, x_scale="jac", loss="soft_l1", f_scale=10.0, max_nfev=TRIES)
    misfit = float(np.median(np.abs(result.fun)))
    found_walls = []
    for pose, wall in zip(poses(result.x), walls, strict=True):
        normal = pose.rotation @ wall.normal
        distance = float((wall.point - pose.inverse.translation) @ wall.normal)
        if normal[2] < GRAZING or distance <= 0.0:
            return misfit, None
        found_walls.append(np.array([*(normal[:2] / normal[2]), distance]))
    return misfit, found_walls


def _face_towards(session: Session, place: Floats) -> Wall:
    """The wall on that face of the tank beyond which a place (3,) lies furthest."""
    low, high = session.tank
    beyond = np.concatenate([low - place, place - high])
    face = int(np.argmax(beyond))
    normal = np.zeros(3)
    normal[face % 3] = 1.0 if face < 3 else -1.0
    corner = low if face < 3 else high
    return Wall(corner - session.thickness * normal, normal, session.thickness, session.indices)


def _seen_beside(
    session: Session,
    cameras: tuple[Camera, Camera],
    corners: list[Corners],
    poses: tuple[Pose, Pose],
    walls: list[Wall],
    board: Pose,
) -> Floats:
    """Pixels by which a board's corners are seen beside where they should be, cameras and walls in one frame."""
    parts = []
    for camera, pose, wall, (numbers, pixels) in zip(cameras, poses, walls, corners, strict=True):
        placed = replace(camera, rotation=pose.rotation, translation=pose.translation, wall=wall)
        parts.append((placed.project(board.of(session.board.corners[numbers])) - pixels).ravel())
    return np.nan_to_num(np.concatenate(parts), nan=1e3)


def _with_walls(problem: Joint, found: Found, second: Pose, walls: list[Floats]) -> Floats:
    """All values, with every board fitted alone to what both cameras see of it."""
    session = problem.session
    values = np.zeros(BOARDS + 6 * len(problem.pictures))
    for view, camera in enumerate(problem.cameras):
        lens = [camera.matrix[0, 0], camera.matrix[1, 1], camera.matrix[0, 2], camera.matrix[1, 2]]
        values[LENS * view : LENS * (view + 1)] = [*lens, *camera.distortion[:4]]
        values[WALLS + 3 * view : WALLS + 3 * view + 3] = walls[view]
    values[SECOND : SECOND + 6] = second.six
    values[[WALL_INDEX, INDEX]] = session.indices[1:]
    values[THICKNESS : THICKNESS + 2] = session.thickness
    posed = (problem.camera(values, 0), problem.camera(values, 1))
    placed = [_wall_of(posed[0], Pose(np.eye(3), np.zeros(3))), _wall_of(posed[1], second)]
    for index, (kind, name, views) in enumerate(problem.pictures):
        camera = problem.cameras[views[0]]
        pose = board_pose(session, camera, found[views[0]][kind][name])
        if kind == "oil":
            corners = [found[view]["oil"][name] for view in (0, 1)]
            pose = _in_oil(session, problem.cameras, corners, second, placed, pose)
        values[BOARDS + 6 * index : BOARDS + 6 * index + 6] = pose.six
    return values


def _wall_of(camera: Camera, pose: Pose) -> Wall:
    """A camera's wall, which is in its own frame, in the first camera's; ``pose`` leads from there to the camera."""
    if camera.wall is None:
        raise InputError(f"camera {camera.name} must look through a wall")
    back = pose.inverse
    return replace(camera.wall, point=back.of(camera.wall.point), normal=back.rotation @ camera.wall.normal)


def _in_oil(
    session: Session,
    cameras: tuple[Camera, Camera],
    corners: list[Corners],
    second: Pose,
    walls: list[Wall],
    straight: Pose,
) -> Pose:
    """A board's pose behind the walls, from its pose were light to go straight: it looks nearer than it is."""
    depth = float(np.linalg.norm(straight.translation))
    behind = max(depth - float(walls[0].point @ walls[0].normal), 0.0) * (session.indices[2] - 1.0)
    start = Pose(straight.rotation, straight.translation * (1.0 + behind / depth))
    poses = (Pose(np.eye(3), np.zeros(3)), second)
    result = least_squares(
        lambda six: _seen_beside(session, cameras, corners, poses, walls, Pose.from_six(six)),
        start.six,
        x_scale="jac",
        loss="soft_l1",
        f_scale=10.0,
        max_nfev=TRIES,
    )
    return Pose.from_six(result.x)
