"""How sure is a verdict? Copies of a run whose pitch, oil and start are a little off; shares with their intervals."""

import numpy as np

import helimag as hm
from helimag.scenario import Normal, Uniform

base = hm.load("paper/fig3c").replaced({"drive.pitch": "14.2 deg"})
errors = hm.Perturbation(
    {
        "drive.pitch": Uniform(*np.radians([14.0, 14.4])),
        "fluid.viscosity": Normal(1.65, 0.02, low=1.5, high=1.8),  # Pa s
    },
    displacement=50e-6,  # m, of where the device is released
)
found = hm.ensemble(base, errors, runs=24, seed=1)

print(f"as the scenario says: {found.judgement.verdict}, gain {found.judgement.gain:.3f}")
print(found.text)
for row in found.rows[:3]:
    pitch, viscosity = np.degrees(row["drive.pitch"]), row["fluid.viscosity"]
    print(f"  pitch {pitch:6.3f} deg, viscosity {viscosity:.3f} Pa s: {row['verdict']}, gain {row['gain']:.3f}")

# the copies lie where they were drawn
assert all(14.0 <= np.degrees(row["drive.pitch"]) <= 14.4 for row in found.rows)
# every copy has a verdict, and the interval holds the share that was seen
assert sum(found.verdicts.values()) == 24
assert all(low <= share <= high for share, low, high in found.shares.values())
# so near the highest stable pitch small errors decide: the copies do not all end alike
assert len(found.verdicts) > 1, found.verdicts
# the same seed draws the same copies
assert (
    hm.ensemble(base.replaced({"run.duration": "10 s"}), errors, runs=24, seed=1).rows[5]["drive.pitch"]
    == (found.rows[5]["drive.pitch"])
)
