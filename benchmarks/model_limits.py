"""The numbers of the model's page on what the model's parts are worth.

Pull and roll relaxation straight below the magnet; the point dipole beside magpylib's exact cylinder; resistive-force
coefficients beside the measurements of B. Rodenborn et al., PNAS 110 (2013) E338, Fig. 2 (digitised, a few per cent).
"""

import math

import magpylib
import numpy as np

import helimag as hm
from helimag.hydrodynamics.resistive_force import gray_hancock, helix_resistance, lighthill
from helimag.physics import evaluate, magnetics
from helimag.scenario import Helix

# the helix measured (m), and its thrust / (mu w R^2), torque / (mu w R^3) and drag / (mu u R) by pitch over radius
RADIUS, LENGTH, FILAMENT = 6.3e-3, 130e-3, 0.397e-3
MEASURED = {6.509: (11.034, 81.93, 39.41), 15.241: (7.845, 68.07, 34.12)}


def pull_and_roll(scenario: hm.Scenario, distance: float) -> str:
    """Mean pull on a device in phase, and how fast its roll relaxes, over a turn of the magnet above."""
    spin = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
    moment = scenario.magnet[0].moment * np.stack([0.0 * spin, np.cos(spin), np.sin(spin)], axis=1)
    below = np.array([0.0, 0.0, -distance])
    field = evaluate(magnetics.dipole_field, below, moment)
    strength = np.linalg.norm(field, axis=1)
    m = scenario.device.magnetic_moment
    force = evaluate(magnetics.dipole_force, below, moment, m * field / strength[:, None])
    roll = m * strength / hm.resistance(scenario.device, scenario.fluid)[3, 3]
    return f"mean pull {1e6 * force[:, 2].mean():.1f} uN, roll relaxes at {roll.min():.0f} to {roll.max():.0f} per s"


def dipole_error(scenario: hm.Scenario, distance: float) -> str:
    """Error of field and of its axial gradient on the magnet's axis."""
    magnet = scenario.magnet[0]
    volume = math.pi * magnet.radius**2 * magnet.height
    exact = magpylib.magnet.Cylinder(
        polarization=(0.0, 0.0, 4e-7 * math.pi * magnet.moment / volume), dimension=(2.0 * magnet.radius, magnet.height)
    )
    places = distance + np.array([-1e-4, 0.0, 1e-4])
    there = exact.getB(np.stack([0.0 * places, 0.0 * places, places], axis=1))[:, 2]
    dipole = 2e-7 * magnet.moment / places**3
    field = dipole[1] / there[1] - 1.0
    gradient = (dipole[2] - dipole[0]) / (there[2] - there[0]) - 1.0
    return f"dipole off by {100.0 * field:+.1f} % in field, {100.0 * gradient:+.1f} % in gradient"


def drag_errors(pitch: float) -> dict[str, list[float]]:
    """Relative errors of thrust, torque and drag, by coefficients."""
    helix = Helix(length=LENGTH, outer_diameter=2.0 * (RADIUS + FILAMENT), pitch=pitch * RADIUS, wire_radius=FILAMENT)
    errors = {}
    for coefficients in (lighthill, gray_hancock):
        matrix = helix_resistance(helix, 0.0, *coefficients(helix, 1.0))
        computed = abs(matrix[0, 3]) / RADIUS**2, matrix[3, 3] / RADIUS**3, matrix[0, 0] / RADIUS
        errors[coefficients.__name__] = [c / m - 1.0 for c, m in zip(computed, MEASURED[pitch], strict=True)]
    return errors


def main() -> None:
    """Print all of them."""
    scenario = hm.load("nose-first/fig3c")
    for distance in (0.06, 0.102, 0.15):
        print(f"{1e3 * distance:.0f} mm below: {pull_and_roll(scenario, distance)}; {dipole_error(scenario, distance)}")
    for pitch in MEASURED:
        for name, (thrust, torque, drag) in drag_errors(pitch).items():
            print(f"pitch {pitch:.1f} R, {name}: thrust {thrust:+.0%}, torque {torque:+.0%}, drag {drag:+.0%}")


if __name__ == "__main__":
    main()
