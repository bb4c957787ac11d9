"""Checks of the magnets: whether their field holds where the device starts, and keeping in step."""

import math

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.checks.check import Check
from helimag.checks.flow import device_matrices
from helimag.geometry import magnet_start
from helimag.hydrodynamics.motion import roll_resistance
from helimag.physics.kinematics import rpm_rotation
from helimag.physics.magnetics import HIGHEST_ORDER, dipole_field, slices_of
from helimag.scenario import Magnet, Scenario

Floats = NDArray[np.float64]

# what a magnet's grade leaves open: remanence of N45 is 1.32 to 1.38 T in makers' tables, so moments are known to 2 %
LARGEST_DIPOLE_ERROR = 0.02
LARGEST_SERIES_ERROR = 0.005  # what forces of a cylinder are held to against magpylib outside a diameter
PER_MOMENT = 1e-7  # T m / A: mu0 / 4 pi, as the kernels have it
SPINS = 64  # of a turn
RADII, AROUND = 8, 64  # places on the end of a cylinder
NOUGHT = 1e-9  # of the field of one magnet alone: two that cancel leave this much by rounding
LEAST_STEP_OUT_MARGIN = 1.5  # a gap that grows by a seventh takes a third of the field


def magnet_distance(scenario: Scenario) -> Check:
    """Error of the pull, of a magnet taken as a point or as a series of multipoles: of the worst at the start."""
    if scenario.magnet[0].field == "cylinder":
        return _series(scenario)
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


def _series(scenario: Scenario) -> Check:
    """Of cylinders, whose multipoles are summed up to an order."""
    axis = rotation_at_start(scenario)[:, 0]
    magnets = zip(scenario.magnet, places_at_start(scenario), strict=True)
    errors, gaps = zip(*(series_error(magnet, place, axis) for magnet, place in magnets), strict=True)
    worst = int(np.argmax(errors))
    value, widths = errors[worst], gaps[worst] / (2.0 * scenario.magnet[worst].radius)
    return Check(
        "magnet_distance",
        "drive.distance",
        value,
        "at most",
        LARGEST_SERIES_ERROR,
        f"the device starts {widths:.2g} diameters from the middle of the magnet or of a slice of it; the cylinder's "
        f"field is up to about {100.0 * value:.2g} % off there",
        "start farther away: from one diameter on it is exact to 0.1 %",
    )


def series_error(magnet: Magnet, place: Floats, axis: Floats) -> tuple[float, float]:
    """Relative error of a cylinder's multipole sum at a place (3,) from its centre as it turns about ``axis``.

    Four times the first power left out, which a flat disc's first order left out comes to on its axis. The second
    number is the distance (m) from the nearest middle of a slice.
    """
    count = slices_of(magnet.radius, magnet.height)
    thickness = magnet.height / count
    reach = (magnet.height - thickness) / 2.0  # from the centre to the last middle
    across = math.sqrt(max(0.0, float(place @ place - (place @ axis) ** 2)))  # how far the turning axis points there
    near = min(across, reach)
    gap = math.sqrt(max(0.0, float(place @ place) + near**2 - 2.0 * near * across))
    size = math.hypot(magnet.radius, thickness / 2.0)
    return (4.0 * (size / gap) ** (int(HIGHEST_ORDER) + 1) if gap > 0.0 else math.inf), gap


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
    """Weakest flux density (T) of a turn at the start: of dipoles the smaller half-axis of the ellipse described."""
    if scenario.magnet[0].field == "dipole":
        return float(np.linalg.svd(turning_field(scenario), compute_uv=False)[-1])
    return weakest_and_strongest(cylinders_over_a_turn(scenario))[0]


def weakest_and_strongest(fields: Floats) -> tuple[float, float]:
    """Least and greatest flux density (T) of a turn, from those (n, 3) at evenly spaced spins.

    The square of either is at the top of a parabola through three spins.
    """
    squares = np.sum(fields**2, axis=1)
    return math.sqrt(max(0.0, -_top(-squares))), math.sqrt(_top(squares))


def _top(values: Floats) -> float:
    """Greatest value between those of a turn, on the parabola through the greatest of them and its neighbours."""
    at = int(values.argmax())
    before, here, after = (float(values[(at + k) % len(values)]) for k in (-1, 0, 1))
    bend = 2.0 * here - before - after
    return here if bend <= 0.0 else here + (after - before) ** 2 / (8.0 * bend)


def field_axis(scenario: Scenario) -> Floats:
    """Unit axis (3,) about which the field turns at the start, in the sense of a positive frequency.

    A field that only swings to and fro, or that there is none of, turns about none: the magnets' own axis then.
    """
    if scenario.magnet[0].field == "dipole":
        normal = np.cross(*turning_field(scenario).T)
    else:
        fields = cylinders_over_a_turn(scenario)
        normal = np.cross(fields, np.roll(fields, -1, axis=0)).mean(axis=0)
    size = float(np.linalg.norm(normal))
    if not size > NOUGHT * field_without_cancelling(scenario) ** 2:
        own: Floats = rotation_at_start(scenario)[:, 0]
        return own
    axis: Floats = normal / size
    return axis


def field_without_cancelling(scenario: Scenario) -> float:
    """Flux density (T) that the magnets would have at the start if none weakened another's, about."""
    distances = np.linalg.norm(places_at_start(scenario), axis=1)
    moments = np.array([magnet.dipole_moment for magnet in scenario.magnet])
    return float(np.sum(PER_MOMENT * moments / distances**3))


def turning_field(scenario: Scenario) -> Floats:
    """Flux density (T) at the start, lab frame, magnets taken as dipoles: (3, 2).

    Columns for a spin of zero and of a quarter turn; the field is linear in the moments, so at a spin s it is the first
    times cos s and the second times sin s.
    """
    axes = np.zeros((3, 2))
    for magnet, place in zip(scenario.magnet, places_at_start(scenario), strict=True):
        for column, direction in enumerate(moment_directions(scenario, magnet, np.array([0.0, math.pi / 2.0]))):
            moment = magnet.dipole_moment * direction
            axes[:, column] += np.array(dipole_field(wp.vec3d(*place), wp.vec3d(*moment)))
    return axes


def moment_directions(scenario: Scenario, magnet: Magnet, spins: Floats) -> Floats:
    """Unit vectors (n, 3) along a magnet's moment at the start, lab frame, at spins (n,), rad."""
    angle = spins + (magnet.phase or 0.0)
    directions: Floats = np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    return directions @ rotation_at_start(scenario).T


def cylinders_over_a_turn(scenario: Scenario) -> Floats:
    """Flux density (T) at the start, lab frame, of cylinders, at evenly spaced spins: (n, 3)."""
    spins = np.linspace(0.0, 2.0 * math.pi, SPINS, endpoint=False, dtype=np.float64)
    total = np.zeros((SPINS, 3))
    for magnet, place in zip(scenario.magnet, places_at_start(scenario), strict=True):
        total += cylinder_field(magnet, place, moment_directions(scenario, magnet, spins))
    return total


def cylinder_field(magnet: Magnet, place: Floats, axes: Floats) -> Floats:
    """Flux density (T) of a cylinder magnetised along axes (n, 3) at a place (3,) outside, from its centre: (n, 3).

    That of its ends, discs of opposite charge: by Gauss points along their radii, and evenly around (J. D. Jackson,
    Classical Electrodynamics, 3rd ed., sec. 5.9).
    """
    nodes, weights = np.polynomial.legendre.leggauss(RADII)
    radii = magnet.radius * np.sqrt((1.0 + nodes) / 2.0)
    turns = 2.0 * math.pi / AROUND * np.arange(AROUND)
    around = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    corner = (radii[:, None, None] * around).reshape(-1, 2)
    share = np.repeat(weights / (2.0 * AROUND), AROUND)
    helper = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    across = np.cross(axes, helper)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    discs = np.einsum("kc,nci->nki", corner, np.stack([across, np.cross(axes, across)], axis=1))
    field = np.zeros_like(axes)
    for end in (0.5, -0.5):
        away = place - end * magnet.height * axes[:, None] - discs
        cubes = np.linalg.norm(away, axis=2) ** 3
        field += math.copysign(1.0, end) * np.einsum("k,nki->ni", share, away / cubes[:, :, None])
    return PER_MOMENT * magnet.dipole_moment / magnet.height * field


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
