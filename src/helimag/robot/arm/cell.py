"""The cell: arm, tool, where the lab frame stands, and what the arm must not touch. Frozen models read from TOML."""

import math
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from helimag.errors import FileError, InputError
from helimag.files import toml_tables
from helimag.robot.arm.frames import frame, tool_rotation
from helimag.scenario import Acceleration, Angle, AngularRate, Length, Part, Size, messages

Floats = NDArray[np.float64]
Six = tuple[Angle, Angle, Angle, Angle, Angle, Angle]
SixRates = tuple[AngularRate, AngularRate, AngularRate, AngularRate, AngularRate, AngularRate]
Point = tuple[Length, Length, Length]
Model = TypeVar("Model", bound=Part)


class Links(Part):
    """Lengths of an arm with a vertical first axis, two parallel ones and a spherical wrist (m)."""

    d1: Length  # base to the second axis, up
    a1: Length  # first to second axis, forwards
    a2: Size  # second to third axis
    a3: Length  # third axis to the wrist, across the forearm
    d4: Size  # third axis to the wrist, along the forearm
    d6: Length  # wrist to flange


class LinkRadii(Part):
    """Radii of the capsules that stand for the links (m)."""

    column: Size
    upper_arm: Size
    forearm: Size
    wrist: Size


class Arm(Part):
    """A six-axis arm: lengths, limits, and which way its axes turn.

    With all signs positive, axis 1 turns about the base's z, axes 2, 3 and 5 turn the arm forwards and down, axes 4
    and 6 turn about the forearm and the flange's outward normal. KUKA's axes 1, 4 and 6 turn the other way.
    """

    name: str
    link: Links
    radius: LinkRadii
    joint_min: Six
    joint_max: Six
    joint_speed: SixRates
    joint_sign: tuple[int, int, int, int, int, int] = (-1, 1, 1, -1, 1, -1)

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        for i in range(6):
            if not self.joint_min[i] < self.joint_max[i]:
                raise InputError(f".joint_min must be below joint_max; they are not for axis {i + 1}")
            if not self.joint_speed[i] > 0.0:
                raise InputError(f".joint_speed must be positive; it is not for axis {i + 1}")
            if abs(self.joint_sign[i]) != 1:
                raise InputError(f".joint_sign must be 1 or -1; got {self.joint_sign[i]} for axis {i + 1}")
        return self

    @cached_property
    def limits(self) -> Floats:
        """Lowest and highest joint angles (rad): (2, 6)."""
        return np.array([self.joint_min, self.joint_max])


class Base(Part):
    """The lab frame as the arm's base frame sees it: origin, and KUKA's angles A, B, C (about z, then y, then x)."""

    position: Point
    angles: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)


class Tool(Part):
    """Motor and magnet on the flange: the magnet's centre and the motor's axis in the flange frame (z outwards)."""

    magnet: Point
    axis: tuple[float, float, float]
    motor_length: Size
    motor_radius: Size

    @model_validator(mode="after")
    def _axis_has_length(self) -> Self:
        if not (all(map(math.isfinite, self.axis)) and math.hypot(*self.axis) > 1e-6):
            raise InputError(f".axis must be a direction such as [1, 0, 0]; got {list(self.axis)}")
        return self


class Obstacle(Part):
    """A box along the axes of the lab frame."""

    name: str
    low: Point
    high: Point

    @model_validator(mode="after")
    def _has_volume(self) -> Self:
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise InputError(f".low must be below high along all three axes; it is not for '{self.name}'")
        return self


class Cell(Part):
    """Everything around a scenario that its programme depends on."""

    name: str = "unnamed"
    arm: Arm
    base: Base
    tool: Tool
    obstacle: tuple[Obstacle, ...] = ()
    clearance: Size = 0.01
    speed_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.5  # of the joint speeds, that a programme may ask for
    singularity_margin: Angle = math.radians(5.0)
    acceleration: Acceleration = 1.0
    approximation: Size = 1e-4  # $APO.CDIS: how far before a point the arm may begin to round it
    start_output: Annotated[int, Field(ge=1, le=4096)] | None = None  # digital output that is on while the run lasts

    @property
    def joint_percent(self) -> int:
        """``speed_share`` in the whole percent that a controller takes."""
        return max(1, int(100.0 * self.speed_share))

    @cached_property
    def lab_in_base(self) -> Floats:
        """Lab frame in the arm's base frame: (4, 4)."""
        return frame(self.base.position, self.base.angles)

    @cached_property
    def tool_in_flange(self) -> Floats:
        """Tool frame in the flange frame: origin at the magnet's centre, x along the motor's axis: (4, 4)."""
        result = np.eye(4)
        result[:3, :3] = tool_rotation(np.array(self.tool.axis))
        result[:3, 3] = self.tool.magnet
        return result


def load_arm(arm: str | Path) -> Arm:
    """Load an arm: the name of one that comes with helimag (``kr10_r1100_2``), or the path of a TOML file.

    Raises
    ------
    FileError
        Where there is no such file.
    InputError
        Where it is not an arm.
    """
    packaged = resources.files("helimag.robot") / "data" / f"{arm}.toml"
    if str(arm).isidentifier() and packaged.is_file():
        return _model(Arm, toml_tables(packaged.read_text(encoding="utf-8"), str(arm)), str(arm))
    return _model(Arm, toml_tables(_text(Path(arm), "arm"), str(arm)), str(arm))


def load_cell(cell: str | Path | None = None) -> Cell:
    """Load a cell from a TOML file; without one, the default cell. Its ``arm`` is a name, or a path beside the file.

    Raises
    ------
    FileError
        Where the file, or the arm's, cannot be read.
    InputError
        Where it is not a cell.
    """
    if cell is None:
        folder = None
        source = "default cell"
        text = (resources.files("helimag.robot") / "data" / "default_cell.toml").read_text(encoding="utf-8")
    else:
        folder, source, text = Path(cell).parent, str(cell), _text(Path(cell), "cell")
    data = toml_tables(text, source)
    if isinstance(data.get("arm"), str):
        beside = None if folder is None else folder / data["arm"]
        data["arm"] = load_arm(beside if beside is not None and beside.is_file() else data["arm"])
    return _model(Cell, data, source)


def _text(path: Path, what: str) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise FileError(f"{what} must be a TOML file or a name that helimag knows; '{path}' is neither") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from None


def _model(kind: type[Model], data: dict[str, Any], source: str) -> Model:
    try:
        return kind.model_validate(data, context={"file": True})
    except ValidationError as error:
        raise InputError(f"{source}: {'; '.join(messages(error))}") from None
