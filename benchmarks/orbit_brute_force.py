"""Orbits against brute force: random scenarios, each orbit's verdict and leading rate against full runs of 20,000 s.

    python benchmarks/orbit_brute_force.py [COUNT]

A run that starts beside a stable orbit must stay by it, one that starts beside an unstable orbit must leave it (where
its rate is too slow for that within the time: come to be as far from it as the rate says, within a tenth), and two runs
on either side must part at the Floquet rate. Prints every case, and exits with status 1 if any disagrees.
"""

import sys
import time

import numpy as np

import helimag as hm
from helimag.orbits.beside_runs.growth import leading_direction, observed_growth
from helimag.orbits.strobe import chart, strobed

HORIZON = 20_000.0  # s
BESIDE = 1e-3  # displacement of the run, in shares of the distance and radians
LEFT = 5.0  # times the displacement
BAND = 0.02  # of the rate


def random_scenario(rng: np.random.Generator) -> hm.Scenario:
    return hm.load("nose-first/fig3c").replaced(
        {
            "drive.frequency": rng.uniform(1.5, 4.0),
            "drive.pitch": np.radians(rng.uniform(4.0, 18.0)),
            "drive.distance": rng.uniform(0.120, 0.170),
            "drive.yaw_rate": np.radians(rng.uniform(0.6, 3.0)),
            "device.weight.net_weight": rng.uniform(22e-6, 34e-6),
            "fluid.viscosity": rng.uniform(0.8, 1.2),
        }
    )


def judged(orbit: hm.Orbit) -> tuple[bool, str, float]:
    """Whether the long run did what the orbit says, what it did, and the relative error of the rate seen."""
    observed = observed_growth(orbit)
    relative = abs(observed.rate.real - orbit.growth) / abs(orbit.growth)
    direction, _ = leading_direction(orbit)
    length = np.array([orbit.scenario.drive.distance])
    start = chart.moved(orbit.state[None], BESIDE * direction[None], length)
    (run,) = strobed(orbit.scenario, HORIZON, samples=200, states=start)
    reference = np.repeat(orbit.state[None], len(run.states), axis=0)
    away = np.linalg.norm(chart.coordinates(run.states, reference, length.repeat(len(run.states))), axis=1) / BESIDE
    if run.status.name != "HORIZON":
        return not orbit.stable, f"left: {run.status.name.lower()} at {run.end:.0f} s", relative
    if away.max() > LEFT:
        return not orbit.stable, f"left: {away.max():.0f} times as far", relative
    told = np.exp(orbit.growth * run.times[-1])
    seen = away[-20:].max()
    agrees = seen < 1.0 if orbit.stable else told < 1.5 * LEFT and 0.9 * told < seen < 1.1 * told
    slowly = "" if orbit.stable else f"; its rate says {told:.2f}"
    return agrees, f"{seen:.2g} of the displacement after {run.times[-1]:.0f} s{slowly}", relative


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
        agrees, outcome, relative = judged(orbit)
        agrees &= relative < BAND
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
