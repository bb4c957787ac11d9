"""Checks of the magnets: point dipole against cylinder, and keeping in step."""

import math

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.checks.check import Check
from helimag.checks.flow import device_matrices
from helimag.geometry import magnet_start
from helimag.hydrodynamics.motion import roll_resistance
from helimag.physics.kinematics import rpm_rotation
from helimag.physics.magnetics import dipole_field
from helimag.scenario import Magnet, Scenario

Floats = NDArray[np.float64]

# what a magnet's grade leaves open: remanence of N45 is 1.32 to 1.38 T in makers' tables, so moments are known to 2 %
LARGEST_DIPOLE_ERROR = 0.02
LEAST_STEP_OUT_MARGIN = 1.5  # a gap that grows by a seventh takes a third of the field


def magnet_distance(scenario: Scenario) -> Check | None:
    """Error of the pull, where a magnet is taken as a point: of the worst magnet at the start."""
    if scenario.magnet[0].field == "cylinder":
        return None
    places = np.linalg.norm(places_at_start(scenario), axis=1)
    errors = [dipole_error(magnet, float(r)) for magnet, r in zip(scenario.magnet, places, strict=True)]
    worst = int(np.argmax(errors))
    value, widths = errors[worst], places[worst] / (2.0 * scenario.magnet[worst].reach)
    return Check(
        "magnet_distance",
        "magnet.field",
        value,
        "at most",
        LARGEST_DIPOLE_ERROR,
        f"the device starts {widths:.2g} diagonals of the magnet away; a point dipole's pull is up to "
        f"{100.0 * value:.2g} % off there",
        'set magnet.field = "cylinder"',
    )


def dipole_error(magnet: Magnet, distance: float) -> float:
    """Relative error of a point dipole's pull (m/m) on the axis of a cylinder, where it is largest; first order.

    The multipole of order 3 over that of order 1: q3/q1 = h^2 - 3/4 a^2 for half height h and radius a, times 20/6 for
    the gradient on the axis.
    """
    ratio = (magnet.height / 2.0) ** 2 - 0.75 * magnet.radius**2
    return 20.0 / 6.0 * abs(ratio) / distance**2


def step_out(scenario: Scenario) -> Check:
    """Step-out frequency over the drive's, at the start."""
    value = step_out_frequency(scenario) / abs(scenario.drive.frequency)
    return Check(
        "step_out",
        "drive.frequency",
        value,
        "at least",
        LEAST_STEP_OUT_MARGIN,
        f"the weakest field of a turn can turn the device {value:.2g} times as fast as the drive at the start",
        f"turn at {abs(scenario.drive.frequency) * value / LEAST_STEP_OUT_MARGIN:.2g} Hz or less, or bring the magnet "
        "nearer",
    )


def step_out_frequency(scenario: Scenario) -> float:
    """Frequency (Hz) at which the torque of the weakest field of a turn just rolls the device along, at the start.

    m B / (2 pi roll resistance). A lower bound: straight below a dipole, where the field is between B and 2 B, step is
    lost at 1.44 times this frequency (numerically, of the planar equation of roll).
    """
    _, inverse = device_matrices(scenario.device, scenario.fluid)
    torque = scenario.device.magnetic_moment * least_field(scenario)
    return torque / (2.0 * math.pi * roll_resistance(inverse))


def least_field(scenario: Scenario) -> float:
    """Weakest flux density (T) of a turn at the start: the smaller half-axis of the ellipse that it describes."""
    return float(np.linalg.svd(turning_field(scenario), compute_uv=False)[-1])


def field_axis(scenario: Scenario) -> Floats:
    """Unit axis (3,) about which the field turns at the start, in the sense of a positive frequency."""
    normal = np.cross(*turning_field(scenario).T)
    axis: Floats = normal / np.linalg.norm(normal)
    return axis


def turning_field(scenario: Scenario) -> Floats:
    """Flux density (T) at the start, lab frame, magnets taken as dipoles: (3, 2).

    Columns for a spin of zero and of a quarter turn; the field is linear in the moments, so at a spin s it is the first
    times cos s and the second times sin s.
    """
    rotation = rotation_at_start(scenario)
    axes = np.zeros((3, 2))
    for magnet, place in zip(scenario.magnet, places_at_start(scenario), strict=True):
        cos, sin = math.cos(magnet.phase or 0.0), math.sin(magnet.phase or 0.0)
        for column, direction in enumerate(([0.0, cos, sin], [0.0, -sin, cos])):
            moment = magnet.dipole_moment * rotation @ np.array(direction)
            axes[:, column] += np.array(dipole_field(wp.vec3d(*place), wp.vec3d(*moment)))
    return axes


def places_at_start(scenario: Scenario) -> Floats:
    """Device at the start, seen from each magnet, lab frame (m): (magnets, 3)."""
    offsets = np.array([magnet.offset for magnet in scenario.magnet])
    away = np.array(scenario.drive.start) - magnet_start(scenario.drive)
    places: Floats = away - offsets @ rotation_at_start(scenario).T
    return places


def rotation_at_start(scenario: Scenario) -> Floats:
    """R_a of eq. (3) at t = 0: arm frame to lab."""
    yaw, pitch = scenario.drive.angles
    angles = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array(rpm_rotation(*(wp.float64(value) for value in angles))).reshape(3, 3)
