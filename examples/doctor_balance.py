"""Explain a scenario before it is run: where pull carries the weight, a device neither rises nor sinks."""

import helimag as hm
from helimag.diagnosis import diagnose

preset = hm.load("paper/table1-row1").replaced({"drive.velocity": ["0 mm/s", "0 mm/s", "0 mm/s"], "workspace": {}})
found = diagnose(preset)
assert found.balance_distance is not None
print(f"pull carries {1e6 * found.net_weight:.1f} uN at {1e3 * found.balance_distance:.1f} mm below the magnet")


def vertical_speed(distance: float) -> float:
    """Mean over the second turn, from level, straight below a magnet with a level axis (m/s)."""
    still = preset.replaced({"drive.distance": distance, "drive.pitch": 0.0, "device.weight.gravity_center": 0.0})
    turn = 1.0 / still.drive.frequency
    heights = hm.simulate(still, duration=2.0 * turn, interval=turn).dataset.position.values[:, 2]
    return float(heights[2] - heights[1]) / turn


level = diagnose(preset.replaced({"drive.pitch": 0.0})).balance_distance
assert level is not None
above, at, below = (vertical_speed(factor * level) for factor in (0.95, 1.0, 1.05))
print(f"5 % nearer it moves by {1e3 * above:+.3f} mm/s, there {1e3 * at:+.3f}, 5 % farther {1e3 * below:+.3f}")
assert above > 0.0 > below, (above, below)
assert abs(at) < 0.3 * min(above, -below), at
