"""Cameras that look through walls, and pairs of them: points to pixels and pixels to rays, in and out of JSON."""

import hashlib
import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.files import bytes_of, replacing
from helimag.vision._cv import cv2
from helimag.vision.refraction import Wall, nearest, sight, through
from helimag.vision.rig_checks import check_lens, check_pose, check_tank, check_wall

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A camera and the wall that it looks through.

    Parameters
    ----------
    name
        Such as "front".
    matrix
        (3, 3): focal lengths and principal point (px).
    distortion
        (5,): k1, k2, p1, p2, k3 of OpenCV's lens model.
    rotation, translation
        (3, 3) and (3,): from lab (m) to camera, x right, y down, z along the optical axis.
    size
        Width and height of the picture (px).
    wall
        None for a camera that sees everything through air, or whose refraction is ignored.
    """

    name: str
    matrix: Floats
    distortion: Floats
    rotation: Floats
    translation: Floats
    size: tuple[int, int]
    wall: Wall | None = None

    @property
    def centre(self) -> Floats:
        """Centre of projection in the lab frame (m): (3,)."""
        return np.asarray(-self.rotation.T @ self.translation)

    def project(self, points: Floats) -> Floats:
        """Pixels (..., 2) at which points (..., 3) of the lab frame (m) are seen; NaN for points before the wall."""
        seen = points - self.centre if self.wall is None else sight(self.centre, points, self.wall)
        local = np.ascontiguousarray((seen @ self.rotation.T).reshape(-1, 3))
        pixels, _ = cv2.projectPoints(local, np.zeros(3), np.zeros(3), self.matrix, self.distortion)
        return np.asarray(pixels, dtype=np.float64).reshape(*points.shape[:-1], 2)

    def rays(self, pixels: Floats) -> tuple[Floats, Floats]:
        """Origins (m) and unit directions, each (..., 3) in the lab frame, of what is seen at pixels (..., 2)."""
        flat = np.ascontiguousarray(pixels.reshape(-1, 1, 2), dtype=np.float64)
        plane = cv2.undistortPoints(flat, self.matrix, self.distortion).reshape(-1, 2)
        local = np.concatenate([plane, np.ones((plane.shape[0], 1))], axis=1)
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        direction = (local @ self.rotation).reshape(*pixels.shape[:-1], 3)
        if self.wall is None:
            return np.broadcast_to(self.centre, direction.shape), direction
        return through(self.centre, direction, self.wall)

    def scale(self, points: Floats) -> Floats:
        """Pixels a metre (...) across the line of sight at points (..., 3), over a tenth of a millimetre."""
        step = 1e-4
        right = self.rotation[0]
        return np.asarray(np.linalg.norm(self.project(points + step * right) - self.project(points), axis=-1) / step)


@dataclass(frozen=True)
class Rig:
    """Two calibrated cameras and the tank.

    Parameters
    ----------
    cameras
        The first gives the clock.
    tank
        (2, 3): lowest and highest corner of the oil in the lab frame (m).
    accuracy
        What the calibration claims for a point in the tank (m, one standard deviation of a coordinate), 0 where the rig
        is exact.
    notes
        Of the calibration: its report and its warnings.
    variants
        Pairs of cameras one standard deviation off, each along an independent direction: what the calibration leaves
        open.
    """

    cameras: tuple[Camera, Camera]
    tank: Floats
    accuracy: float = 0.0
    notes: dict[str, Any] = field(default_factory=dict)
    variants: tuple[tuple[Camera, Camera], ...] = ()

    def triangulate(self, first: Floats, second: Floats) -> tuple[Floats, Floats]:
        """Points (..., 3) in the lab (m) seen at pixels (..., 2) of both views, and how far the rays miss each
        other."""
        one, two = self.cameras[0].rays(first), self.cameras[1].rays(second)
        return nearest((one[0], two[0]), (one[1], two[1]))

    def inside(self, points: Floats, margin: float = 0.0) -> NDArray[np.bool_]:
        """Whether points (..., 3) are in the tank, or at most ``margin`` (m) beyond a wall."""
        return np.asarray(np.all((points >= self.tank[0] - margin) & (points <= self.tank[1] + margin), axis=-1))

    def without_refraction(self) -> "Rig":
        """The same cameras, with light taken to go straight."""
        first, second = (replace(camera, wall=None) for camera in self.cameras)
        return replace(self, cameras=(first, second), variants=())

    def shifts(self, points: Floats) -> Floats:
        """How far each variant puts points (n, 3) that look the same elsewhere: (variants, n, 3) in m."""
        pixels = [camera.project(points) for camera in self.cameras]
        moved = [replace(self, cameras=pair).triangulate(*pixels)[0] - points for pair in self.variants]
        return np.stack(moved) if moved else np.zeros((0, *points.shape))

    def save(self, path: str | Path) -> None:
        """Write JSON with a checksum of its content; beside first, then renamed."""
        content = self._plain()
        with replacing(path) as beside:
            beside.write_text(json.dumps(content | {"sha256": _digest(content)}, indent=1), encoding="utf-8")

    def _plain(self) -> dict[str, Any]:
        return {
            "cameras": [_plain(camera) for camera in self.cameras],
            "tank_m": self.tank.tolist(),
            "accuracy_m": self.accuracy,
            "notes": self.notes,
            "variants": [[_plain(camera) for camera in pair] for pair in self.variants],
        }

    @classmethod
    def load(cls, path: str | Path) -> "Rig":
        """Read what :meth:`save` wrote.

        Returns
        -------
        Rig
            As it was saved.

        Raises
        ------
        FileError
            Where the file cannot be read.
        InputError
            Where it is not a rig.
        """
        try:
            data = json.loads(bytes_of(path).decode("utf-8"))
        except ValueError as error:
            raise InputError(
                f"{path} is not a rig, which is JSON ({error}); a lens that OpenCV or MATLAB calibrated is named in "
                f"the session's [[camera]] as lens, and 'helimag vision calibrate' makes a rig"
            ) from None
        try:
            recorded = data.pop("sha256", None)
            if recorded is not None and recorded != _digest(data):
                raise InputError("a number in it was changed since; who means that takes its sha256 out")
            first, second = (_camera(entry) for entry in data["cameras"])
            tank = np.array(data["tank_m"], dtype=np.float64).reshape(2, 3)
            variants = tuple((_camera(one), _camera(two)) for one, two in data.get("variants", ()))
            check_tank(tank, float(data["accuracy_m"]))
            rig = cls((first, second), tank, float(data["accuracy_m"]), dict(data["notes"]), variants)
        except (LookupError, TypeError, ValueError, OverflowError, AttributeError) as error:
            reason = str(error) if isinstance(error, InputError) else repr(error)
            raise InputError(
                f"{path} is not a calibrated pair of cameras ({reason}); 'helimag vision calibrate' writes one"
            ) from None
        return rig


def _digest(content: dict[str, Any]) -> str:
    """SHA-256 of a rig's content."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _plain(camera: Camera) -> dict[str, Any]:
    wall = camera.wall
    return {
        "name": camera.name,
        "matrix_px": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "rotation": camera.rotation.tolist(),
        "translation_m": camera.translation.tolist(),
        "size_px": list(camera.size),
        "wall": None
        if wall is None
        else {
            "point_m": wall.point.tolist(),
            "normal": wall.normal.tolist(),
            "thickness_m": wall.thickness,
            "indices": list(wall.indices),
        },
    }


def _camera(entry: dict[str, Any]) -> Camera:
    """A camera as a file says it, held to what cameras can be."""
    wall = entry["wall"]
    camera = Camera(
        name=str(entry["name"]),
        matrix=np.array(entry["matrix_px"], dtype=np.float64).reshape(3, 3),
        distortion=np.array(entry["distortion"], dtype=np.float64).reshape(5),
        rotation=np.array(entry["rotation"], dtype=np.float64).reshape(3, 3),
        translation=np.array(entry["translation_m"], dtype=np.float64).reshape(3),
        size=(int(entry["size_px"][0]), int(entry["size_px"][1])),
        wall=None
        if wall is None
        else Wall(
            np.array(wall["point_m"], dtype=np.float64).reshape(3),
            np.array(wall["normal"], dtype=np.float64).reshape(3),
            float(wall["thickness_m"]),
            (float(wall["indices"][0]), float(wall["indices"][1]), float(wall["indices"][2])),
        ),
    )
    name = f"camera '{camera.name}'"
    check_lens(name, camera.size, camera.matrix, camera.distortion)
    check_pose(name, camera.rotation, camera.translation)
    if camera.wall is not None:
        check_wall(name, camera.wall)
    return camera


def looking(position: Floats, target: Floats, up: Floats) -> tuple[Floats, Floats]:
    """Rotation (3, 3) and translation (3,) from lab to a camera at a position (m) that looks at a target."""
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return rotation, np.asarray(-rotation @ position)
