"""A device pressed to the surface slides on along it: what a run that stops there does not show."""

import numpy as np

import helimag as hm

stops = hm.load("paper/table1-row3")
holds = stops.replaced({"workspace.contact": "hold"})
stopped, held = hm.simulate(stops), hm.simulate(holds)
print(stopped.judgement.reason)
print(held.judgement.reason)

# the same run until a wall pushes; the one that stops leaps over turns on its way there
(surface,) = (touch for touch in held.touches if touch.wall == "surface")
before = int(np.count_nonzero(held.dataset.walls.values.cumsum() == 0))
common = min(before, stopped.dataset.time.size - 1)
apart = stopped.dataset.position.values[:common] - held.dataset.position.values[:common]
assert np.abs(apart).max() < 1e-6
assert stopped.dataset.time.values[-1] - surface.first < 0.1

# nothing of the device is above the surface, and it has gone on along x
length, radius = holds.device.tail_length, holds.device.tail_radius
head = held.dataset.position.values
tail = head - length * held.dataset.long_axis.values
highest = np.maximum(head[:, 2] + holds.device.head_radius, tail[:, 2] + radius).max()
print(f"highest point {1e6 * (highest - holds.workspace.surface):.1e} um above the surface")
assert -1e-6 < highest - holds.workspace.surface < 1e-9
assert head[-1, 0] > stopped.final_state[0] + 0.05
assert held.verdict == "wall-limited"

# a surface that holds each end with half the weight or more keeps it; one that does not may lose it again
kept = hm.simulate(holds.replaced({"workspace.surface_pull": "200 uN"}))
(longer,) = kept.touches
print(f"pushed for {surface.total:.0f} s without a pull, for {longer.total:.0f} s with one")
assert longer.total > surface.total
