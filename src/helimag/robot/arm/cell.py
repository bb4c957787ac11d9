"""The cell: arm, tool, where the lab frame stands, and what the arm must not touch. Frozen models read from TOML."""

import math
from functools import cached_property
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.files import toml_tables
from helimag.robot.arm.frames import frame, tool_rotation
from helimag.robot.models import named_tables, packaged
from helimag.scenario import Acceleration, Angle, AngularRate, Inertia, Length, Mass, Part, Scenario, Size, model_of

Floats = NDArray[np.float64]
Six = tuple[Angle, Angle, Angle, Angle, Angle, Angle]
SixRates = tuple[AngularRate, AngularRate, AngularRate, AngularRate, AngularRate, AngularRate]
Point = tuple[Length, Length, Length]
Port = Annotated[int, Field(ge=1, le=4096)]  # number of a digital input or output
SAME = 1e-6  # m; corners closer than this are one
TANK = "tank"  # the obstacle that the device swims in


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
    payload: Mass | None = None
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


class Load(Part):
    """What hangs on the flange, for the controller ($LOAD): centre and inertia along the flange's axes."""

    mass: Mass
    center: Point
    inertia: tuple[Inertia, Inertia, Inertia] = (0.0, 0.0, 0.0)  # about the centre of mass


class Motor(Part):
    """Digital signals between the programme and the controller of the magnet's motor.

    ``phase_input`` rises once a turn, when the moment is at ``phase_angle`` about the tool's x axis from its y axis.
    """

    run_output: Port  # on: the motor turns
    speed_input: Port | None = None  # on while it turns at the scenario's frequency
    phase_input: Port | None = None
    phase_angle: Angle = 0.0

    @model_validator(mode="after")
    def _inputs_differ(self) -> Self:
        if self.speed_input is not None and self.speed_input == self.phase_input:
            raise InputError(f".phase_input must be another input than speed_input; both are {self.phase_input}")
        return self

    @property
    def inputs(self) -> frozenset[int]:
        """Numbers of the inputs that the motor answers on."""
        return frozenset(port for port in (self.speed_input, self.phase_input) if port is not None)


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
    start_output: Port | None = None  # digital output that is on while the run lasts
    motor: Motor | None = None
    load: Load | None = None
    retreat: Size | None = None  # how far the arm goes up when the path is over

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        if self.motor is not None and self.motor.run_output == self.start_output:
            raise InputError(f"motor.run_output must be another output than start_output; both are {self.start_output}")
        most = self.arm.payload
        if self.load is not None and most is not None and self.load.mass > most:
            got, limit = q.show(self.load.mass, q.MASS), q.show(most, q.MASS)
            raise InputError(f"load.mass must be at most {limit}, what {self.arm.name} carries; got '{got}'")
        return self

    @property
    def inputs(self) -> frozenset[int]:
        """Numbers of the inputs that a programme may wait for."""
        return frozenset() if self.motor is None else self.motor.inputs

    @property
    def tank(self) -> Obstacle | None:
        """The obstacle that holds the device; None where the cell has none."""
        return next((obstacle for obstacle in self.obstacle if obstacle.name == TANK), None)

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

    Returns
    -------
    Arm
        With dimensions in m and limits in rad.

    Raises
    ------
    FileError
        Where there is no such file.
    InputError
        Where it is not an arm.
    """
    known = packaged(f"{arm}.toml")
    if known is not None:
        return model_of(Arm, toml_tables(known.read_text(encoding="utf-8"), str(arm)), str(arm))
    return model_of(Arm, named_tables(Path(arm), "arm"), str(arm))


def load_cell(cell: str | Path | None = None) -> Cell:
    """Load a cell: a TOML file, the name of one that comes with helimag (``wide``), or the default cell.

    Its ``arm`` is a name, or a path beside the file.

    Returns
    -------
    Cell
        With its arm, its boxes (m, lab frame) and what it allows.

    Raises
    ------
    FileError
        Where the file, or the arm's, cannot be read.
    InputError
        Where it is not a cell.
    """
    cell = "default" if cell is None else cell
    known = packaged(f"{cell}_cell.toml")
    if known is not None:
        source = f"{cell} cell"
        data = toml_tables(known.read_text(encoding="utf-8"), source)
    else:
        source = str(cell)
        data = named_tables(Path(cell), "cell")
    if isinstance(data.get("arm"), str):
        arm = data["arm"]
        data["arm"] = load_arm(arm if packaged(f"{arm}.toml") is not None else Path(cell).parent / arm)
    return model_of(Cell, data, source)


def check_tank(cell: Cell, scenario: Scenario) -> None:
    """Raise InputError where a scenario and the tank of a cell do not go together: one tank serves both.

    The device must start inside it, and so must the scenario's own walls, floor and surface be; they may be closer.
    """
    tank = cell.tank
    if tank is None:
        return
    remedy = f"give a cell whose tank holds it (--cell), or change the scenario; cell '{cell.name}'"
    axes = zip("xyz", tank.low, tank.high, scenario.drive.start, *scenario.workspace.box, strict=True)
    for axis, low, high, start, near, far in axes:
        span = f"{axis} from {q.show(low, q.LENGTH)} to {q.show(high, q.LENGTH)}"
        if not low < start < high:
            got = q.show(start, q.LENGTH)
            raise InputError(f"drive.start must be inside the cell's tank, {span}; got '{got}'; {remedy}")
        for end in (near, far):
            if math.isfinite(end) and not low - SAME <= end <= high + SAME:
                got = q.show(end, q.LENGTH)
                raise InputError(f"workspace must lie inside the cell's tank, {span}; got {axis} '{got}'; {remedy}")
