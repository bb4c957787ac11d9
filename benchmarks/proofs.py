"""How many orbits of random scenarios are proved: of 40 stable ones, and of 20 unstable ones none may be.

Run: python benchmarks/proofs.py [STABLE UNSTABLE | named]. ``named``: how wide the tubes of four orbits are, and the
box of inputs that is proved around the first.

Scenarios are drawn around the device of the paper's simulations, with a fixed seed: all inputs of the drive, weight,
centre of gravity, handedness, viscosity and both readings of pitch. Prints a line an orbit and the counts.
"""

import math
import sys
import time

import numpy as np

import helimag as hm
from helimag.proof import named_inputs, prove, tolerated

STABLE, UNSTABLE, SEED = 40, 20, 18
PRESET = "nose-first/fig3c"
NAMED = ((2.5, 12.7), (2.0, 14.0), (2.5, 8.0), (3.0, 10.0))  # frequency (Hz) and pitch (deg), as in the tests


def drawn(rng):
    """A random scenario."""
    changes = {
        "device.helix.handedness": "left",
        "device.helix.wire_radius": rng.uniform(0.19, 0.23) * 1e-3,
        "device.head.radius": rng.uniform(0.3, 0.6) * 1e-3,
        "device.weight.net_weight": rng.uniform(15.0, 50.0) * 1e-6,
        "device.weight.gravity_center": rng.uniform(-4.0, -1.0) * 1e-3,
        "fluid.viscosity": rng.uniform(0.8, 1.7),
        "drive.frequency": rng.uniform(1.5, 4.0),
        "drive.pitch": math.radians(rng.uniform(4.0, 18.0)),
        "drive.distance": rng.uniform(0.13, 0.17),
        "drive.yaw_rate": math.radians(rng.uniform(0.8, 3.0)),
        "drive.pitch_about": rng.choice(["origin", "magnet"]),
    }
    # six digits, as somebody would write them
    rounded = {key: float(f"{value:.6g}") if isinstance(value, float) else str(value) for key, value in changes.items()}
    return hm.load(PRESET).replaced(rounded)


def named():
    """Print size of tube and ball of starts of the named orbits, time, and the box of inputs around the first."""
    certificates = []
    for frequency, pitch in NAMED:
        changes = {"drive.frequency": f"{frequency} Hz", "drive.pitch": f"{pitch} deg"}
        found, begun = hm.find_orbit(hm.load(PRESET).replaced(changes)), time.process_time()
        certificate, seconds = prove(found).certificate, time.process_time() - begun
        claims = certificate.claims
        certificates.append(certificate)
        print(
            f"{frequency} Hz, {pitch} deg: tube {1e6 * max(claims.tube):.1f} um to each side, "
            f"starts {1e6 * claims.basin:.1f} um, {math.degrees(claims.basin_turned):.4f} deg; {seconds:.0f} s of CPU",
            flush=True,
        )
    wide = tolerated(certificates[0])
    print("inputs within", named_inputs(wide), f"(box {1e6 * max(wide.claims.box):.0f} um)")


def main(stable_wanted=STABLE, unstable_wanted=UNSTABLE):
    rng = np.random.default_rng(SEED)
    tried = {True: 0, False: 0}
    proved = {True: 0, False: 0}
    existing = 0
    seconds = []
    while tried[True] < stable_wanted or tried[False] < unstable_wanted:
        found = hm.find_orbit(drawn(rng))
        stable = found.stable
        if found.found and tried[stable] < (stable_wanted if stable else unstable_wanted):
            begun = time.process_time()
            proof = prove(found)
            seconds.append(time.process_time() - begun)
            tried[stable] += 1
            proved[stable] += proof.proved
            existing += proof.existence and not stable
            word = "stable" if stable else "unstable"
            if not proof.existence or proof.proved != stable:
                print(f"  {found.scenario.title}")
            print(f"{word:8} {seconds[-1]:5.1f} s of CPU, growth {found.growth:9.2e}/s: {proof.reason}", flush=True)
    print(f"stable:   {proved[True]} of {tried[True]} proved")
    print(f"unstable: {proved[False]} of {tried[False]} proved stable; that they exist was proved of {existing}")
    print(f"time:     median {np.median(seconds):.1f} s, longest {max(seconds):.1f} s of CPU")
    return proved[False] == 0 and proved[True] >= 0.9 * tried[True]


if __name__ == "__main__":
    if sys.argv[1:] == ["named"]:
        sys.exit(named())
    sys.exit(0 if main(*map(int, sys.argv[1:])) else 1)
