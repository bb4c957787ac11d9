"""Speed of one run beside two peers, at equal achieved error, and of a batch on all cores.

The peers integrate the same equations: heyoka by adaptive Taylor series compiled from expressions, SciPy's DOP853 with
a plain Python right-hand side. Each is run at the loosest tolerance that reaches at least helimag's error after 100 s;
the error is measured against heyoka at 1e-16. Times are process time of one core for Fig. 3(C).
"""

import math
import os
import time

import heyoka as hy
import numpy as np
from scipy.integrate import solve_ivp

from helimag.engine import advance, start_state
from helimag.geometry import magnet_start
from helimag.hydrodynamics import mobility, net_weight, resistance
from helimag.scenario import Scenario, load

HORIZON = 100.0


def rates_of(scenario: Scenario, inverse: list, t, y, sin, cos, sqrt) -> list:
    """Rates of (x, y, z, w, qx, qy, qz), written out for numbers and for symbols alike; ``inverse`` is the mobility."""
    drive, device = scenario.drive, scenario.device
    weight, weight_moment = net_weight(device, scenario.fluid)
    sin_p, cos_p = math.sin(drive.pitch), math.cos(drive.pitch)
    cos_y, sin_y = cos(drive.yaw_rate * t), sin(drive.yaw_rate * t)
    spin = 2.0 * math.pi * drive.frequency
    along, across = cos(spin * t), sin(spin * t)
    arm = [float(a) for a in magnet_start(scenario.drive)]
    magnet = [cos_y * arm[0] - sin_y * arm[1], sin_y * arm[0] + cos_y * arm[1], arm[2]]
    axis = [-cos_y * sin_p * across - sin_y * along, -sin_y * sin_p * across + cos_y * along, cos_p * across]
    r = [y[i] - magnet[i] for i in range(3)]
    w, a, b, c = y[3:]
    columns = [
        [1 - 2 * (b * b + c * c), 2 * (a * b + w * c), 2 * (a * c - w * b)],
        [2 * (a * b - w * c), 1 - 2 * (a * a + c * c), 2 * (b * c + w * a)],
        [2 * (a * c + w * b), 2 * (b * c - w * a), 1 - 2 * (a * a + b * b)],
    ]
    m = columns[1]
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    distance = sqrt(square)
    scale = 1e-7 * scenario.magnet[0].moment
    r_axis = (r[0] * axis[0] + r[1] * axis[1] + r[2] * axis[2]) / distance
    r_m = (r[0] * m[0] + r[1] * m[1] + r[2] * m[2]) / distance
    m_axis = m[0] * axis[0] + m[1] * axis[1] + m[2] * axis[2]
    field = [scale / (square * distance) * (3 * r_axis * r[i] / distance - axis[i]) for i in range(3)]
    pull = 3 * scale * device.magnetic_moment / (square * square)
    force = [
        pull * (r_m * axis[i] + r_axis * m[i] + (m_axis - 5 * r_m * r_axis) * r[i] / distance)
        - (weight if i == 2 else 0)
        for i in range(3)
    ]
    body_force = [sum(column[i] * force[i] for i in range(3)) for column in columns]
    field_x = sum(columns[0][i] * field[i] for i in range(3))
    field_z = sum(columns[2][i] * field[i] for i in range(3))
    torque = [
        device.magnetic_moment * field_z,
        weight_moment * columns[2][2],
        -device.magnetic_moment * field_x - weight_moment * columns[1][2],
    ]
    load_6 = body_force + torque
    motion = [sum(inverse[i][j] * load_6[j] for j in range(6)) for i in range(6)]
    velocity = [sum(columns[j][i] * motion[j] for j in range(3)) for i in range(3)]
    p, q, s = motion[3:]
    turn = [-a * p - b * q - c * s, w * p + b * s - c * q, w * q + c * p - a * s, w * s + a * q - b * p]
    return velocity + [0.5 * rate for rate in turn]


def mobility_of(scenario: Scenario) -> list:
    """Mobility as plain numbers."""
    return mobility(resistance(scenario.device, scenario.fluid)).tolist()


def taylor(scenario: Scenario, tolerance: float) -> tuple[np.ndarray, float]:
    """Position after ``HORIZON`` and process time, by heyoka."""
    names = hy.make_vars("x", "y", "z", "w", "a", "b", "c")
    rates = rates_of(scenario, mobility_of(scenario), hy.time, list(names), hy.sin, hy.cos, hy.sqrt)
    integrator = hy.taylor_adaptive(list(zip(names, rates, strict=True)), start_state(scenario), tol=tolerance)
    begun = time.process_time()
    integrator.propagate_until(HORIZON)
    return np.array(integrator.state[:3]), time.process_time() - begun


def scipy_dop853(scenario: Scenario, tolerance: float) -> tuple[np.ndarray, float]:
    """Position after ``HORIZON`` and process time, by SciPy."""
    inverse = mobility_of(scenario)
    begun = time.process_time()
    solution = solve_ivp(
        lambda t, y: rates_of(scenario, inverse, t, y, math.sin, math.cos, math.sqrt),
        (0.0, HORIZON),
        start_state(scenario),
        method="DOP853",
        rtol=tolerance,
        atol=1e-3 * tolerance,
    )
    return solution.y[:3, -1], time.process_time() - begun


def ours(scenario: Scenario, runs: int = 1, threads: int = 1) -> tuple[np.ndarray, float, float]:
    """Position after the run, process time and wall time, all runs together."""
    wall, begun = time.perf_counter(), time.process_time()
    histories = advance([scenario] * runs, threads=threads)
    return histories[0].states[-1, :3], time.process_time() - begun, time.perf_counter() - wall


def main() -> None:
    """Print the table."""
    full = load("nose-first/fig3c")
    short = full.replaced({"run.duration": HORIZON})
    ours(short.replaced({"run.duration": 1.0}))
    exact, _ = taylor(short, 1e-16)
    position, seconds, _ = min((ours(short) for _ in range(5)), key=lambda result: result[1])
    error = float(np.linalg.norm(position - exact))
    print(f"helimag        error {error:.1e} m after {HORIZON:.0f} s, {1e6 * seconds / HORIZON:8.1f} us per second")
    for name, solve, tolerances in (
        ("heyoka Taylor", taylor, (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)),
        ("SciPy DOP853", scipy_dop853, (1e-7, 1e-8, 1e-9)),
    ):
        for tolerance in tolerances:
            position, taken = solve(short, tolerance)
            reached = float(np.linalg.norm(position - exact))
            if reached <= error:
                break
        print(
            f"{name:14s} error {reached:.1e} m after {HORIZON:.0f} s, {1e6 * taken / HORIZON:8.1f} us per second: "
            f"helimag is {taken / seconds:.1f} times as fast"
        )
    _, seconds, _ = min((ours(full) for _ in range(3)), key=lambda result: result[1])
    print(f"1800 s run, default accuracy, one core: {seconds:.3f} s")
    cores = os.cpu_count() or 1
    _, seconds, wall = ours(full, runs=64, threads=cores)
    print(
        f"64 such runs on {cores} cores: {wall:.1f} s wall, {seconds:.1f} s of cores, {seconds / wall:.2f} cores in use"
    )


if __name__ == "__main__":
    main()
