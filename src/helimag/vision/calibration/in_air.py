"""What pictures in air tell: intrinsics, and where the second camera stands. The algorithms are OpenCV's."""

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision._cv import cv2
from helimag.vision.calibration.pictures import Corners, Found, common
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
from helimag.vision.cameras import Camera

Floats = NDArray[np.float64]


def intrinsics(session: Session, seen: dict[str, Corners], size: tuple[int, int]) -> tuple[Floats, Floats, float]:
    points = [session.board.corners[numbers].astype(np.float32) for numbers, _ in seen.values()]
    pixels = [found.astype(np.float32) for _, found in seen.values()]
    rms, matrix, distortion, _, _ = cv2.calibrateCamera(points, pixels, size, None, None, flags=cv2.CALIB_FIX_K3)
    return np.asarray(matrix, dtype=np.float64), np.asarray(distortion, dtype=np.float64).ravel()[:5], float(rms)


def misfit(session: Session, seen: dict[str, Corners], matrix: Floats, distortion: Floats) -> float:
    """By how much a known lens puts the corners of the pictures in air elsewhere (px, root mean square)."""
    squares = []
    for numbers, pixels in seen.values():
        _, turn, shift = cv2.solvePnP(session.board.corners[numbers], pixels, matrix, distortion)
        back, _ = cv2.projectPoints(session.board.corners[numbers], turn, shift, matrix, distortion)
        squares.append(np.sum((back.reshape(-1, 2) - pixels) ** 2, axis=1))
    return float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else 0.0


def stereo(session: Session, found: Found, cameras: list[Camera], names: list[str]) -> Pose:
    """Pose of the second camera: from the first camera's frame to its own."""
    matched = [common(found[0]["air"][name], found[1]["air"][name]) for name in names]
    points = [session.board.corners[numbers].astype(np.float32) for numbers, _, _ in matched]
    one, two = cameras
    _, *_, rotation, translation, _, _ = cv2.stereoCalibrate(
        points,
        [first.astype(np.float32) for _, first, _ in matched],
        [second.astype(np.float32) for _, _, second in matched],
        one.matrix,
        one.distortion,
        two.matrix,
        two.distortion,
        one.size,
        flags=cv2.CALIB_FIX_INTRINSIC,
    )
    return Pose(np.asarray(rotation, dtype=np.float64), np.asarray(translation, dtype=np.float64).ravel())


def board_pose(session: Session, camera: Camera, corners: Corners) -> Pose:
    """From the board's frame to the camera's, light taken to go straight."""
    good, turn, shift = cv2.solvePnP(
        session.board.corners[corners[0]], corners[1], camera.matrix, camera.distortion, flags=cv2.SOLVEPNP_ITERATIVE
    )
    if not good:
        raise InputError(f"the board's pose cannot be found in a picture of camera {camera.name}")
    return Pose.from_six(np.concatenate([turn.ravel(), shift.ravel()]))
