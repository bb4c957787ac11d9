"""Orbits against brute force: random scenarios, each orbit's verdict and leading rate against full runs of 20,000 s.

    python benchmarks/orbit_brute_force.py [COUNT]

A run that starts beside a stable orbit must end nearer to it, one that starts beside an unstable orbit must leave it,
and two runs on either side must part at the Floquet rate. Prints every case, and exits with status 1 if any disagrees.
"""

import sys
import time

import numpy as np

import helimag as hm
from helimag.orbits import _chart as chart
from helimag.orbits.growth import leading_direction, observed_growth, strobed

HORIZON = 20_000.0  # s
BESIDE = 1e-3  # displacement of the run, in shares of the distance and radians
LEFT = 5.0  # times the displacement
BAND = 0.02  # of the rate


def random_scenario(rng: np.random.Generator) -> hm.Scenario:
    return hm.load("paper/fig3c").replaced(
        {
            "drive.frequency": rng.uniform(1.5, 4.0),
            "drive.pitch": np.radians(rng.uniform(4.0, 18.0)),
            "drive.distance": rng.uniform(0.120, 0.170),
            "drive.yaw_rate": np.radians(rng.uniform(0.6, 3.0)),
            "device.weight.net_weight": rng.uniform(22e-6, 34e-6),
            "fluid.viscosity": rng.uniform(0.8, 1.2),
        }
    )


def judged(orbit: hm.Orbit) -> tuple[str, float, float]:
    """What the long run did, and the observed rate with its relative error."""
    observed = observed_growth(orbit)
    error = abs(observed.rate.real - orbit.growth) / abs(orbit.rates[0])
    relative = abs(observed.rate.real - orbit.growth) / abs(orbit.growth)
    direction, _ = leading_direction(orbit)
    length = np.array([orbit.scenario.drive.distance])
    start = chart.moved(orbit.state[None], BESIDE * direction[None], length)
    ((times, states, history),) = strobed(orbit, start, HORIZON)
    away = np.linalg.norm(
        chart.coordinates(states, np.repeat(orbit.state[None], len(states), axis=0), length.repeat(len(states))), axis=1
    )
    if history.status.name != "HORIZON":
        return f"left: {history.status.name.lower()} at {history.time[-1]:.0f} s", relative, error
    if away.max() > LEFT * BESIDE:
        return f"left: {away.max() / BESIDE:.0f} times as far", relative, error
    return f"stayed: {away[-20:].max() / BESIDE:.1e} of the displacement after {times[-1]:.0f} s", relative, error


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    rng = np.random.default_rng(2024)
    done, none, wrong, worst = 0, 0, 0, 0.0
    tally = {True: 0, False: 0}
    begun = time.perf_counter()
    while done < count:
        scenario = random_scenario(rng)
        orbit = hm.find_orbit(scenario)
        if not orbit.found or tally[orbit.stable] >= (count + 1) // 2:
            none += 1  # without an orbit, or half the cases are of this kind already
            continue
        done += 1
        tally[orbit.stable] += 1
        outcome, relative, error = judged(orbit)
        agrees = outcome.startswith("stayed") == orbit.stable and relative < BAND
        wrong += not agrees
        worst = max(worst, relative)
        drive = scenario.drive
        print(
            f"{done:3d} {drive.frequency:.2f} Hz {np.degrees(drive.pitch):5.2f} deg {1e3 * drive.distance:.0f} mm "
            f"{'stable  ' if orbit.stable else 'unstable'} {orbit.growth:+.6f} {orbit.rates[0].imag:+.5f}i /s, seen "
            f"within {100 * relative:.3f} %; {outcome}{'' if agrees else '   DISAGREES'}",
            flush=True,
        )
    print(
        f"{count} orbits ({tally[True]} stable, {tally[False]} unstable; {none} passed over): {wrong} disagree; "
        f"worst rate error {100 * worst:.2f} %; {time.perf_counter() - begun:.0f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
