"""Measure an orbit's leading rate from full runs: the brute-force check of its Floquet rate.

Two runs start on either side of the orbit, displaced along the leading direction. Half their difference, seen along the
matching left eigenvector at whole turns of the magnet, grows or decays by the leading rate; even orders cancel.
"""

import math
from dataclasses import dataclass

import numpy as np

from helimag.engine import DOP853
from helimag.errors import InputError
from helimag.orbits.strobe import Floats, Orbit, chart, strobed

DISPLACEMENT = 3e-4  # of the distance, and radians
TOLERANCE = 1e-10  # of a step: the runs' own error must stay far below the displacement
SAMPLES = 200


@dataclass(frozen=True)
class ObservedGrowth:
    """Leading rate as seen (1/s, complex; the imaginary part is unsigned), and over what time (s)."""

    rate: complex
    duration: float


def leading_direction(orbit: Orbit) -> tuple[Floats, np.ndarray]:
    """Real displacement (6,) of unit length along the leading multiplier, and its left eigenvector (6,), complex."""
    values, right = np.linalg.eig(orbit.jacobian)
    which = int(np.argmin(np.abs(values - orbit.multipliers[0])))
    direction = np.real(right[:, which])
    left = np.linalg.inv(right)[which]
    return direction / np.linalg.norm(direction), left


def observed_growth(
    orbit: Orbit, *, duration: float | None = None, displacement: float = DISPLACEMENT
) -> ObservedGrowth:
    """Run on either side of an orbit and fit how fast the runs part.

    Parameters
    ----------
    duration
        s; default: while the displacement changes by e, at least three swings, at most 4000 s.
    displacement
        Of the start, in shares of the distance and radians.

    Returns
    -------
    ObservedGrowth
        The leading rate as seen (1/s), and over what time (s).

    Raises
    ------
    InputError
        Where the orbit was not found.
    """
    if not orbit.found:
        raise InputError(f"growth can be observed around an orbit that was found; got '{orbit.status}'")
    lead = orbit.rates[0]
    if duration is None:
        swings = 3.0 * 2.0 * math.pi / abs(lead.imag) if abs(lead.imag) > 1e-9 else 0.0
        duration = min(4000.0, max(1.0 / abs(lead.real), swings))
    direction, left = leading_direction(orbit)
    length = np.full(2, orbit.scenario.drive.distance)
    starts = chart.moved(
        np.repeat(orbit.state[None], 2, axis=0), displacement * np.stack([direction, -direction]), length
    )
    runs = strobed(orbit.scenario, duration, samples=SAMPLES, states=starts, tolerance=TOLERANCE, method=DOP853)
    count = min(len(run.times) for run in runs)
    seen = [
        chart.coordinates(run.states[:count], np.repeat(orbit.state[None], count, axis=0), length[:1].repeat(count))
        for run in runs
    ]
    amplitude = (seen[0] - seen[1]) @ left / 2.0
    times = runs[0].times[:count]
    real = np.polyfit(times, np.log(np.abs(amplitude)), 1)[0]
    imag = np.polyfit(times, np.unwrap(np.angle(amplitude)), 1)[0] if abs(lead.imag) > 1e-9 else 0.0
    return ObservedGrowth(complex(real, abs(imag)), float(times[-1]))
