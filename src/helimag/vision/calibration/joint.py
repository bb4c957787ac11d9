"""The joint fit of extrinsics, walls, index and boards to all pictures that both cameras share."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from helimag.vision.calibration.in_air import board_pose
from helimag.vision.calibration.pictures import Found
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
from helimag.vision.cameras import Camera, Rig
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]

INDEX_RANGE = (1.2, 1.7)  # of liquids


class Joint:
    """The joint fit, in the first camera's frame: [second camera 6 | walls 2 x 3 | oil's index | boards 6 each]."""

    BOARDS = 13

    def __init__(
        self,
        session: Session,
        found: Found,
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
            pose = board_pose(self.session, self.cameras[0], corners[0])
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
