"""Around an orbit: the slow flow with its fixed points, and from where a device comes to the orbit."""

import helimag as hm
from helimag import plots
from helimag.orbits import agreement, averaged_rates, basin, basin_dataset, fixed_points, save_dataset, slow_flow

orbit = hm.find_orbit(hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz"}))
low, high = orbit.position - 0.045, orbit.position + 0.045  # m, moving frame

flow = slow_flow(orbit, low=low, high=high, shape=(9, 9, 9))
points = fixed_points(flow)
for point in points:
    print(f"{point.kind} at {1e3 * point.position} mm, exact to {1e3 * point.error:.2g} mm")

caught = basin(orbit, low=low, high=high, shape=(6, 6, 6), flow=flow)
compared = agreement(caught, starts=20)
print(caught.text)
print(compared.text)
plots.save(plots.draw_flow(flow, orbit, caught, fixed_points=points), "flow.png")
plots.save(plots.draw_basin(caught), "basin.png")
save_dataset(basin_dataset(caught, compared), "basin.nc")

# the sink is the orbit, with its slowest rates; above it a saddle, where the basin ends
sink, saddle = points
assert sink.stable
assert abs(sink.position - orbit.position).max() < 1e-6
assert abs(averaged_rates(flow, orbit)[0].imag) / abs(orbit.rates[0].imag) - 1.0 < 0.01
assert not saddle.stable
assert saddle.position[2] > orbit.position[2]
assert not hm.find_orbit(orbit.scenario, near=flow.state_at(saddle.position)).stable
# full runs bear the averaged model out, at the least where it says that the device comes to the orbit
assert compared.counts["both"] > 0
assert compared.counts["only_averaged"] <= 1
assert compared.share > 0.6
