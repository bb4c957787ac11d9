"""For all future time: find the orbit behind a run, and between which pitches it stays stable."""

import math

import helimag as hm
from helimag.orbits import stable_interval

scenario = hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz"})
orbit = hm.find_orbit(scenario)
print(orbit.text)

interval = stable_interval(orbit, "drive.pitch", math.radians(8.0), math.radians(20.0))
print(interval.text)

# a little beyond the end there is no stable orbit any more, a little before it there is
before, beyond = (scenario.replaced({"drive.pitch": interval.high + math.radians(by)}) for by in (-0.05, 0.05))
assert orbit.stable
assert interval.why_high == "fold"
assert hm.find_orbit(before, near=orbit).stable
assert not hm.find_orbit(beyond, near=orbit).stable
assert all(rate.real < 0.0 for rate in orbit.rates)
