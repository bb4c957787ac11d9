"""Where a run begins, and in which attitude: the one place that knows how a scenario's device lies at t = 0."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import magnet_start, quaternion_product
from helimag.scenario import Drive, Scenario

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
    along = _along(scenario.drive)
    return -along if _carried_back(scenario) else along


def _along(drive: Drive) -> Floats:
    """Level unit vector (3,) along the magnet's rotation axis at t = 0."""
    yaw, _ = drive.angles
    return np.array([math.cos(yaw), math.sin(yaw), 0.0])


def _carried_back(scenario: Scenario) -> bool:
    """Whether the drive carries the device against the magnet's rotation axis at t = 0."""
    return float(carrying_velocity(scenario) @ _along(scenario.drive)) < 0.0


def carrying_velocity(scenario: Scenario) -> Floats:
    """Velocity (m/s) at t = 0 that keeps a device where it is below the magnet: the drive's, with its yaw (3,)."""
    drive = scenario.drive
    if drive.path is not None:
        spline = drive.path.spline(drive.pitch)
        moving: Floats = np.array(spline(0.0, 1))
        velocity, yaw_rate, centre = moving[:3], float(moving[3]), magnet_start(drive)
    else:
        (vx, vy, vz), (x, y, _), yaw_rate = drive.velocity, drive.start, drive.yaw_rate  # plain: asked by each run
        return np.array([vx - yaw_rate * y, vy + yaw_rate * x, vz])
    x, y, _ = np.array(drive.start) - centre
    carried: Floats = velocity + yaw_rate * np.array([-y, x, 0.0])
    return carried


def _about(axis: int, angle: float) -> Floats:
    """Quaternion (4,) of a turn about a coordinate axis."""
    turned = np.zeros(4)
    turned[0], turned[1 + axis] = math.cos(angle / 2.0), math.sin(angle / 2.0)
    return turned
