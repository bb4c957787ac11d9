"""Where a run begins, and in which attitude: the one place that knows how a scenario's device lies at t = 0."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import quaternion_product
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])  # long axis along x, moment along y
TURNED_ROUND = np.array([0.0, 0.0, 1.0, 0.0])  # half a turn about y: long axis along -x, moment along y


def start_state(scenario: Scenario) -> Floats:
    """Where every run begins: the head at ``drive.start``, in the attitude that ``drive.heading`` says (7,)."""
    return np.array([*scenario.drive.start, *start_attitude(scenario).tolist()])


def start_attitude(scenario: Scenario) -> Floats:
    """Quaternion w, x, y, z of the device at t = 0 (4,).

    Not given, the long axis is along x. Where an end leads, the device is level along the magnet's rotation axis, that
    end forward (:func:`forward`); its moment is beside the magnet's, whichever end leads. Three angles are those of
    R_z(yaw) R_y(-pitch) R_x(roll), appendix A of the paper: pitch is the attack angle.
    """
    drive = scenario.drive
    if drive.heading is None:
        return LEVEL.copy()
    if isinstance(drive.heading, tuple):
        yaw, pitch, roll = drive.heading
        return quaternion_product(_about(2, yaw), quaternion_product(_about(1, -pitch), _about(0, roll)))
    return _lying(drive.angles[0], turned_round=_carried_back(scenario) == (drive.heading == "head")).copy()


@lru_cache(maxsize=64)  # the runs of a sweep begin in few attitudes
def _lying(yaw: float, *, turned_round: bool) -> Floats:
    """Quaternion of a level device along a yaw (rad), nose first or, turned round, tail first."""
    return quaternion_product(_about(2, yaw), TURNED_ROUND if turned_round else LEVEL)


def angles_of_start(scenario: Scenario) -> tuple[float, float, float]:
    """Yaw, pitch and roll (rad) of :func:`start_attitude`: a heading that no change of the drive alters."""
    from scipy.spatial.transform import Rotation

    w, x, y, z = start_attitude(scenario)
    yaw, pitch, roll = Rotation.from_quat([x, y, z, w]).as_euler("ZYX")
    return float(yaw), float(-pitch), float(roll)


def forward(scenario: Scenario) -> Floats:
    """Level unit vector (3,) along the magnet's rotation axis at t = 0, towards where the drive carries the device.

    Where the drive carries it nowhere along that axis, the axis itself.
    """
    yaw, _ = scenario.drive.angles
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    return -along if _carried_back(scenario) else along


def _carried_back(scenario: Scenario) -> bool:
    """Whether the drive carries the device against the magnet's rotation axis at t = 0."""
    yaw, _ = scenario.drive.angles
    x, y, _ = _carrying(scenario)
    return x * math.cos(yaw) + y * math.sin(yaw) < 0.0


def carrying_velocity(scenario: Scenario) -> Floats:
    """Velocity (m/s) at t = 0 that keeps a device where it is below the magnet: the drive's, with its yaw (3,)."""
    return np.array(_carrying(scenario))


def _carrying(scenario: Scenario) -> tuple[float, float, float]:
    """The same as plain numbers, which each run asks for."""
    drive = scenario.drive
    (vx, vy, vz), (x, y, _), yaw_rate = drive.velocity, drive.start, drive.yaw_rate
    if drive.path is not None:
        vx, vy, vz, yaw_rate, *_ = drive.path.spline(drive.pitch)(0.0, 1).tolist()
        left, ahead, _ = drive.path.position[0]
        x, y = x - left, y - ahead
    return vx - yaw_rate * y, vy + yaw_rate * x, vz


def _about(axis: int, angle: float) -> Floats:
    """Quaternion (4,) of a turn about a coordinate axis."""
    turned = np.zeros(4)
    turned[0], turned[1 + axis] = math.cos(angle / 2.0), math.sin(angle / 2.0)
    return turned
