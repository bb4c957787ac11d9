"""Calibrate two cameras and the walls that they look through, from pictures of a board in air and in the tank."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from helimag.errors import InputError
from helimag.vision._cv import cv2
from helimag.vision.calibration.session import Session, read_pictures
from helimag.vision.cameras import Camera, Rig
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]
Corners = tuple[NDArray[np.int64], Floats]

HELD_OUT = 2  # pictures in the tank that the fit does not see
LEAST_AIR = 6
LEAST_OIL = 5
INDEX_RANGE = (1.2, 1.7)  # of liquids


@dataclass(frozen=True)
class Pose:
    """Rotation (3, 3) and translation (3,) from one frame to another (m)."""

    rotation: Floats
    translation: Floats

    def of(self, points: Floats) -> Floats:
        return np.asarray(points @ self.rotation.T + self.translation)

    def after(self, first: "Pose") -> "Pose":
        return Pose(self.rotation @ first.rotation, self.rotation @ first.translation + self.translation)

    @property
    def inverse(self) -> "Pose":
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    @property
    def six(self) -> Floats:
        return np.concatenate([Rotation.from_matrix(self.rotation).as_rotvec(), self.translation])

    @classmethod
    def from_six(cls, values: Floats) -> "Pose":
        return cls(np.asarray(Rotation.from_rotvec(values[:3]).as_matrix()), np.asarray(values[3:]))


@dataclass(frozen=True)
class Calibration:
    """A calibrated rig and how good it is; ``report`` has pixels and millimetres, ``warnings`` what to mind."""

    rig: Rig
    report: dict[str, Any]
    warnings: list[str]


def calibrate(
    session: Session, *, refraction: bool = True, progress: Callable[[float], None] | None = None
) -> Calibration:
    """Intrinsics from pictures in air, then extrinsics, walls and lab frame from pictures in air and in the tank.

    Intrinsics and first extrinsics are OpenCV's. Then one least-squares fit of all pictures that both cameras share, in
    air and in oil, gives the extrinsics, each wall's direction and distance, where asked for the oil's index, and every
    board's pose. Two pictures in the tank are held out, and the errors in millimetres are theirs.

    Parameters
    ----------
    refraction
        False: take light to go straight, each camera posed by the datum alone, as one would without a model of the
        wall.

    Raises
    ------
    InputError
        Where there are too few usable pictures.
    """
    watch = progress or (lambda _: None)
    board = session.board
    found: list[dict[str, dict[str, Corners]]] = []
    sizes = []
    for number, view in enumerate(session.views):
        air, oil = read_pictures(view.air), read_pictures(view.oil)
        shapes = {picture.shape for picture in (*air.values(), *oil.values())}
        if len(shapes) > 1:
            raise InputError(f"pictures of camera {view.name} must all have the same size; got {sorted(shapes)}")
        height, width = shapes.pop()
        sizes.append((width, height))
        seen = {}
        for kind, pictures in (("air", air), ("oil", oil)):
            corners = {name: board.find(picture) for name, picture in pictures.items()}
            seen[kind] = {name: pair for name, pair in corners.items() if pair[0].size}
        if len(seen["air"]) < LEAST_AIR:
            raise InputError(
                f"camera {view.name} needs the board in at least {LEAST_AIR} pictures in air; it was found in "
                f"{len(seen['air'])} of {len(air)}; check [board] against the printed one"
            )
        found.append(seen)
        watch(0.3 * (number + 1))
    cameras = []
    intrinsics = []
    for view, seen, size in zip(session.views, found, sizes, strict=True):
        matrix, distortion, rms = _intrinsics(session, seen["air"], size)
        cameras.append(Camera(view.name, matrix, distortion, np.eye(3), np.zeros(3), size))
        intrinsics.append(rms)
    shared = {kind: sorted(set(found[0][kind]) & set(found[1][kind])) for kind in ("air", "oil")}
    if session.datum not in shared["oil"]:
        raise InputError(f"datum.picture must show the board in the tank to both cameras; '{session.datum}' does not")
    if len(shared["oil"]) < LEAST_OIL or not shared["air"]:
        raise InputError(
            f"the cameras must share at least one picture in air and {LEAST_OIL} in the tank in which both find the "
            f"board; they share {len(shared['air'])} and {len(shared['oil'])} (same file name in both folders)"
        )
    held_out = [name for name in shared["oil"] if name != session.datum][-HELD_OUT:]
    fitted = {"air": shared["air"], "oil": [name for name in shared["oil"] if name not in held_out]}
    watch(0.65)
    second = _stereo(session, found, cameras, fitted["air"])
    lab = Pose(session.rotation, session.position)
    problem = _Problem(session, found, (cameras[0], cameras[1]), fitted)
    report: dict[str, Any] = {
        "intrinsics_rms_px": {camera.name: rms for camera, rms in zip(cameras, intrinsics, strict=True)},
        "pictures": {kind: len(names) for kind, names in fitted.items()},
    }
    if refraction:
        result = problem.solve(second)
        watch(0.95)
        rig = problem.rig(result.x, lab)
        report |= problem.describe(result)
    else:
        rig = _straight(session, found, (cameras[0], cameras[1]), lab)
    report |= _held_out(session, rig, found, held_out)
    rig = replace(rig, accuracy=report["held_out_rms_mm"] * 1e-3)
    warnings = _warnings(session, rig, report)
    rig = replace(rig, notes={"report": report, "warnings": warnings})
    watch(1.0)
    return Calibration(rig, report, warnings)


def _intrinsics(session: Session, seen: dict[str, Corners], size: tuple[int, int]) -> tuple[Floats, Floats, float]:
    points = [session.board.corners[numbers].astype(np.float32) for numbers, _ in seen.values()]
    pixels = [found.astype(np.float32) for _, found in seen.values()]
    rms, matrix, distortion, _, _ = cv2.calibrateCamera(points, pixels, size, None, None, flags=cv2.CALIB_FIX_K3)
    return np.asarray(matrix, dtype=np.float64), np.asarray(distortion, dtype=np.float64).ravel()[:5], float(rms)


def _common(first: Corners, second: Corners) -> tuple[NDArray[np.int64], Floats, Floats]:
    numbers, one, two = np.intersect1d(first[0], second[0], return_indices=True)
    return numbers, first[1][one], second[1][two]


def _stereo(
    session: Session, found: list[dict[str, dict[str, Corners]]], cameras: list[Camera], names: list[str]
) -> Pose:
    """Pose of the second camera: from the first camera's frame to its own."""
    matched = [_common(found[0]["air"][name], found[1]["air"][name]) for name in names]
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


def _board_pose(session: Session, camera: Camera, corners: Corners) -> Pose:
    """From the board's frame to the camera's, light taken to go straight."""
    good, turn, shift = cv2.solvePnP(
        session.board.corners[corners[0]], corners[1], camera.matrix, camera.distortion, flags=cv2.SOLVEPNP_ITERATIVE
    )
    if not good:
        raise InputError(f"the board's pose cannot be found in a picture of camera {camera.name}")
    return Pose.from_six(np.concatenate([turn.ravel(), shift.ravel()]))


def _straight(
    session: Session, found: list[dict[str, dict[str, Corners]]], cameras: tuple[Camera, Camera], lab: Pose
) -> Rig:
    posed = []
    for seen, camera in zip(found, cameras, strict=True):
        pose = _board_pose(session, camera, seen["oil"][session.datum]).after(lab.inverse)
        posed.append(replace(camera, rotation=pose.rotation, translation=pose.translation))
    return Rig((posed[0], posed[1]), session.tank)


class _Problem:
    """The joint fit, in the first camera's frame: [second camera 6 | walls 2 x 3 | oil's index | boards 6 each]."""

    BOARDS = 13

    def __init__(
        self,
        session: Session,
        found: list[dict[str, dict[str, Corners]]],
        cameras: tuple[Camera, Camera],
        names: dict[str, list[str]],
    ) -> None:
        self.session = session
        self.cameras = cameras
        self.pictures = [(kind, name) for kind in ("air", "oil") for name in names[kind]]
        self.corners = [[found[view][kind][name] for view in (0, 1)] for kind, name in self.pictures]

    def walls(self, values: Floats) -> list[Wall]:
        """Each in its own camera's frame, whose centre is the origin."""
        walls = []
        for view in (0, 1):
            lean_x, lean_y, distance = values[6 + 3 * view : 9 + 3 * view]
            normal = np.array([lean_x, lean_y, 1.0]) / np.sqrt(1.0 + lean_x**2 + lean_y**2)
            indices = (self.session.indices[0], self.session.indices[1], float(values[12]))
            walls.append(Wall(distance * normal, normal, self.session.thickness, indices))
        return walls

    def start(self, second: Pose) -> Floats:
        values = [second.six]
        values += [np.array([0.0, 0.0, view.distance]) for view in self.session.views]
        values.append(np.array([self.session.indices[2]]))
        for (kind, _), corners in zip(self.pictures, self.corners, strict=True):
            pose = _board_pose(self.session, self.cameras[0], corners[0])
            if kind == "oil":  # what is behind the wall looks nearer than it is
                depth = pose.translation[2]
                behind = max(depth - self.session.views[0].distance, 0.0) * (self.session.indices[2] - 1.0)
                pose = Pose(pose.rotation, pose.translation * (1.0 + behind / depth))
            values.append(pose.six)
        return np.concatenate(values)

    def residuals(self, values: Floats) -> Floats:
        """Pixels by which the corners are seen beside where they should be: (2 x corners,)."""
        walls = self.walls(values)
        second = Pose.from_six(values[:6])
        return np.concatenate([self._picture(values, walls, second, index) for index in range(len(self.pictures))])

    def _picture(self, values: Floats, walls: list[Wall], second: Pose, index: int) -> Floats:
        at = self.BOARDS + 6 * index
        board = Pose.from_six(values[at : at + 6])
        kind = self.pictures[index][0]
        parts = []
        for view, (numbers, pixels) in enumerate(self.corners[index]):
            local = board.of(self.session.board.corners[numbers])
            if view == 1:
                local = second.of(local)
            camera = replace(self.cameras[view], wall=walls[view] if kind == "oil" else None)
            parts.append((camera.project(local) - pixels).ravel())
        return np.nan_to_num(np.concatenate(parts), nan=1e3)

    def jacobian(self, values: Floats) -> Floats:
        """By differences; a board's pose moves its own picture only."""
        base = self.residuals(values)
        jacobian = np.zeros((base.size, values.size))
        for column in range(self.BOARDS):
            moved = values.copy()
            moved[column] += 1e-7
            jacobian[:, column] = (self.residuals(moved) - base) / 1e-7
        walls, second = self.walls(values), Pose.from_six(values[:6])
        row = 0
        for index, corners in enumerate(self.corners):
            rows = slice(row, row + 2 * sum(pair[0].size for pair in corners))
            row = rows.stop
            for column in range(self.BOARDS + 6 * index, self.BOARDS + 6 * index + 6):
                moved = values.copy()
                moved[column] += 1e-7
                jacobian[rows, column] = (self._picture(moved, walls, second, index) - base[rows]) / 1e-7
        return jacobian

    def solve(self, second: Pose) -> Any:
        start = self.start(second)
        free = np.ones(start.size, bool)
        free[12] = False
        result = self._fit(start, free)
        if self.session.estimate_oil:  # only from a good start, since index and distances trade off
            free[12] = True
            result = self._fit(result.x, free)
        return result

    def _fit(self, start: Floats, free: NDArray[np.bool_]) -> Any:
        def whole(part: Floats) -> Floats:
            values = start.copy()
            values[free] = part
            return values

        low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
        low[12], high[12] = INDEX_RANGE
        result = least_squares(
            lambda part: self.residuals(whole(part)),
            start[free],
            jac=lambda part: self.jacobian(whole(part))[:, free],
            bounds=(low[free], high[free]),
            x_scale="jac",
            loss="soft_l1",
            f_scale=0.5,
            max_nfev=60,
        )
        covariance = (
            np.linalg.pinv(result.jac.T @ result.jac) * 2.0 * result.cost / max(1, result.fun.size - free.sum())
        )
        spread = np.zeros(start.size)
        spread[free] = np.sqrt(np.diag(covariance))
        result.x, result.spread = whole(result.x), spread
        return result

    def rig(self, values: Floats, lab: Pose) -> Rig:
        """The rig in the lab frame, which the datum fixes."""
        datum = self.pictures.index(("oil", self.session.datum))
        board = Pose.from_six(values[self.BOARDS + 6 * datum : self.BOARDS + 6 * datum + 6])
        first = board.after(lab.inverse)
        poses = (first, Pose.from_six(values[:6]).after(first))
        cameras = []
        for camera, pose, wall in zip(self.cameras, poses, self.walls(values), strict=True):
            to_lab = pose.inverse
            normal = to_lab.rotation @ wall.normal
            placed = replace(wall, point=to_lab.of(wall.point), normal=normal / np.linalg.norm(normal))
            cameras.append(replace(camera, rotation=pose.rotation, translation=pose.translation, wall=placed))
        return Rig((cameras[0], cameras[1]), self.session.tank)

    def describe(self, result: Any) -> dict[str, Any]:
        """Errors of the fit in pixels, and the walls with their standard deviations."""
        square = {camera.name: [0.0, 0] for camera in self.cameras}
        residuals = self.residuals(result.x)
        row = 0
        for corners in self.corners:
            for camera, (numbers, _) in zip(self.cameras, corners, strict=True):
                part = residuals[row : row + 2 * numbers.size]
                row += part.size
                square[camera.name][0] += float(part @ part)
                square[camera.name][1] += part.size // 2
        walls = {}
        for view, (camera, wall) in enumerate(zip(self.cameras, self.walls(result.x), strict=True)):
            lean = result.spread[6 + 3 * view : 8 + 3 * view].max()
            walls[camera.name] = {
                "distance_mm": 1e3 * float(result.x[8 + 3 * view]),
                "distance_sd_mm": 1e3 * float(result.spread[8 + 3 * view]),
                "tilt_to_camera_deg": float(np.degrees(np.arccos(wall.normal[2]))),
                "tilt_sd_deg": float(np.degrees(lean)),
            }
        return {
            "joint_rms_px": {name: float(np.sqrt(total / count)) for name, (total, count) in square.items()},
            "walls": walls,
            "oil_index": float(result.x[12]),
            "oil_index_sd": float(result.spread[12]),
        }


def _held_out(
    session: Session, rig: Rig, found: list[dict[str, dict[str, Corners]]], names: list[str]
) -> dict[str, Any]:
    """Triangulated corners of boards that the fit has not seen, against the board: rigid fit, and with a scale."""
    errors, scales, misses = [], [], []
    for name in names:
        numbers, first, second = _common(found[0]["oil"][name], found[1]["oil"][name])
        if numbers.size < 4:
            continue
        points, miss = rig.triangulate(first, second)
        fitted, scale = _rigid(session.board.corners[numbers], points)
        errors.append(np.sum((points - fitted) ** 2, axis=1))
        scales.append(scale - 1.0)
        misses.append(miss)
    if not errors:
        raise InputError("the pictures held out in the tank must show the board to both cameras")
    return {
        "held_out": names,
        "held_out_rms_mm": 1e3 * float(np.sqrt(np.concatenate(errors).mean())),
        "held_out_scale_error": float(np.abs(scales).max()),
        "held_out_miss_mm": 1e3 * float(np.concatenate(misses).mean()),
    }


def _rigid(points: Floats, seen: Floats) -> tuple[Floats, float]:
    """``points`` moved rigidly onto ``seen`` as well as possible, and the scale that would fit best (Umeyama 1991)."""
    one, two = points - points.mean(axis=0), seen - seen.mean(axis=0)
    left, stretch, right = np.linalg.svd(two.T @ one)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    scale = float((stretch * sign).sum() / np.sum(one * one))
    return one @ ((left * sign) @ right).T + seen.mean(axis=0), scale


def cost_of_ignoring(rig: Rig) -> dict[str, float]:
    """How far off points in the tank would be (mm) if light were taken to go straight; and after the best rigid
    shift."""
    low, high = rig.tank
    inset = 0.1 * (high - low)
    axes = [np.linspace(a, b, 7) for a, b in zip(low + inset, high - inset, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    pixels = [camera.project(points) for camera in rig.cameras]
    seen = np.all(
        [np.all(np.isfinite(p) & (p >= 0) & (p < c.size), axis=1) for p, c in zip(pixels, rig.cameras, strict=True)],
        axis=0,
    )
    if seen.sum() < 4:
        raise InputError("the cameras must both see the tank; the calibrated ones share less than four points of it")
    straight, _ = rig.without_refraction().triangulate(pixels[0][seen], pixels[1][seen])
    moved, _ = _rigid(points[seen], straight)
    return {
        "ignoring_refraction_rms_mm": 1e3 * float(np.sqrt(np.mean(np.sum((straight - points[seen]) ** 2, axis=1)))),
        "ignoring_refraction_after_shift_rms_mm": 1e3
        * float(np.sqrt(np.mean(np.sum((straight - moved) ** 2, axis=1)))),
    }


def _warnings(session: Session, rig: Rig, report: dict[str, Any]) -> list[str]:
    claimed = 1e3 * session.accuracy
    warnings = []
    if rig.cameras[0].wall is not None:
        report |= cost_of_ignoring(rig)
        cost = report["ignoring_refraction_after_shift_rms_mm"]
        if cost > claimed:
            warnings.append(
                f"refraction must not be ignored here: points would be off by {cost:.2f} mm rms even after the best "
                f"rigid shift, and {claimed:.2f} mm is claimed"
            )
    else:
        warnings.append("refraction is ignored: lengths and depths in the tank are off")
    if report["held_out_rms_mm"] > claimed:
        warnings.append(
            f"held-out boards are off by {report['held_out_rms_mm']:.3f} mm rms, more than the {claimed:.2f} mm claimed"
        )
    worst = max(report["intrinsics_rms_px"].values())
    if worst > 0.5:
        warnings.append(
            f"intrinsics fit to {worst:.2f} px only; 0.5 px or less is usual: check for blur and a bent board"
        )
    return warnings
