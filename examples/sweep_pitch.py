"""Which pitch keeps the device bounded? A plan from a file, a store that can be resumed, and a figure of the result."""

from pathlib import Path

import numpy as np

import helimag as hm

plan = Path(__file__).with_name("sweep_plan.toml")
data = hm.sweep(plan, out="pitch.zarr")
print("Hz     bounded pitch     least gain")
highest, least = [], []
for frequency in data["frequency"].values:
    row = data.sel(frequency=frequency)
    inside = row["verdict"] == hm.Verdict.BOUNDED
    pitch = np.degrees(row["pitch"].values[inside.values])
    highest.append(pitch.max())
    least.append(float(row["gain"].where(inside).min()))
    print(f"{frequency:.1f}   {pitch.min():4.0f} to {pitch.max():2.0f} deg     {least[-1]:.3f}")

# as the paper reads from its Fig. 4: less pitch is left, and the gain is higher, the faster the magnet turns
assert highest == sorted(highest, reverse=True), highest
assert highest[0] > highest[-1], highest
assert least == sorted(least), least
# the same plan again finds all in its store
assert hm.sweep(plan, out="pitch.zarr").identical(data)
