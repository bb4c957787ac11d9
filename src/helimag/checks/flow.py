"""Checks of the flow: Reynolds number, resistive-force theory, and what walls would change."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from helimag.checks.check import Check
from helimag.errors import InputError
from helimag.hydrodynamics import boundary, error_estimate, mobility, net_weight, resistance
from helimag.hydrodynamics.boundary import LEAST_GAP
from helimag.hydrodynamics.bounds import drag_ratio, enclosing_resistance, most_drag_ratio
from helimag.hydrodynamics.motion import advance_per_turn, largest_drag, sinking_speeds
from helimag.scenario import Device, Fluid, Scenario

Floats = NDArray[np.float64]

# drag of a sphere rises by 3/8 Re (its radius; Oseen 1910, Proudman and Pearson, J. Fluid Mech. 2 (1957) 237): 4 %
LARGEST_REYNOLDS = 0.1
RESISTIVE_FORCE = ("lighthill", "gray-hancock")
# resistive-force theory beside measured helices: B. Rodenborn et al., PNAS 110 (2013) E338; docs/model.md, known limits
SHORTEST_TURN = 144.0  # wire radii: thrust and drag are up to 90 % off there
LARGEST_PITCH_ANGLE = math.radians(22.4)  # up to 26 % off there, 90 % at 44 deg, four times too much at 70 deg
LARGEST_MISFIT = 1.1  # the boundary solver's own distance from measured helices (benchmarks/boundary_truth.py)
HEIGHTS = ("workspace.floor", "workspace.surface")
LARGEST_WALL_EFFECT = 0.1  # of the drag: less is below what the drag models are worth


@lru_cache(maxsize=64)  # sweeps change drives more often than devices
def device_matrices(device: Device, fluid: Fluid) -> tuple[Floats, Floats]:
    """Resistance and mobility of a device (SI)."""
    matrix = resistance(device, fluid)
    return matrix, mobility(matrix)


def reynolds(scenario: Scenario) -> Check:
    """Reynolds number of turning and of moving, the larger: inertia of the fluid is not in the model.

    Turning: rim speed and radius of the device. Moving: half its length, and the fastest of the magnet's speed, free
    swimming and sinking upright.
    """
    device, fluid, drive = scenario.device, scenario.fluid, scenario.drive
    matrix, inverse = device_matrices(device, fluid)
    kinematic = fluid.viscosity / fluid.density if fluid.density > 0.0 else math.inf
    radius, spin = max(device.tail_radius, device.head_radius), 2.0 * math.pi * abs(drive.frequency)
    fastest = max(
        math.hypot(*drive.velocity),
        abs(advance_per_turn(inverse) * drive.frequency),
        abs(sinking_speeds(matrix, net_weight(device, fluid)[0])[1]),
    )
    turning, moving = spin * radius**2 / kinematic, fastest * device.length / 2.0 / kinematic
    what, value = max(("turning", turning), ("moving", moving), key=lambda pair: pair[1])
    return Check(
        "reynolds",
        "fluid.viscosity",
        value,
        "at most",
        LARGEST_REYNOLDS,
        f"Reynolds number of {what} is {value:.2g}; drag of a sphere would be {37.5 * value:.2g} % larger by inertia",
        "use a fluid of higher viscosity, or a slower drive",
    )


def slenderness(scenario: Scenario) -> Check | None:
    """Length of wire in a turn over the wire's radius, where drag is that of resistive-force theory."""
    helix = scenario.device.helix
    if helix is None or scenario.device.hydrodynamics.model not in RESISTIVE_FORCE:
        return None
    value = helix.pitch * helix.contour_per_length / helix.wire_radius
    return Check(
        "slenderness",
        "device.helix.wire_radius",
        value,
        "at least",
        SHORTEST_TURN,
        f"a turn of wire is {value:.3g} wire radii long; at {SHORTEST_TURN:g} resistive-force theory is 90 % off",
        'use device.hydrodynamics.model = "boundary"',
    )


def pitch_angle(scenario: Scenario) -> Check | None:
    """Angle between wire and axis, where drag is that of resistive-force theory: steep turns feel each other."""
    helix = scenario.device.helix
    if helix is None or scenario.device.hydrodynamics.model not in RESISTIVE_FORCE:
        return None
    value = math.atan2(2.0 * math.pi * helix.radius, helix.pitch)
    return Check(
        "pitch_angle",
        "device.helix.pitch",
        value,
        "at most",
        LARGEST_PITCH_ANGLE,
        f"wire at {math.degrees(value):.3g} deg to its axis; resistive-force theory is 26 % off at 22 deg, 90 % at 44",
        'use device.hydrodynamics.model = "boundary"',
    )


def enclosing_body(scenario: Scenario) -> Check:
    """Drag over that of a spheroid around the device, in the motion where it is largest: above one is impossible.

    A body's Stokes dissipation in any rigid motion is at most that of a body which encloses it: the latter's flow is
    one of those among which the former's is least. What the boundary solver states as its error does not count.
    """
    device, fluid = scenario.device, scenario.fluid
    matrix, _ = device_matrices(device, fluid)
    around = enclosing_resistance(device, fluid)
    value = drag_ratio(matrix, around)
    return Check(
        "enclosing_body",
        "device.hydrodynamics.model",
        value,
        "at most",
        most_drag_ratio(error_estimate(device)),
        f"drag is up to {value:.2g} times that of a spheroid around the device, which none can exceed (along the axis "
        f"{matrix[0, 0] / around[0, 0]:.2g} times)",
        'use device.hydrodynamics.model = "boundary"',
    )


def boundary_drag(scenario: Scenario) -> Check | None:
    """Drag by resistive-force theory over that by the boundary solver, in the motion in which they differ most.

    Seconds of computing for a device that was not solved before, so not among the checks of every run.
    """
    device, fluid = scenario.device, scenario.fluid
    if device.helix is None or device.hydrodynamics.model not in RESISTIVE_FORCE:
        return None
    field = "device.hydrodynamics.model"
    remedy = 'use device.hydrodynamics.model = "boundary"'
    try:
        truth = fluid.viscosity * boundary.solution(device).resistance
    except InputError as error:
        return Check(
            "boundary_drag", field, math.inf, "at most", LARGEST_MISFIT, f"not comparable: {error}", "see docs/model.md"
        )
    matrix, inverse = device_matrices(device, fluid)
    root = np.linalg.inv(np.linalg.cholesky(truth))
    ratios = np.linalg.eigvalsh(root @ matrix @ root.T)
    along, across, roll = (float(matrix[i, i] / truth[i, i]) for i in (0, 1, 3))
    swims = advance_per_turn(inverse) / advance_per_turn(mobility(truth))
    return Check(
        "boundary_drag",
        field,
        float(max(ratios[-1], 1.0 / ratios[0])),
        "at most",
        LARGEST_MISFIT,
        f"drag is {along:.2g} times that of the boundary solver along the axis, {across:.2g} across, {roll:.2g} in "
        f"roll; it swims {swims:.2g} times as far a turn",
        remedy,
    )


def wall_gap(scenario: Scenario) -> Check | None:
    """How much the nearest of floor, surface and walls would change the drag at the start, where it is of open fluid.

    First order in size over distance: k R / (6 pi mu h), k = 9/8 for a wall and 3/4 for a free surface, both across
    (H. Brenner, J. Fluid Mech. 12 (1962) 35; signs differ, sizes count here). Where floor and surface raise the drag of
    a run (``near_walls``), only upright walls are left.
    """
    resistance_, _ = device_matrices(scenario.device, scenario.fluid)
    size = largest_drag(resistance_) / (6.0 * math.pi * scenario.fluid.viscosity)
    counted = HEIGHTS if scenario.device.hydrodynamics.near_walls else ()
    effects = [(factor * size / gap, path, gap) for path, gap, factor in _gaps(scenario) if path not in counted]
    if not effects:
        return None
    value, path, gap = max(effects)
    return Check(
        "wall_gap",
        path,
        value,
        "at most",
        LARGEST_WALL_EFFECT,
        f"{path} is {gap / scenario.device.length:.2g} device lengths from the start and would change the drag "
        f"by {_share(value)}",
        f"start {1e3 * gap * value / LARGEST_WALL_EFFECT:.3g} mm or more away from it",
    )


def wall_resolved(scenario: Scenario) -> Check | None:
    """Gap at the start over the device's largest radius, where floor and surface raise the drag (``near_walls``).

    Lubrication is not resolved: a gap of less than the tables' least counts as that.
    """
    device = scenario.device
    gaps = [(gap, path) for path, gap, _ in _gaps(scenario) if path in HEIGHTS]
    if not (device.hydrodynamics.near_walls and gaps):
        return None
    radius = max(device.tail_radius, device.head_radius)
    heading = scenario.drive.heading
    pitch = heading[1] if isinstance(heading, tuple) else 0.0
    rises = {"workspace.floor": math.sin(pitch), "workspace.surface": -math.sin(pitch)}  # of the nose from the plane
    left, path = min((gap - _reach(device, rises[path]), path) for gap, path in gaps)
    value = left / radius
    return Check(
        "wall_resolved",
        path,
        value,
        "at least",
        LEAST_GAP,
        f"the device starts {value:.2g} of its radius from {path}; nearer than {LEAST_GAP:g} its drag rises no more, "
        "so that it comes to the wall too fast",
        f"start with a gap of {1e3 * LEAST_GAP * radius:.2g} mm or more",
    )


def _reach(device: Device, rise: float) -> float:
    """How much nearer to a plane than the origin an end comes as the device rolls, its nose rising from it (m)."""
    across = math.sqrt(1.0 - rise**2)
    return max(
        -device.front * rise + device.head_radius * across, device.tail_length * rise + device.tail_radius * across
    )


def _share(value: float) -> str:
    """A relative change in words; the first order is no number where it is large."""
    return f"about {100.0 * value:.2g} %" if value < 0.5 else "more than half"


def _gaps(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Path, distance from the start (m) and Brenner's factor of every limit of the workspace."""
    low, high = scenario.workspace.box
    start = scenario.drive.start
    names = (("workspace.walls.x",) * 2, ("workspace.walls.y",) * 2, ("workspace.floor", "workspace.surface"))
    found = []
    for i, (below, above) in enumerate(names):
        found.append((below, start[i] - low[i], 9.0 / 8.0))
        found.append((above, high[i] - start[i], 3.0 / 4.0 if above == "workspace.surface" else 9.0 / 8.0))
    return [(path, gap, factor) for path, gap, factor in found if math.isfinite(gap)]
