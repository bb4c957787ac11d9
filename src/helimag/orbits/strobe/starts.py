"""Where to begin the search for orbits: along runs, and on a grid of places with the attitude settled."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from helimag.engine import MULTIREVOLUTION, TOLERANCE, Method, advance
from helimag.geometry import long_axes, quaternion_product, turn
from helimag.orbits.strobe.newton import solve
from helimag.orbits.strobe.problem import Floats, Ints, Problem, let_go
from helimag.outcomes import End
from helimag.physics import evaluate
from helimag.physics.magnetics import dipole_field
from helimag.scenario import Scenario, Workspace

SETTLING = 4  # periods with the head held before the attitude is solved for


@dataclass(frozen=True)
class Strobed:
    """A run at whole turns of the magnet: times (n,), states (n, 7), moving frame; and how and when (s) it ended."""

    times: Floats
    states: Floats
    status: End
    end: float


def strobed(
    scenario: Scenario,
    duration: float,
    *,
    samples: int,
    states: Floats | None = None,
    tolerance: float = TOLERANCE,
    method: Method = MULTIREVOLUTION,
    progress: Callable[[float], None] | None = None,
) -> list[Strobed]:
    """Full runs of about ``duration`` (s), from states (m, 7) of the moving frame; one from the scenario's own start.

    A run from a state starts as if at t = 0, where lab and moving frame are one: the equations see no difference.
    """
    period = 1.0 / abs(scenario.drive.frequency)
    stride = max(1, round(duration / (samples * period))) * period
    count = max(2, math.ceil(duration / stride - 1e-9))
    run = let_go(scenario).replaced({"run.duration": count * stride, "run.interval": stride})
    begun = None if states is None else to_lab(scenario, np.zeros(len(states)), states)
    many = 1 if states is None else len(states)
    result = []
    engine: dict[str, Any] = {"tolerance": tolerance, "method": method, "progress": progress}
    for history in advance([run] * many, initial_states=begun, **engine):
        whole = np.round(history.time / stride)
        kept = (np.abs(history.time / stride - whole) < 1e-9) & np.isfinite(history.states).all(axis=1)
        times = whole[kept] * stride
        moving = to_moving(scenario, times, history.states[kept])
        result.append(Strobed(times, moving, history.status, float(history.time[-1])))
    return result


def open_water(scenario: Scenario) -> Scenario:
    """The scenario without what a drive that moves on comes to in the end however the device swims in its frame.

    Those are the walls where it moves sideways, floor and surface where it rises or sinks. What is left does not hold.
    """
    nothing, workspace = Workspace(), let_go(scenario).workspace
    x, y, z = scenario.drive.velocity
    if x or y:
        workspace = workspace.model_copy(update={"walls": nothing.walls})
    if z:
        workspace = workspace.model_copy(update={"floor": nothing.floor, "surface": nothing.surface})
    return scenario.model_copy(update={"workspace": workspace})


def to_moving(scenario: Scenario, times: Floats, states: Floats) -> Floats:
    """States (n, 7) of the lab frame at ``times`` (n,) as seen in the frame that moves with the drive."""
    drive = scenario.drive
    shifted = states.copy()
    shifted[:, :3] -= times[:, None] * np.array(drive.velocity)
    return turned(shifted, -drive.yaw_rate * times)


def to_lab(scenario: Scenario, times: Floats, states: Floats) -> Floats:
    """The way back from :func:`to_moving`."""
    drive = scenario.drive
    result = turned(states, drive.yaw_rate * times)
    result[:, :3] += times[:, None] * np.array(drive.velocity)
    return result


def turned(states: Floats, angles: Floats) -> Floats:
    """States turned about the z axis by ``angles`` (n,)."""
    zero = np.zeros_like(angles)
    about_z = np.stack([np.cos(angles / 2.0), zero, zero, np.sin(angles / 2.0)], axis=1)
    position = np.einsum("nij,nj->ni", turn(2, angles), states[:, :3])
    return np.concatenate([position, quaternion_product(about_z, states[:, 3:])], axis=1)


def default_box(scenario: Scenario, arm: Floats) -> tuple[Floats, Floats]:
    """Corners (3,) of a region around the place below the magnet where device and weight can balance."""
    d = scenario.drive.distance
    least = scenario.contact_distance
    low = arm + np.array([-0.7 * d, -0.7 * d, -1.8 * d])
    high = arm + np.array([0.7 * d, 0.7 * d, -min(1.5 * least, 0.5 * d)])
    return low, high


def on_grid(
    problem: Problem, one: int, low: Floats, high: Floats, shape: tuple[int, int, int], *, both_ways: bool = False
) -> Floats:
    """States (n, 7) at the nodes of a grid between two corners, each with the attitude that it settles to when held.

    With ``both_ways`` the device also starts with its nose towards the other end of the field's axis.
    """
    axes = [
        np.linspace(a, b, n) if n > 1 else np.array([(a + b) / 2]) for a, b, n in zip(low, high, shape, strict=True)
    ]
    places = np.array(list(product(*axes)))
    gap = np.linalg.norm(places - problem.arm[one], axis=1)
    places = places[gap > 1.05 * problem.contact[one]]
    senses = (1.0, -1.0) if both_ways else (1.0,)
    states = np.concatenate([attitudes(problem, one, places, sense) for sense in senses])
    settled, found = settle(problem, np.full(len(states), one), states)
    return np.asarray(settled[found])


def attitudes(problem: Problem, one: int, places: Floats, sense: float = 1.0) -> Floats:
    """States (n, 7) at places (n, 3): long axis along the axis of the turning field, moment along it at t = 0."""
    scenario = problem.scenarios[one]
    pitch = scenario.drive.pitch
    up = np.array([-math.sin(pitch), 0.0, math.cos(pitch)])  # where the moment points a quarter turn after y, eq. (3)
    away = places - problem.arm[one]
    field = evaluate(dipole_field, away, np.array([0.0, 1.0, 0.0]))
    later = evaluate(dipole_field, away, math.copysign(1.0, scenario.drive.frequency) * up)
    axis = -sense * np.cross(field, later)
    return np.concatenate([places, _quaternions(axis, field)], axis=1)


def sense_of(problem: Problem, state: Floats) -> float:
    """Which way along the field's axis the nose of a state (7,) points: 1 as when a run starts, -1 the other way."""
    guess = attitudes(problem, 0, state[None, :3])
    return 1.0 if float(np.dot(long_axes(guess[0, 3:]), long_axes(state[3:]))) >= 0.0 else -1.0


def settle(problem: Problem, which: Ints, states: Floats) -> tuple[Floats, np.ndarray]:
    """States with their places kept and the attitude that repeats itself there; and where that was found."""
    begun, _ = problem.map(which, states, periods=SETTLING, held=True)
    solved = solve(problem, which, begun, held=True)
    return solved.states, solved.converged & (solved.measures["cosine"] > 0.0)


def _quaternions(long_axis: Floats, side: Floats) -> Floats:
    """Quaternions (n, 4) of the frames with x along ``long_axis`` and y as near ``side`` as may be."""
    from scipy.spatial.transform import Rotation

    x = long_axis / np.linalg.norm(long_axis, axis=1, keepdims=True)
    y = side - np.sum(side * x, axis=1, keepdims=True) * x
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    matrices = np.stack([x, y, np.cross(x, y)], axis=2)
    return np.asarray(Rotation.from_matrix(matrices).as_quat(scalar_first=True))
