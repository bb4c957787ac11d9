"""A calibration session: board, tank and pictures, as a TOML file with units."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from helimag import quantities as q
from helimag.errors import InputError
from helimag.files import text_of, toml_tables
from helimag.vision.calibration.boards import Board

Floats = NDArray[np.float64]

FACES = ("x low", "y low", "z low", "x high", "y high", "z high")


@dataclass(frozen=True)
class View:
    """One camera's pictures: of the board in air, and of the board in the filled tank."""

    name: str
    air: Path
    oil: Path
    distance: float  # of the wall from the camera, roughly (m)
    wall: str | None = None  # the tank's face that it looks through, such as "y low", where the session says so
    lens: Path | None = None  # OpenCV's or MATLAB's calibration of it in air, where there is one


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
    thickness_sd
        Standard deviation of either wall's thickness (m); default as a caliper tells it.
    index_sds
        Standard deviations of the indices of wall and oil; default as sheets of plexiglass differ, and as a
        refractometer or a table tells an oil's.
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
    thickness_sd: float = 0.1e-3
    index_sds: tuple[float, float] = (0.005, 0.002)

    @classmethod
    def load(cls, path: str | Path) -> "Session":
        """Read a session's TOML file; folders are relative to it.

        Returns
        -------
        Session
            Checked.

        Raises
        ------
        FileError
            Where the file cannot be read.
        InputError
            Where it is not a calibration session.
        """
        source = Path(path)
        data = toml_tables(text_of(source), str(path))
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


def _wall(table: dict[str, Any]) -> str | None:
    wall = table.get("wall")
    if wall is not None and wall not in FACES:
        raise InputError(f"camera {table['name']}.wall must be one of {', '.join(FACES)}; got {wall!r}")
    return wall


def _index_sds(given: Any) -> tuple[float, float]:
    """Standard deviations of the indices of wall and oil."""
    numbers = isinstance(given, list) and all(isinstance(sd, (int, float)) and not isinstance(sd, bool) for sd in given)
    if not numbers or len(given) != 2 or not all(np.isfinite(sd) and sd > 0.0 for sd in given):
        raise InputError(
            f"tank.index_sds must be the standard deviations of the indices of wall and oil, two numbers greater than "
            f"zero such as [0.005, 0.002]; got {given!r}"
        )
    return float(given[0]), float(given[1])


def _session(data: dict[str, Any], folder: Path) -> Session:
    board, tank, datum = data["board"], data["tank"], data["datum"]
    cameras = data["camera"]
    if not isinstance(cameras, list) or len(cameras) != 2:
        raise InputError("[[camera]] must be given twice")
    views = [
        View(
            str(c["name"]),
            folder / c["air"],
            folder / c["oil"],
            _length(c, "distance", f"camera {c['name']}"),
            _wall(c),
            folder / str(c["lens"]) if "lens" in c else None,
        )
        for c in cameras
    ]
    indices = tuple(float(tank["indices"][i]) for i in range(3))
    estimate = tank.get("estimate_oil", False)
    if not isinstance(estimate, bool):
        raise InputError(f"tank.estimate_oil must be true or false; got {estimate!r}")
    thickness_sd = _length(tank, "wall_thickness_sd", "tank") if "wall_thickness_sd" in tank else Session.thickness_sd
    if not thickness_sd > 0.0:
        raise InputError(f"tank.wall_thickness_sd must be a length greater than zero; got {thickness_sd} m")
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
        thickness_sd=thickness_sd,
        index_sds=_index_sds(tank.get("index_sds", list(Session.index_sds))),
    )
