"""What the tables near floor and surface neglect: they are averaged over the roll angle, and a helix is not round.

Solves the preset device beside each plane at several rolls, and prints how far single rolls lie from their mean; then
goes part of row 1 of Table I below the surface with the drag of each roll and with its mean: where the device is once a
turn, and how far it goes to and fro within one. SciPy integrates; nothing of the engine is used. Takes about five
minutes on one core.
"""

import math
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

import helimag as hm
from helimag.geometry import magnet_start
from helimag.hydrodynamics import net_weight
from helimag.hydrodynamics.boundary.device import device_surfaces
from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.hydrodynamics.boundary.single_layer import galerkin_matrix
from helimag.hydrodynamics.boundary.solve import Plane, resistance_of
from helimag.scenario import Scenario

ROLLS = np.arange(6) * math.pi / 3.0  # five harmonics are told apart by six
GAPS = 1e-3 * np.array([0.2, 0.5, 1.0, 2.0, 4.0])
TILTS = np.radians([-24.0, -8.0, 8.0, 24.0])
SHOWN = {"floor": (0.1, 0.235, 0.47, 1.0, 2.0), "surface": (0.1, 0.235, 0.47, 1.0, 2.0)}  # gaps, mm


def turn_about_x(angle: float) -> np.ndarray:
    """A turn of both vectors of a motion or load about the x axis (6, 6)."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.kron(np.eye(2), np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]))


def reach(mesh: Mesh, tilt: float) -> float:
    """How much nearer to a plane than the origin the body comes as it rolls (m)."""
    corners = mesh.corners.reshape(-1, 3)
    return float(np.max(-corners[:, 0] * math.sin(tilt) + np.hypot(corners[:, 1], corners[:, 2]) * math.cos(tilt)))


def by_roll(mesh: Mesh, alone: np.ndarray, kind: str, gap: float, tilt: float) -> np.ndarray:
    """Resistance per viscosity beside a plane in the level frame, at each roll (6, 6, 6)."""
    matrices = []
    for roll in ROLLS:
        normal = math.sin(tilt), math.cos(tilt) * math.sin(roll), math.cos(tilt) * math.cos(roll)
        turn = turn_about_x(roll)
        plane = Plane(kind, normal, gap + reach(mesh, tilt))
        matrices.append(turn @ resistance_of(mesh, alone.copy(), plane) @ turn.T)
    return np.array(matrices)


def off(matrices: np.ndarray, mean: np.ndarray, size: np.ndarray) -> float:
    """Largest difference of an entry from a mean, over the sizes of its row and column."""
    return float(np.abs((matrices - mean) / np.outer(size, size)).max())


def drag_rows(mesh: Mesh, alone: np.ndarray, free: np.ndarray) -> None:
    """The first table: what the wall adds at single rolls beside its mean, and what that does to the mean mobility.

    All over the geometric mean of two diagonal entries beside the wall. The device's own unevenness in open water is in
    every run, and left out here.
    """
    print("| plane | gap (mm) | added by the wall | at one roll, off the mean | mean mobility, off that of the mean |")
    print("|---|---|---|---|---|")
    here = np.array([turn_about_x(roll) @ free @ turn_about_x(roll).T for roll in ROLLS])
    even = here.mean(axis=0)
    for kind, gaps in SHOWN.items():
        for gap in gaps:
            added = by_roll(mesh, alone, kind, 1e-3 * gap, 0.0) - here
            mean = added.mean(axis=0)
            size = np.sqrt(np.diag(even + mean))
            answers = np.linalg.inv(even + added).mean(axis=0)
            numbers = off(mean, np.zeros((6, 6)), size), off(added, mean, size)
            numbers += (off(answers, np.linalg.inv(even + mean), 1.0 / size),)
            print(f"| {kind} | {gap:g} | " + " | ".join(f"{100.0 * number:.2f} %" for number in numbers) + " |")


def harmonics(mesh: Mesh, alone: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Fourier coefficients over the roll of what the surface adds: (gaps, tilts, harmonic 0 to 2, 6, 6), complex."""
    here = np.array([turn_about_x(roll) @ free @ turn_about_x(roll).T for roll in ROLLS])
    table = np.empty((GAPS.size, TILTS.size, 3, 6, 6), dtype=complex)
    for i, j in np.ndindex(table.shape[:2]):
        added = by_roll(mesh, alone, "surface", GAPS[i], TILTS[j]) - here
        spectrum = np.fft.fft(added, axis=0) / ROLLS.size
        table[i, j] = spectrum[:3] * np.array([1.0, 2.0, 2.0])[:, None, None]
    return table


def place(value: float, nodes: np.ndarray) -> tuple[int, float]:
    """Node before a value and how far it is on the way to the next, inside the nodes."""
    at = int(np.clip(np.searchsorted(nodes, value) - 1, 0, nodes.size - 2))
    return at, float(np.clip((value - nodes[at]) / (nodes[at + 1] - nodes[at]), 0.0, 1.0))


def rates(
    scenario: Scenario, mesh: Mesh, free: np.ndarray, table: np.ndarray, most: int, t: float, y: np.ndarray
) -> np.ndarray:
    """Rates of position and quaternion below the surface, with the harmonics of the roll up to ``most``."""
    viscosity = scenario.fluid.viscosity
    w, a, b, c = y[3:]
    rotation = np.array(
        [
            [1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)],
            [2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)],
            [2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)],
        ]
    )
    load = load_at(scenario, rotation, t, y[:3])
    up = -rotation[2]  # the plane's normal points down into the fluid
    tilt, roll = math.asin(up[0]), math.atan2(up[1], up[2])
    gap = scenario.workspace.surface - y[2] - reach_near(mesh, tilt)
    (i, u), (j, v) = place(math.log(max(gap, GAPS[0])), np.log(GAPS)), place(tilt, TILTS)
    near = (1 - u) * ((1 - v) * table[i, j] + v * table[i, j + 1]) + u * (
        (1 - v) * table[i + 1, j] + v * table[i + 1, j + 1]
    )
    added = sum((near[h] * np.exp(1j * h * roll)).real for h in range(most + 1))
    turn = turn_about_x(roll)
    motion = np.linalg.solve(viscosity * (free + turn.T @ added @ turn), load)
    p, q, s = motion[3:]
    turning = [-a * p - b * q - c * s, w * p + b * s - c * q, w * q + c * p - a * s, w * s + a * q - b * p]
    return np.concatenate([rotation @ motion[:3], 0.5 * np.array(turning)])


REACHES: dict[int, tuple[np.ndarray, np.ndarray]] = {}


def reach_near(mesh: Mesh, tilt: float) -> float:
    """As `reach`, between tilts worked out once."""
    if id(mesh) not in REACHES:
        tilts = np.linspace(-math.pi / 2, math.pi / 2, 721)
        REACHES[id(mesh)] = tilts, np.array([reach(mesh, tilt) for tilt in tilts])
    return float(np.interp(tilt, *REACHES[id(mesh)]))


def load_at(scenario: Scenario, rotation: np.ndarray, t: float, position: np.ndarray) -> np.ndarray:
    """Force and torque on the device, body frame: a dipole's field and pull (eqs 4 and 9), and weight (eq. 8)."""
    drive, device = scenario.drive, scenario.device
    weight, weight_moment = net_weight(device, scenario.fluid)
    spin, pitch = 2.0 * math.pi * drive.frequency * t, drive.pitch
    along = np.array([-math.sin(pitch) * math.sin(spin), math.cos(spin), math.cos(pitch) * math.sin(spin)])
    magnet = scenario.magnet[0].dipole_moment * along
    r = position - np.asarray(magnet_start(drive)) - t * np.array(drive.velocity)
    distance = float(np.linalg.norm(r))
    axis, m = r / distance, device.magnetic_moment * rotation[:, 1]
    field = 1e-7 / distance**3 * (3.0 * (axis @ magnet) * axis - magnet)
    force = (axis @ m) * magnet + (axis @ magnet) * m + (m @ magnet - 5.0 * (axis @ m) * (axis @ magnet)) * axis
    force = 3e-7 / distance**4 * force - np.array([0.0, 0.0, weight])
    up = rotation[2]
    torque = rotation.T @ np.cross(m, field) + weight_moment * np.array([0.0, up[2], -up[1]])
    return np.concatenate([rotation.T @ force, torque])


def way(scenario: Scenario, mesh: Mesh, free: np.ndarray, table: np.ndarray, most: int, duration: float) -> np.ndarray:
    """Heights (m) below the surface at twelve times of each turn."""
    begin = np.array([*scenario.drive.start, 1.0, 0.0, 0.0, 0.0])
    turns = int(duration * scenario.drive.frequency)
    times = np.arange(12 * turns + 1) / (12.0 * scenario.drive.frequency)
    solved = solve_ivp(
        partial(rates, scenario, mesh, free, table, most),
        (0.0, times[-1]),
        begin,
        method="DOP853",
        t_eval=times,
        rtol=1e-7,
        atol=1e-10,
    )
    return np.asarray(solved.y[2])


def main() -> None:
    """Print the table and the two ways."""
    scenario = hm.load("nose-first/table1-row1").replaced({"device.hydrodynamics.model": "boundary", "provenance": {}})
    mesh = next(device_surfaces(scenario.device))
    alone = galerkin_matrix(mesh)
    free = resistance_of(mesh, alone.copy(), None)
    drag_rows(mesh, alone, free)
    table = harmonics(mesh, alone, free)
    heights = {most: way(scenario, mesh, free, table, most, 12.0) for most in (0, 2)}
    for most, name in ((0, "mean over the roll"), (2, "each roll")):
        z = 1e3 * heights[most]
        fro = np.ptp(z[: 12 * (len(z) // 12)].reshape(-1, 12) - z[:-1:12, None], axis=1)
        marks = ", ".join(f"{z[12 * round(s * 3.5)]:+.4f} mm at {s} s" for s in (2, 4, 8, 12))
        print(f"{name}: {marks}; to and fro in a turn {fro.mean():.4f} mm")
    apart = 1e3 * np.abs(heights[2] - heights[0])
    print(f"apart by {apart.max():.4f} mm at most, of {1e3 * np.ptp(heights[2]):.3f} mm of way")


if __name__ == "__main__":
    main()
