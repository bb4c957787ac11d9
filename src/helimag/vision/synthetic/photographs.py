"""Photographs of a board, ray by ray, and a whole calibration session of them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline
from scipy.spatial.transform import Rotation

from helimag import quantities as q
from helimag.errors import FileError, InputError
from helimag.vision._cv import cv2
from helimag.vision.calibration import FACES, Board
from helimag.vision.cameras import Camera, Rig

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

TEXELS = 120  # of a square's side in the board's picture
TRIES = 100  # at a board's attitude in the tank
GRID = 8  # pixels between rays that are traced; the board's coordinates are smooth in between


def photograph(board: Board, camera: Camera, rotation: Floats, place: Floats, random: np.random.Generator) -> Picture:
    """Photograph the board: rays go from pixels through the wall to the board's plane.

    Parameters
    ----------
    rotation, place
        (3, 3) and (3,): from the board's frame to the lab (m).
    """
    width, height = camera.size
    seen = camera.project(_outline(board) @ rotation.T + place)
    shade = np.tile(190.0 + 12.0 * random.normal() * (np.arange(width) / width - 0.5), (height, 1))
    picture = shade * 0.45
    low = np.clip(np.floor(seen.min(axis=0)).astype(int) - 2 * GRID, 0, (width - GRID, height - GRID))
    high = np.clip(np.ceil(seen.max(axis=0)).astype(int) + 2 * GRID, GRID, (width, height))
    inside = _sampled(board, camera, rotation, place, low, high)
    region = (slice(low[1], high[1]), slice(low[0], high[0]))
    white = inside >= 0.0
    picture[region] = np.where(white, shade[region] * (0.12 + 0.88 * inside / 255.0), picture[region])
    picture = cv2.GaussianBlur(picture, (0, 0), 0.7) + random.normal(0.0, 2.0, picture.shape)
    return np.asarray(np.clip(picture + 0.5, 0, 255), dtype=np.uint8)


def _outline(board: Board) -> Floats:
    """Corners of the printed sheet in the board's frame (m): (4, 3)."""
    margin = board.square / 4.0
    size = np.array([board.columns, board.rows]) * board.square
    return np.array(
        [
            [-margin, -margin, 0],
            [size[0] + margin, -margin, 0],
            [*(size + margin), 0],
            [-margin, size[1] + margin, 0],
        ]
    )


def _sampled(
    board: Board, camera: Camera, rotation: Floats, place: Floats, low: NDArray[np.int64], high: NDArray[np.int64]
) -> Floats:
    """Brightness of the board in a box of pixels, averaged over 2 x 2 rays a pixel; -1 beside the board."""
    columns = np.arange(low[0] - GRID, high[0] + GRID + 1, GRID, dtype=np.float64)
    rows = np.arange(low[1] - GRID, high[1] + GRID + 1, GRID, dtype=np.float64)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1)
    origins, directions = camera.rays(pixels)
    normal = rotation[:, 2]
    hits = origins + directions * (((place - origins) @ normal) / (directions @ normal))[..., None]
    local = (hits - place) @ rotation / board.square * TEXELS - 0.5
    texture: Any = board.picture(TEXELS)
    edge = TEXELS // 4
    texture = cv2.copyMakeBorder(texture, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=255)
    zoom = float(np.hypot(*(local[1:, :, :2] - local[:-1, :, :2]).reshape(-1, 2).mean(axis=0))) / GRID
    texture = cv2.GaussianBlur(texture, (0, 0), max(0.3, 0.25 * zoom))
    total = np.zeros((high[1] - low[1], high[0] - low[0]))
    fine_x = np.arange(low[0], high[0], dtype=np.float64)
    fine_y = np.arange(low[1], high[1], dtype=np.float64)
    maps = [np.asarray(RectBivariateSpline(rows, columns, local[..., axis])(fine_y, fine_x)) + edge for axis in (0, 1)]
    slopes = [np.gradient(values) for values in maps]
    for dy in (-0.25, 0.25):
        for dx in (-0.25, 0.25):
            u, v = (m + dy * down + dx * right for m, (down, right) in zip(maps, slopes, strict=True))
            total += _look_up(texture, np.asarray(u, np.float32), np.asarray(v, np.float32))
    return np.where(total >= 0.0, total / 4.0, -1.0)


def _look_up(texture: Picture, u: NDArray[np.float32], v: NDArray[np.float32]) -> Floats:
    values = cv2.remap(texture.astype(np.float32), u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    outside = (u < 0) | (v < 0) | (u > texture.shape[1] - 1) | (v > texture.shape[0] - 1)
    return np.asarray(np.where(outside, -1.0e4, values), dtype=np.float64)


def _facing(rig: Rig, tilt: Floats) -> Floats:
    """Attitude of a board seen by both cameras: in between the directions in which they look in the oil, then
    tilted."""
    directions = [camera.rays((np.array(camera.size) - 1.0) / 2.0)[1] for camera in rig.cameras]
    into = np.sum(directions, axis=0) / np.linalg.norm(np.sum(directions, axis=0))
    along = np.cross(into, np.cross([1.0, 0.0, 0.0], into))
    along /= np.linalg.norm(along)
    upright = np.stack([along, np.cross(into, along), into], axis=1)
    return np.asarray(Rotation.from_rotvec(tilt).as_matrix() @ upright)


def render_session(
    rig: Rig,
    folder: str | Path,
    *,
    seed: int = 0,
    own: int = 10,
    shared: int = 6,
    oil: int = 12,
    board: Board | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Photograph a board as a person would to calibrate the rig, and write the session's file.

    Parameters
    ----------
    own, shared, oil
        Pictures of the board in air for each camera alone, in air for both together, and in the filled tank.
    board
        To photograph; default that of the how-to page.

    Returns
    -------
    Path
        Of ``calibration.toml``.
    """
    random = np.random.default_rng(1000 + seed)
    target = Path(folder)
    board = board or Board()
    middle = np.array([board.columns, board.rows, 0]) * board.square / 2.0
    done = 0
    total = 2 * own + 2 * shared + 2 * oil

    def take(kind: str, view: int, name: str, rotation: Floats, place: Floats) -> None:
        nonlocal done
        camera = rig.cameras[view] if kind == "oil" else rig.without_refraction().cameras[view]
        where = target / kind / camera.name
        where.mkdir(parents=True, exist_ok=True)
        picture = photograph(board, camera, rotation, place - rotation @ middle, random)
        if not cv2.imwrite(str(where / name), picture, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
            raise FileError(f"{where / name} cannot be written")
        done += 1
        if progress is not None:
            progress(done / total)

    for view, camera in enumerate(rig.cameras):
        for number in range(own):
            take("air", view, f"{camera.name}{number:02d}.png", *_alone(camera, number, random))
    for number in range(shared + oil):
        pose = _in_tank(rig, board, middle, number, random)
        if number == shared:
            datum = (pose[0], pose[1] - pose[0] @ middle)
        for view in (0, 1):
            take("air" if number < shared else "oil", view, f"both{number:02d}.png", *pose)
    _write(rig, target / "calibration.toml", board, f"both{shared:02d}.png", datum)
    return target / "calibration.toml"


def _alone(camera: Camera, number: int, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Attitude and place of a board shown to one camera, somewhere in its picture, tilted each way."""
    tilt = np.asarray(Rotation.from_rotvec(random.uniform(-0.6, 0.6, 3)).as_matrix())
    depth = random.uniform(0.25, 0.38)
    corner = np.array([(number % 4) / 3.0 - 0.5, ((number // 2) % 3) / 2.0 - 0.5, 0.0]) * [0.6, 0.5, 0.0]
    spot = np.array([*(corner[:2] * camera.size / camera.matrix[0, 0] * depth), depth])
    return camera.rotation.T @ tilt, camera.rotation.T @ (spot - camera.translation)


def _in_tank(rig: Rig, board: Board, middle: Floats, number: int, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Attitude and place of a board that both cameras see whole, at other ends of the tank in turn."""
    for _ in range(TRIES):
        rotation, place = _tried(rig, middle, number, random)
        around = _outline(board) @ rotation.T + place - rotation @ middle
        if all(np.all(np.isfinite(camera.project(around))) for camera in rig.cameras):
            return rotation, place
    raise InputError("a board must fit into the tank behind both walls; these cameras look too much aslant")


def _tried(rig: Rig, middle: Floats, number: int, random: np.random.Generator) -> tuple[Floats, Floats]:
    low, high = rig.tank
    rotation = _facing(rig, random.uniform(-1, 1, 3) * [0.25, 0.35, 0.35])
    reach = np.abs(rotation @ (middle * [1, 1, 0])) + np.abs(rotation @ (middle * [1, -1, 0]))
    reach = np.minimum(reach / 2.0 + 0.014, (high - low) / 2.0 - 1e-3)
    place = random.uniform(low + reach, high - reach)
    place[0] = low[0] + 0.042 + (high[0] - low[0] - 0.084) * ((number * 0.382) % 1.0)
    return rotation, place


def _distance(camera: Camera) -> float:
    """From a camera to the outer face of its wall, as a person would measure it (m)."""
    if camera.wall is None:
        raise InputError("a rig must have walls to be calibrated in a tank")
    return round(float((camera.wall.point - camera.centre) @ camera.wall.normal), 2)


def _face(camera: Camera) -> str:
    """The tank's face that a camera looks through."""
    normal = camera.rotation[2] if camera.wall is None else camera.wall.normal
    axis = int(np.argmax(np.abs(normal)))
    return FACES[axis if normal[axis] > 0.0 else axis + 3]


def _write(rig: Rig, path: Path, board: Board, picture: str, datum: tuple[Floats, Floats]) -> None:
    def show(values: Floats, kind: q.Kind = q.LENGTH) -> list[str]:
        return [q.show(float(value), kind) for value in values]

    wall = rig.cameras[0].wall
    if wall is None:
        raise InputError("a rig must have walls to be calibrated in a tank")
    data = {
        "accuracy": "0.15 mm",
        "board": {
            "columns": board.columns,
            "rows": board.rows,
            "square": q.show(board.square, q.LENGTH),
            "marker": q.show(board.marker, q.LENGTH),
            "dictionary": board.dictionary,
        },
        "tank": {
            "low": show(rig.tank[0]),
            "high": show(rig.tank[1]),
            "wall_thickness": q.show(wall.thickness, q.LENGTH),
            "indices": list(wall.indices),
            "estimate_oil": False,
        },
        "datum": {
            "picture": picture,
            "position": show(datum[1]),
            "rotation": show(Rotation.from_matrix(datum[0]).as_rotvec(), q.ANGLE),
        },
        "camera": [
            {
                "name": c.name,
                "air": f"air/{c.name}",
                "oil": f"oil/{c.name}",
                "distance": q.show(_distance(c), q.LENGTH),
                "wall": _face(c),
            }
            for c in rig.cameras
        ],
    }
    path.write_text(tomli_w.dumps(data), encoding="utf-8")
