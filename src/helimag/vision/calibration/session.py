"""A calibration session: board, tank and pictures, as a TOML file with units; and a synthetic one."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from helimag import quantities as q
from helimag.errors import FileError, InputError
from helimag.files import toml_tables
from helimag.vision._cv import cv2
from helimag.vision.calibration.boards import Board
from helimag.vision.cameras import Rig

Floats = NDArray[np.float64]
PICTURES = (".png", ".tif", ".tiff", ".bmp", ".jpg")


@dataclass(frozen=True)
class View:
    """One camera's pictures: of the board in air, and of the board in the filled tank."""

    name: str
    air: Path
    oil: Path
    distance: float  # of the wall from the camera, roughly (m)


@dataclass(frozen=True)
class Session:
    """What a calibration needs.

    Parameters
    ----------
    tank
        (2, 3): lowest and highest corner of the oil in the lab frame (m).
    thickness
        Of the walls (m).
    indices
        Of air, wall and oil.
    estimate_oil
        Whether the oil's index is only a first guess.
    datum
        Name of the picture in the tank in which the board stands where it is known to stand.
    rotation, position
        (3, 3) and (3,): the board's pose there, from its own frame to the lab (m).
    accuracy
        That a tracked point is meant to have (m).
    """

    views: tuple[View, View]
    board: Board
    tank: Floats
    thickness: float
    indices: tuple[float, float, float]
    estimate_oil: bool
    datum: str
    rotation: Floats
    position: Floats
    accuracy: float

    @classmethod
    def load(cls, path: str | Path) -> "Session":
        """Read a session's TOML file; folders are relative to it.

        Raises
        ------
        FileError
            Where the file cannot be read.
        InputError
            Where it is not a calibration session.
        """
        source = Path(path)
        try:
            text = source.read_text(encoding="utf-8")
        except OSError as error:
            raise FileError(f"{path} cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise InputError(f"{path} is not a text file") from None
        data = toml_tables(text, str(path))
        try:
            return _session(data, source.parent)
        except KeyError as error:
            raise InputError(
                f"{path} has no {error.args[0]}; see 'Track with two cameras' in the documentation"
            ) from None
        except (TypeError, AttributeError, ValueError) as error:
            raise InputError(f"{path}: {error}") from None


def _lengths(values: Any, name: str, kind: q.Kind = q.LENGTH) -> Floats:
    if not isinstance(values, list) or len(values) != 3 or not all(isinstance(value, str) for value in values):
        raise InputError(f"{name} must be three quantities such as '{kind.example}'; got {values!r}")
    return np.array([q.parse(value, kind) for value in values])


def _length(table: dict[str, Any], key: str, name: str) -> float:
    value = table[key]
    if not isinstance(value, str):
        raise InputError(f"{name}.{key} must be a length such as '9 mm'; got {value!r}")
    return q.parse(value, q.LENGTH)


def _session(data: dict[str, Any], folder: Path) -> Session:
    board, tank, datum = data["board"], data["tank"], data["datum"]
    cameras = data["camera"]
    if not isinstance(cameras, list) or len(cameras) != 2:
        raise InputError("[[camera]] must be given twice")
    views = [
        View(str(c["name"]), folder / c["air"], folder / c["oil"], _length(c, "distance", f"camera {c['name']}"))
        for c in cameras
    ]
    indices = tuple(float(tank["indices"][i]) for i in range(3))
    estimate = tank.get("estimate_oil", False)
    if not isinstance(estimate, bool):
        raise InputError(f"tank.estimate_oil must be true or false; got {estimate!r}")
    angles = _lengths(datum["rotation"], "datum.rotation", q.ANGLE)
    return Session(
        views=(views[0], views[1]),
        board=Board(
            int(board["columns"]),
            int(board["rows"]),
            _length(board, "square", "board"),
            _length(board, "marker", "board"),
            str(board["dictionary"]),
        ),
        tank=np.stack([_lengths(tank["low"], "tank.low"), _lengths(tank["high"], "tank.high")]),
        thickness=_length(tank, "wall_thickness", "tank"),
        indices=(indices[0], indices[1], indices[2]),
        estimate_oil=estimate,
        datum=str(datum["picture"]),
        rotation=np.asarray(Rotation.from_rotvec(angles).as_matrix()),
        position=_lengths(datum["position"], "datum.position"),
        accuracy=_length(data, "accuracy", "session") if "accuracy" in data else 0.15e-3,
    )


def read_pictures(folder: Path) -> dict[str, NDArray[np.uint8]]:
    """Gray pictures of a folder by file name.

    Raises
    ------
    FileError
        Where there is no such folder, or a picture cannot be read.
    InputError
        Where it holds none.
    """
    if not folder.is_dir():
        raise FileError(f"there is no folder '{folder}' with pictures of the board")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in PICTURES)
    if not files:
        raise InputError(f"{folder} holds no picture of the board")
    pictures = {}
    for file in files:
        picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        if picture is None:
            raise FileError(f"{file} cannot be read as a picture")
        pictures[file.name] = np.asarray(picture, np.uint8)
    return pictures


def _facing(tilt: Floats) -> Floats:
    """Attitude of a board seen by both cameras: in between the directions from the front and from below, then
    tilted."""
    into = np.array([0.0, 1.0, 1.0]) / np.sqrt(2.0)
    along = np.array([1.0, 0.0, 0.0])
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
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Photograph a board as a person would to calibrate the rig, and write the session's file.

    Parameters
    ----------
    own, shared, oil
        Pictures of the board in air for each camera alone, in air for both together, and in the filled tank.

    Returns
    -------
    Path
        Of ``calibration.toml``.
    """
    random = np.random.default_rng(1000 + seed)
    target = Path(folder)
    board = Board()
    middle = np.array([board.columns, board.rows, 0]) * board.square / 2.0
    done = 0
    total = 2 * own + 2 * shared + 2 * oil

    def take(kind: str, view: int, name: str, rotation: Floats, place: Floats) -> None:
        nonlocal done
        camera = rig.cameras[view] if kind == "oil" else rig.without_refraction().cameras[view]
        where = target / kind / camera.name
        where.mkdir(parents=True, exist_ok=True)
        if not cv2.imwrite(str(where / name), board.draw(camera, rotation, place - rotation @ middle, random)):
            raise FileError(f"{where / name} cannot be written")
        done += 1
        if progress is not None:
            progress(done / total)

    for view, camera in enumerate(rig.cameras):
        for number in range(own):
            tilt = np.asarray(Rotation.from_rotvec(random.uniform(-0.6, 0.6, 3)).as_matrix())
            depth = random.uniform(0.25, 0.38)
            corner = np.array([(number % 4) / 3.0 - 0.5, ((number // 2) % 3) / 2.0 - 0.5, 0.0]) * [0.6, 0.5, 0.0]
            spot = np.array([*(corner[:2] * camera.size / camera.matrix[0, 0] * depth), depth])
            place = camera.rotation.T @ (spot - camera.translation)
            take("air", view, f"{camera.name}{number:02d}.png", camera.rotation.T @ tilt, place)
    low, high = rig.tank
    for number in range(shared + oil):
        kind = "air" if number < shared else "oil"
        rotation = _facing(random.uniform(-1, 1, 3) * [0.25, 0.35, 0.35])
        reach = np.abs(rotation @ (middle * [1, 1, 0])) + np.abs(rotation @ (middle * [1, -1, 0]))
        reach = np.minimum(reach / 2.0 + 0.014, (high - low) / 2.0 - 1e-3)
        place = random.uniform(low + reach, high - reach)
        place[0] = low[0] + 0.042 + (high[0] - low[0] - 0.084) * ((number * 0.382) % 1.0)
        if number == shared:
            datum = (rotation, place - rotation @ middle)
        for view in (0, 1):
            take(kind, view, f"both{number:02d}.png", rotation, place)
    _write(rig, target / "calibration.toml", board, f"both{shared:02d}.png", datum)
    return target / "calibration.toml"


def _write(rig: Rig, path: Path, board: Board, picture: str, datum: tuple[Floats, Floats]) -> None:
    import tomli_w

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
            {"name": c.name, "air": f"air/{c.name}", "oil": f"oil/{c.name}", "distance": "350 mm"} for c in rig.cameras
        ],
    }
    path.write_text(tomli_w.dumps(data), encoding="utf-8")
